#include "evaluation/loss_evaluation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "evaluation/pose_metrics.h"
#include "predictive_stereo/pipeline.h"
#include "predictive_stereo/rigid_motion.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

// Poses of the frames that arrived.
using Run = std::map<int, PoseEstimate>;

Run run(const Sequence& sequence, const std::vector<StereoFrame>& frames,
        const EgoMotionParams& params, const Loss& loss) {
  VisualOdometry odometry(params, PipelineParams().max_gap);
  Run run;
  const cv::Mat1b black(sequence.rig().size, uchar{0});
  for (int i = 0; i < static_cast<int>(frames.size()); ++i) {
    StereoFrame frame = frames[static_cast<size_t>(i)];
    if (loss.contains(i)) {
      if (loss.kind == Loss::Kind::kMissing) continue;
      if (loss.kind == Loss::Kind::kSwapped) std::swap(frame.left, frame.right);
      if (loss.kind == Loss::Kind::kBlack) frame.left = frame.right = black;
    }
    run[i] = odometry.process(frame).pose;
  }
  return run;
}

double sigmaAlong(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d direction = error.stableNormalized();
  return std::sqrt(direction.dot(covariance * direction));
}

// @param T_first_cam  true pose in the first frame's.
PoseCheckpoint check(const PoseEstimate& pose, const Eigen::Isometry3d& T_first_cam) {
  const Vector6d error = perturbation(pose.T_odom_cam.inverse(), T_first_cam.inverse());
  PoseCheckpoint result;
  result.error_m = error.head<3>().norm();
  result.error_rad = error.tail<3>().norm();
  result.sigma_m = sigmaAlong(error.head<3>(), pose.covariance.topLeftCorner<3, 3>());
  result.sigma_rad = sigmaAlong(error.tail<3>(), pose.covariance.bottomRightCorner<3, 3>());
  return result;
}

LossResult summarize(const Loss& loss, const Run& run, const Poses& truth) {
  LossResult result;
  result.name = loss.name;
  for (const Loss::Span& span : loss.spans) {
    const Eigen::Isometry3d unseen = relative(truth[static_cast<size_t>(span.first - 1)],
                                              truth[static_cast<size_t>(span.first + span.frames)]);
    result.unseen_m += unseen.translation().norm();
    result.unseen_rad += Eigen::AngleAxisd(unseen.linear()).angle();
  }
  const int first = loss.spans.empty() ? 0 : loss.spans.front().first;
  const int last = loss.spans.empty() ? 0 : loss.spans.back().first + loss.spans.back().frames - 1;
  bool found = false;
  for (const auto& [frame, pose] : run) {
    if (frame < first) continue;
    const PoseCheckpoint here =
        check(pose, relative(truth.front(), truth[static_cast<size_t>(frame)]));
    result.worst_translation_ratio =
        std::max(result.worst_translation_ratio, here.translationRatio());
    result.worst_rotation_ratio = std::max(result.worst_rotation_ratio, here.rotationRatio());
    if (frame == last) result.end = here;
    if (frame > last && !found && pose.state == PoseState::kKnown) {
      result.after = here;
      found = true;
    }
  }
  return result;
}

}  // namespace

bool Loss::contains(int index) const {
  return std::any_of(spans.begin(), spans.end(), [&](const Span& span) {
    return index >= span.first && index < span.first + span.frames;
  });
}

std::vector<Loss> usualLosses(int frames, double seconds_per_frame) {
  constexpr int kLead = 4, kTail = 3;  // frames before and after
  std::vector<Loss> losses;
  const auto add = [&](const std::string& name, Loss::Kind kind, int length, int times) {
    constexpr int kBetween = 4;
    const int whole = times * length + (times - 1) * kBetween;
    const int first = std::max(kLead, (frames - whole) / 2);
    if (first + whole + kTail > frames) return;
    Loss loss{name, kind, {}};
    for (int i = 0; i < times; ++i) loss.spans.push_back({first + i * (length + kBetween), length});
    losses.push_back(loss);
  };
  const auto count = [](int n) { return std::to_string(n); };
  for (const int n : {1, 2, 5, 10, 25}) add("black " + count(n), Loss::Kind::kBlack, n, 1);
  for (const int n : {1, 5, 25}) add("swapped " + count(n), Loss::Kind::kSwapped, n, 1);
  const int gap = static_cast<int>(std::ceil(2 / seconds_per_frame)) - 1;
  add("missing 2 s", Loss::Kind::kMissing, gap, 1);
  for (const int n : {2, 12}) add("black 3 x " + count(n), Loss::Kind::kBlack, n, 3);
  add("swapped 3 x 12", Loss::Kind::kSwapped, 12, 3);
  add("missing 2 x 2 s", Loss::Kind::kMissing, gap, 2);
  return losses;
}

std::vector<LossResult> evaluateLosses(const Sequence& sequence, const EgoMotionParams& params,
                                       const std::vector<Loss>& losses, int frames) {
  std::vector<StereoFrame> input;
  for (int i = 0; i < frames; ++i) input.push_back(stereoFrame(sequence, i, sequence.frame(i)));
  const Run undisturbed = run(sequence, input, params, {"none", {}, {}});
  Poses truth;
  if (sequence.hasExactPoses())
    truth = *sequence.poses();
  else
    for (const auto& [frame, pose] : undisturbed) truth.push_back(pose.T_odom_cam);
  std::vector<LossResult> results{summarize({"none", {}, {}}, undisturbed, truth)};
  Progress progress(sequence.name(), static_cast<int>(losses.size()));
  for (size_t i = 0; i < losses.size(); ++i) {
    results.push_back(summarize(losses[i], run(sequence, input, params, losses[i]), truth));
    progress.update(static_cast<int>(i));
  }
  return results;
}

}  // namespace predictive_stereo
