#include "detection/free_space.h"

#include <algorithm>
#include <iterator>

#include "detection/patch_difference.h"
#include "parallel/tasks.h"
#include "predictive_stereo/rigid_motion.h"

namespace predictive_stereo {
namespace {

constexpr double kLeastApart_s = 0.08;     // between remembered frames
constexpr double kLongestGap_s = 1;        // a longer one ends the past
constexpr int kLags[] = {2, 3, 5, 8, 13};  // remembered frames that are compared
constexpr float kFarthest_m = 40;          // of cells that are compared
// Mean squared difference of patches, relative to its variance, up to which they are the same.
constexpr float kMostDifference = 6;
constexpr int kBackgroundSteps = 3;

cv::Point latticePoint(const Eigen::Vector3f& at_px) {
  return {cvRound(at_px.x() / kLatticeStep_px), cvRound(at_px.y() / kLatticeStep_px)};
}

bool isInside(const cv::Mat1f& map, cv::Point p) {
  return p.x >= 0 && p.y >= 0 && p.x < map.cols && p.y < map.rows;
}

}  // namespace

PastSight FreeSpace::sightOf(const StereoRig& rig, const Lag& lag, int y) {
  const Remembered& past = lag.past;
  return {lag.into_past.H().data(),
          past.nearest_px[0],
          past.farthest_px[0],
          static_cast<int>(past.nearest_px.step1()),
          past.nearest_px.cols,
          past.nearest_px.rows,
          lag.noise.along(static_cast<float>((y - rig.cy_px) / rig.fy_px))};
}

std::vector<FreeSpace::Lag> FreeSpace::lagsOf(const DetectionInput& input) const {
  std::vector<Lag> lags;
  for (int k : kLags) {
    if (k > count_) break;
    const Remembered& past = frames_[static_cast<size_t>(k - 1)];
    const Eigen::Isometry3d T_past_cam = relative(past.T_odom_cam, input.T_odom_cam);
    lags.push_back({SourceOf(disparityMotion(input.rig, T_past_cam)),
                    SourceOf(disparityMotion(input.rig, T_past_cam.inverse())),
                    PastDepthNoise(T_past_cam, past.motion_since.covariance()), past});
  }
  return lags;
}

// The motion's error since the frame before this one, in this one's coordinates.
void FreeSpace::continueMotions(const DetectionInput& input) {
  const CameraMotion motion{relative(input.T_odom_cam, T_odom_last_),
                            toldCovariance(input.motion_covariance)};
  for (Remembered& frame : frames_) frame.motion_since.add(motion, CommonErrors::Zero());
  T_odom_last_ = input.T_odom_cam;
}

// Whether a past image contradicts that the surface has come since then.
bool FreeSpace::isRefuted(const Lag& lag, const cv::Mat1b& half_image, const Cell& cell) {
  const GreyPatchOf now(half_image, cell.x / kLatticeStep_px, cell.y / kLatticeStep_px);
  const auto looksLike = [&](const Eigen::Vector3f& at_px, float scale) {
    return now.differenceFrom(lag.past.half_image, at_px.x() / kLatticeStep_px,
                              at_px.y() / kLatticeStep_px, scale) < kMostDifference;
  };
  // The surface was there, and its disparity was not measured.
  Eigen::Vector3f at = lag.into_past(cell.x, cell.y, cell.disparity_px);
  if (looksLike(at, at.z() / cell.disparity_px)) return true;
  // The background is still there, and the current disparity is wrong. Its place in the past image
  // depends on its own disparity.
  float scale = 1;
  for (int step = 0; step < kBackgroundSteps; ++step) {
    const cv::Point p = latticePoint(at);
    if (!isInside(lag.past.farthest_px, p) || !(lag.past.farthest_px(p) > 0)) return false;
    const float background = lag.past.farthest_px(p);
    const Eigen::Vector3f seen_now = lag.into_now(at.x(), at.y(), background);
    if (!(seen_now.z() > 0)) return false;
    at.x() += cell.x - seen_now.x();
    at.y() += cell.y - seen_now.y();
    scale = background / seen_now.z();
  }
  return looksLike(at, scale);
}

void FreeSpace::compare(const DetectionInput& input, const DepthCells& cells,
                        const cv::Mat1b& half_image, const cv::Mat1f& width_px) {
  evidence_.moved.create(cells.disparity_px.size());
  evidence_.fixed.create(cells.disparity_px.size());
  endPastBefore(input.stamp_s);
  if (isUnseen(input.motion_covariance)) reset();
  continueMotions(input);
  const std::vector<Lag> lags = lagsOf(input);
  if (static_cast<int>(lags.size()) < kFewestThrough) {
    evidence_.moved.setTo(0);
    evidence_.fixed.setTo(0);
    return;
  }
  const StereoRig& rig = input.rig;
  const auto disparity_times_depth = static_cast<float>(rig.disparityTimesDepth());
  parallelFor(cv::Range(0, cells.disparity_px.rows), [&](const cv::Range& rows) {
    std::array<PastSight, std::size(kLags)> past;
    for (int v = rows.start; v < rows.end; ++v) {
      const int y = kCellSide_px * v + kCellCentre_px;
      for (size_t k = 0; k < lags.size(); ++k) past[k] = sightOf(rig, lags[k], y);
      const SightRow row{cells.disparity_px[v],
                         cells.variance_px2[v],
                         width_px[v],
                         cells.disparity_px.cols,
                         kCellCentre_px,
                         kCellSide_px,
                         y,
                         kLatticeStep_px,
                         static_cast<float>(rig.cx_left_px),
                         static_cast<float>(rig.fx_px),
                         disparity_times_depth};
      uchar *const moved = evidence_.moved[v], *const fixed = evidence_.fixed[v];
      sightsRow(row, past.data(), static_cast<int>(lags.size()),
                disparity_times_depth / kFarthest_m, moved, fixed);
      for (int u = 0; u < row.cells; ++u) {
        if (moved[u] == 0) continue;
        const Cell cell{static_cast<float>(kCellSide_px * u + kCellCentre_px),
                        static_cast<float>(y), row.disparity_px[u]};
        const Lag& last_through = lags[static_cast<size_t>(moved[u] - 1)];
        moved[u] = isRefuted(last_through, half_image, cell) ? 0 : 255;
        if (moved[u] != 0) fixed[u] = 0;
      }
    }
  });
}

// Forgets the past if time has not gone on since, or for too long.
void FreeSpace::endPastBefore(double stamp_s) {
  const double apart_s = stamp_s - frames_[0].stamp_s;
  if (apart_s > kLongestGap_s || apart_s <= 0) reset();
}

void FreeSpace::remember(const DetectionInput& input, DepthCells& cells,
                         const cv::Mat1b& half_image) {
  endPastBefore(input.stamp_s);
  if (count_ > 0 && input.stamp_s - frames_[0].stamp_s < kLeastApart_s) return;
  std::rotate(frames_.begin(), frames_.end() - 1, frames_.end());
  count_ = std::min(count_ + 1, kRemembered);
  Remembered& newest = frames_[0];
  newest.stamp_s = input.stamp_s;
  newest.T_odom_cam = input.T_odom_cam;
  newest.motion_since = PathCovariance();
  cv::swap(cells.nearest_px, newest.nearest_px);
  cv::swap(cells.farthest_px, newest.farthest_px);
  half_image.copyTo(newest.half_image);
}

void FreeSpace::addToDisparities(float step_px) {
  for (int k = 0; k < count_; ++k)
    for (cv::Mat1f* map : {&frames_[static_cast<size_t>(k)].nearest_px,
                           &frames_[static_cast<size_t>(k)].farthest_px})
      for (float& d : *map)
        if (d > 0) d = std::max(d + step_px, 0.0f);
}

}  // namespace predictive_stereo
