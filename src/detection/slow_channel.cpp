#include "detection/slow_channel.h"

#include <algorithm>
#include <cmath>

#include "detection/candidates.h"

namespace predictive_stereo {
namespace {

using Source = Hypothesis::Source;

// Frames that are compared, as far as static points have not moved more since then.
constexpr size_t kFramesBack[] = {8, 6, 4, 2};
static_assert(kFramesBack[0] == FrameHistory::kFarthest);
constexpr double kMostParallax_px = 16;
// Of what is told by disparities: how much better its motion explains those of the past, what it
// leaves unexplained, and the share of them that tells; see LayerMotion.
constexpr double kLeastGain = 1, kMostCost = 4, kLeastKnown = 0.25;
// Squared ratio of its way to its error, and of the errors by which the way to the frame halfway
// may differ; 40 m/s.
constexpr double kLeastWay = 16, kMostDeviation = 12, kLargestSpeed_mps = 40;
constexpr float kLeastDisparity_px = 10;  // errors are too large a share of smaller ones
constexpr int kLeastContrast_grey = 6;    // over 3x3 points that can be found again

// Whether at least a third of the points lie on something that can be found again.
bool hasTexture(const cv::Mat1b& image, const std::vector<cv::Point>& points) {
  int textured = 0;
  for (cv::Point p : points) {
    int darkest = 255, brightest = 0;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int grey =
            image(std::clamp(p.y + dy, 0, image.rows - 1), std::clamp(p.x + dx, 0, image.cols - 1));
        darkest = std::min(darkest, grey);
        brightest = std::max(brightest, grey);
      }
    textured += brightest - darkest >= kLeastContrast_grey;
  }
  return 3 * textured >= static_cast<int>(points.size());
}

// Whether what moved so since the far past did its share of it since the frame halfway, and whether
// the way is longer than errors are.
bool goesOn(const FrameView& frame, const PastPair& pair, const GroupMotion& motion) {
  const PastFrame &past = pair.past, &halfway = pair.halfway;
  const Displacement& fit = motion.fit;
  if (fit.moved_m.norm() > kLargestSpeed_mps * past.seconds) return false;
  if (fit.moved_m.dot(fit.covariance.inverse() * fit.moved_m) < kLeastWay) return false;
  const double share = halfway.seconds / past.seconds;
  const auto tracks = followPoints(frame.trackingInto(halfway), frame.params, motion.sample_px,
                                   static_cast<float>(share) * motion.shift_px);
  if (static_cast<int>(tracks.size()) < frame.params.min_tracks) return false;
  const Displacement half = fitDisplacement(frame.input.rig, frame.params, tracks);
  if (static_cast<int>(half.inliers.size()) < frame.params.min_tracks) return false;
  const Eigen::Matrix3d R = (past.T_past_cam * halfway.T_past_cam.inverse()).linear();
  const Eigen::Vector3d difference = R * half.moved_m - share * fit.moved_m;
  const Eigen::Matrix3d covariance =
      R * half.covariance * R.transpose() + share * share * fit.covariance;
  return difference.dot(covariance.inverse() * difference) < kMostDeviation;
}

}  // namespace

void SlowChannel::setFrame(const FrameView& frame, const std::vector<PastFrame>& past) {
  pairs_.clear();
  for (size_t k : kFramesBack)
    if (k <= past.size()) pairs_.push_back({past[k - 1], past[k / 2 - 1]});
  history_.emplace(frame.input.rig, frame.range, frame.input.measured_disparity_px, past);
}

void SlowChannel::find(const FrameView& frame, Verification& verification) {
  if (pairs_.empty()) return;
  longResidual(frame.input.rig, frame.input.measured_disparity_px, frame.range, pairs_,
               kMostParallax_px, frame.lattice(), residual_px_, pair_);
  const auto groups = firstFew(
      kMostSlow,
      groups_.findSlow(residual_px_, pair_, frame.input.measured_disparity_px, frame.params),
      [&](const DenseGroup& group) {
        return group.disparity_px >= kLeastDisparity_px &&
                       hasTexture(frame.current.pyramid.level(1), group.points)
                   ? std::optional(&group)
                   : std::nullopt;
      });
  const auto added = verification.addAll(
      frame, static_cast<int>(groups.size()), [&](int i, VerificationWork& work) {
        return byTracks(frame, *groups[static_cast<size_t>(i)], verification, work);
      });

  std::vector<size_t> rest;
  for (size_t i = 0; i < groups.size(); ++i)
    if (!added[i]) rest.push_back(i);
  const auto others = firstFew(kMostFits, rest, [&](size_t i) -> std::optional<Hypothesis> {
    Hypothesis hypothesis;
    hypothesis.seeds = groups[i]->points;
    if (!verification.isFree(hypothesis)) return std::nullopt;
    setLayer(frame, hypothesis);
    return hypothesis;
  });
  verification.addAll(frame, static_cast<int>(others.size()), [&](int i, VerificationWork& work) {
    return byDisparities(frame, others[static_cast<size_t>(i)], {}, verification, work);
  });
}

