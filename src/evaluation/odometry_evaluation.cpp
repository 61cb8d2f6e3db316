#include "evaluation/odometry_evaluation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "evaluation/report.h"
#include "evaluation/statistics.h"
#include "predictive_stereo/pipeline.h"
#include "predictive_stereo/rigid_motion.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

void requireEqual(size_t estimated, size_t truth) {
  if (estimated != truth)
    throw std::invalid_argument(std::to_string(estimated) + " estimated and " +
                                std::to_string(truth) +
                                " true poses or motions: give as many of each");
}

double angle(const Eigen::Matrix3d& rotation) { return Eigen::AngleAxisd(rotation).angle(); }

// Length [m] of the path up to each pose.
std::vector<double> travelled(const Poses& poses) {
  std::vector<double> travelled_m(poses.size(), 0.0);
  for (size_t i = 1; i < poses.size(); ++i)
    travelled_m[i] =
        travelled_m[i - 1] + (poses[i].translation() - poses[i - 1].translation()).norm();
  return travelled_m;
}

// @param normalized  errors of the motions that were not lost. @param ms  of all motions.
void summarize(const std::vector<double>& normalized, const std::vector<double>& ms,
               OdometryEvaluation& e) {
  e.length_m = travelled(e.truth).back();
  e.length_error_percent =
      e.length_m > 0 ? 100 * (travelled(e.estimated).back() / e.length_m - 1) : NAN;
  e.relative = relativePoseErrors(e.estimated, e.truth, {5, 10, 20, 50, 100});
  e.mean = meanMotionError(e.estimated, e.truth);
  e.mean_normalized_error = mean(normalized);
  e.median_normalized_error = nearestQuantile(normalized, 0.5);
  e.mean_ms = mean(ms);
  e.median_ms = nearestQuantile(ms, 0.5);
  e.p95_ms = nearestQuantile(ms, 0.95);
}

}  // namespace

MotionError motionError(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d difference = relative(estimated, truth);
  return {difference.translation().norm(), angle(difference.linear())};
}

MotionError meanMotionError(const Poses& estimated, const Poses& truth) {
  requireEqual(estimated.size(), truth.size());
  MotionError sum;
  for (size_t i = 1; i < truth.size(); ++i) {
    const MotionError error =
        motionError(relative(estimated[i], estimated[i - 1]), relative(truth[i], truth[i - 1]));
    sum.translation_m += error.translation_m;
    sum.rotation_rad += error.rotation_rad;
  }
  return {ratio(sum.translation_m, truth.size() - 1), ratio(sum.rotation_rad, truth.size() - 1)};
}

std::vector<RelativePoseError> relativePoseErrors(const Poses& estimated, const Poses& truth,
                                                  const std::vector<double>& lengths_m) {
  requireEqual(estimated.size(), truth.size());
  const std::vector<double> travelled_m = travelled(truth);
  std::vector<RelativePoseError> errors;
  for (const double length_m : lengths_m) {
    RelativePoseError error;
    error.length_m = length_m;
    for (size_t first = 0, last = 0; first < truth.size(); ++first) {
      while (last < truth.size() && travelled_m[last] < travelled_m[first] + length_m) ++last;
      if (last == truth.size()) break;
      const MotionError difference = motionError(relative(estimated[first], estimated[last]),
                                                 relative(truth[first], truth[last]));
      error.translation_percent += 100 * difference.translation_m / length_m;
      error.rotation_deg_per_m += difference.rotation_rad * 180 / M_PI / length_m;
      ++error.stretches;
    }
    error.translation_percent = ratio(error.translation_percent, error.stretches);
    error.rotation_deg_per_m = ratio(error.rotation_deg_per_m, error.stretches);
    errors.push_back(error);
  }
  return errors;
}

Vector6d perturbation(const Eigen::Isometry3d& estimated, const Eigen::Isometry3d& truth) {
  const Eigen::Isometry3d difference = compose(truth, estimated.inverse());
  const Eigen::AngleAxisd rotation(difference.linear());
  Vector6d error;
  error << difference.translation(), rotation.angle() * rotation.axis();
  return error;
}

double normalizedErrorSquared(const CameraMotion& estimated, const Eigen::Isometry3d& truth) {
  const Vector6d error = perturbation(estimated.T_cam_prev, truth);
  const Eigen::LLT<Matrix6d> cholesky(estimated.covariance);
  if (cholesky.info() != Eigen::Success)
    throw std::invalid_argument("normalizedErrorSquared: the covariance must be positive definite");
  return error.dot(cholesky.solve(error));
}

OdometryEvaluation evaluateOdometry(const Sequence& sequence, const EgoMotionParams& params,
                                    int max_frames) {
  const auto poses = sequence.poses();
  if (!poses)
    throw std::runtime_error(sequence.name() +
                             ": has no true poses; a drive needs oxts or poses_gt_cam0.txt");
  const int frames = framesOf(sequence, max_frames);
  OdometryEvaluation e;
  e.name = sequence.name();
  e.truth.assign(poses->begin(), poses->begin() + frames);
  e.estimated = {e.truth.front()};
  std::vector<double> normalized, ms;
  size_t last_good = 0;  // last frame whose pose was known
  VisualOdometry odometry(params, PipelineParams().max_gap);
  Progress progress(sequence.name(), frames);
  for (int index = 0; index < frames; ++index) {
    const SequenceFrame frame = sequence.frame(index);
    const OdometryOutput& output = odometry.process(stereoFrame(sequence, index, frame));
    const EgoMotionEstimate& estimate = output.ego_motion;
    progress.update(index);
    e.estimates.push_back(estimate);
    if (index == 0) continue;
    const auto i = static_cast<size_t>(index);
    const bool tracked = output.motion_start.has_value();
    const size_t start = tracked ? i - static_cast<size_t>(estimate.frames) : last_good;
    const Eigen::Isometry3d truth = relative(e.truth[i], e.truth[start]);
    e.estimated.push_back(compose(e.truth.front(), output.pose.T_odom_cam));
    const Eigen::Isometry3d found =
        tracked ? estimate.motion.T_cam_prev : relative(e.estimated[i], e.estimated[start]);
    const MotionError error = motionError(found, truth);
    e.largest.translation_m = std::max(e.largest.translation_m, error.translation_m);
    e.largest.rotation_rad = std::max(e.largest.rotation_rad, error.rotation_rad);
    ms.push_back(odometry.times().front().ms);
    if (tracked)
      normalized.push_back(normalizedErrorSquared(estimate.motion, truth) / 6);
    else
      ++e.lost;
    if (output.pose.state == PoseState::kKnown) last_good = i;
  }
  summarize(normalized, ms, e);
  return e;
}

std::string pathsCsv(const std::vector<OdometryEvaluation>& evaluations) {
  Table csv = Table::ofCsv(
      "sequence,frame,true_right_m,true_down_m,true_ahead_m,estimated_right_m,estimated_down_m,"
      "estimated_ahead_m");
  for (const OdometryEvaluation& e : evaluations)
    for (size_t i = 0; i < e.truth.size(); ++i) {
      const auto seen = [&](const Poses& poses) {
        const Eigen::Vector3d p_m = e.truth.front().inverse() * poses[i].translation();
        return row(p_m.x(), p_m.y(), p_m.z());
      };
      csv.add(e.name, i, seen(e.truth), seen(e.estimated));
    }
  return csv.csv();
}

}  // namespace predictive_stereo