// What its points say, followed into both frames of a pair.
std::optional<VerifiedObject> SlowChannel::byTracks(const FrameView& frame, const DenseGroup& group,
                                                    const Verification& verification,
                                                    VerificationWork& work) const {
  if (!isLargeEnough(frame, group)) return std::nullopt;
  Hypothesis hypothesis;
  hypothesis.source = Source::kDense;
  hypothesis.seeds = group.points;
  if (!verification.isFree(hypothesis)) return std::nullopt;
  setLayer(frame, hypothesis);
  // What comes towards the camera grows too much to be found again over the longest time.
  for (size_t k = pair_(group.points.front()); k < pairs_.size(); ++k) {
    const auto motion = motionOf(frame, pairs_[k].past, group);
    if (!motion || !goesOn(frame, pairs_[k], *motion)) continue;
    hypothesis.moved_m = motion->fit.moved_m;
    hypothesis.covariance = motion->fit.covariance;
    if (auto found = verify(frame, pairs_[k].past, hypothesis, nullptr, verification, work))
      return found;
  }
  return std::nullopt;
}

// What disparities of several frames say.
std::optional<VerifiedObject> SlowChannel::byDisparities(
    const FrameView& frame, Hypothesis hypothesis,
    const std::optional<Eigen::Vector3d>& expected_mps, const Verification& verification,
    VerificationWork& work) const {
  const cv::Mat1f& disparity_px = frame.input.measured_disparity_px;
  std::vector<cv::Point> points = sampleOf(hypothesis.seeds);
  points.erase(std::remove_if(points.begin(), points.end(),
                              [&](cv::Point p) {
                                return std::abs(disparity_px(p) - hypothesis.disparity_px) >
                                       1 + 0.05f * hypothesis.disparity_px;
                              }),
               points.end());
  const auto motion = history_->fit(points, expected_mps);
  if (!motion) return std::nullopt;
  // Images are compared over a short time: of where it was longer ago too little is known.
  const PastFrame& past = pairs_.back().past;
  const Eigen::Vector3d& velocity = motion->velocity_mps;
  if (motion->gain < kLeastGain || motion->known < kLeastKnown || motion->cost > kMostCost ||
      velocity.dot(motion->covariance.inverse() * velocity) < kLeastWay ||
      velocity.norm() * past.seconds < frame.params.min_displacement_m)
    return std::nullopt;
  const Eigen::Matrix3d R = past.T_past_cam.linear();
  hypothesis.source = Source::kSlow;
  hypothesis.velocity_mps = velocity;
  hypothesis.moved_m = R * velocity * past.seconds;
  hypothesis.covariance = R * motion->covariance * R.transpose() * past.seconds * past.seconds;
  return verify(frame, past, hypothesis, &*history_, verification, work);
}

void SlowChannel::findKnown(const FrameView& frame, const std::vector<const ObjectTrack*>& known,
                            Verification& verification) const {
  const StereoRig& rig = frame.input.rig;
  const auto find = [&](int i, VerificationWork& work) -> std::optional<VerifiedObject> {
    const ObjectTrack& track = *known[static_cast<size_t>(i)];
    if (!(track.last.centre_m.z() > 0.5)) return std::nullopt;
    const int pair =
        pairWithin(rig, pairs_, rig.disparityFromPoint(track.last.centre_m), kMostParallax_px);
    if (pair < 0) return std::nullopt;
    const auto hypothesis = hypothesisOf(frame, pairs_[static_cast<size_t>(pair)].past, track);
    if (!hypothesis || !verification.isFree(*hypothesis)) return std::nullopt;
    return byDisparities(frame, *hypothesis, hypothesis->velocity_mps, verification, work);
  };
  verification.addAll(frame, static_cast<int>(known.size()), find);
}

// Against a frame farther back, with the static world as far as the hypothesis needs it.
std::optional<VerifiedObject> SlowChannel::verify(const FrameView& frame, const PastFrame& past,
                                                  const Hypothesis& hypothesis,
                                                  const DisparityHistory* history,
                                                  const Verification& verification,
                                                  VerificationWork& work) const {
  compareFrames(frame.current.pyramid, frame.input.measured_disparity_px, frame.range,
                past.frame->pyramid, frame.staticSource(past),
                reachOf(frame.input.rig, frame.params, hypothesis, frame.lattice()),
                work.static_world);
  return verification.verify(frame, {past, work.static_world, residual_px_}, hypothesis, history,
                             work);
}

}  // namespace predictive_stereo
