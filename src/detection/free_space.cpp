#include "detection/free_space.h"

#include <algorithm>
#include <iterator>

#include "detection/constants.h"
#include "detection/patches.h"
#include "parallel/tasks.h"
#include "predictive_stereo/rigid_motion.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/free_space.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "detection/row_motion-inl.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Short loops without branches over kChunk cells at a time, see frame_comparison.cpp.
constexpr int kChunk = 64;

// What is known of a chunk of cells.
struct Cells {
  int first, count;
  const float *d, *variance, *width;
  float depth[kChunk];
  int32_t through[kChunk], same[kChunk], came_back[kChunk], through_by[kChunk];
};

// Where the cells were in a past frame.
struct Places {
  float expected[kChunk], variance[kChunk];  // disparity, and variance of its difference
  int32_t offset[kChunk], inside[kChunk];
};

HWY_INLINE void placesOf(const SightRow& row, const PastSight& past, const Cells& cells,
                         Places& places) {
  const RowMotion motion(past, row.y);
  constexpr float kPerStep = 1.0f / kLatticeStep_px;
  const float per_fB = 1 / row.disparity_times_depth, per_focal = 1 / row.focal_px;
  const DepthNoiseOfRow noise = past.noise;
  constexpr float kVariances = kSigmas * kSigmas;
  constexpr float kOfMaps_px2 = kDisparitySigma_px * kDisparitySigma_px,
                  kOfScale = kScaleSigma * kScaleSigma;
  const int x0 = kCellCentre_px + kCellSide_px * cells.first;
  for (int i = 0; i < cells.count; ++i) {
    const auto x = static_cast<float>(x0 + kCellSide_px * i);
    const float d = cells.d[i];
    const float per_w = 1 / motion.w(x, d);
    const float column = motion.x(x, d) * per_w * kPerStep + 0.5f;
    const float line = motion.y(x, d) * per_w * kPerStep + 0.5f;
    const float expected = motion.d(x, d) * per_w;
    places.offset[i] = motion.offset(column, line, expected > 0, places.inside[i]);
    places.expected[i] = expected;
    const float of_depth = noise.variance((x - row.cx_px) * per_focal, cells.depth[i]);
    const float by_depth = expected * expected * per_fB;
    places.variance[i] =
        kVariances * (cells.variance[i] + kOfMaps_px2 + by_depth * by_depth * of_depth +
                      kOfScale * expected * expected);
  }
}

HWY_INLINE void addSights(const PastSight& past, int number, const Places& places, Cells& cells) {
  float nearest[kChunk], farthest[kChunk];
  for (int i = 0; i < cells.count; ++i) {
    nearest[i] = past.nearest_px[places.offset[i]];
    farthest[i] = past.farthest_px[places.offset[i]];
  }
  for (int i = 0; i < cells.count; ++i) {
    const float expected = places.expected[i], variance = places.variance[i];
    const float behind = expected - nearest[i], before = farthest[i] - expected;
    const int32_t known = places.inside[i] & (nearest[i] > 0 ? 1 : 0);
    // Within what was measured around the place: the same, whatever the noise.
    const int32_t within = ((before <= 0) & (behind <= 0)) ? 1 : 0;
    const int32_t farther = ((behind > 0) & (behind * behind > variance)) ? 1 : 0;
    const int32_t not_nearer = ((before < 0) | (before * before < variance)) ? 1 : 0;
    const int32_t thin = cells.width[i] * expected < kThinnest_px * cells.d[i] ? 1 : 0;
    const int32_t is_through = known & (1 - within) & farther & (1 - thin);
    const int32_t is_same = known & (within | ((1 - farther) & not_nearer));
    cells.through_by[i] =
        is_through & (cells.through[i] == 0 ? 1 : 0) ? number : cells.through_by[i];
    cells.through[i] += is_through;
    cells.same[i] += is_same;
    cells.came_back[i] += is_same & (cells.through[i] > 0 ? 1 : 0);
  }
}

HWY_NOINLINE void sightsRow(const SightRow& row, const PastSight* past, int count,
                            uint8_t* HWY_RESTRICT through_by, uint8_t* HWY_RESTRICT fixed) {
  Cells cells;
  Places places;
  for (cells.first = 0; cells.first < row.cells; cells.first += kChunk) {
    const int n = std::min(kChunk, row.cells - cells.first);
    cells.count = n;
    cells.d = row.disparity_px + cells.first;
    cells.variance = row.variance_px2 + cells.first;
    cells.width = row.width_px + cells.first;
    for (int i = 0; i < n; ++i) cells.depth[i] = row.disparity_times_depth / cells.d[i];
    for (int32_t* counts : {cells.through, cells.same, cells.came_back, cells.through_by})
      std::fill_n(counts, n, 0);
    for (int k = 0; k < count; ++k) {
      placesOf(row, past[k], cells, places);
      addSights(past[k], k + 1, places, cells);
    }
    for (int i = 0; i < n; ++i) {
      const int32_t known = cells.d[i] > 0 ? 1 : 0;
      const bool often =
          (cells.through[i] >= kFewestThrough) & (cells.through[i] > cells.came_back[i]);
      const int32_t enough = often ? known : 0;
      through_by[cells.first + i] = static_cast<uint8_t>(enough * cells.through_by[i]);
      fixed[cells.first + i] = static_cast<uint8_t>(-(known & (cells.same[i] > 0 ? 1 : 0)));
    }
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(sightsRow);

constexpr int kLags[] = {2, 3, 5, 8, 13};  // remembered frames that are compared

}  // namespace

void sightsRow(const SightRow& row, const PastSight* past, int count, uint8_t* through_by,
               uint8_t* fixed) {
  HWY_DYNAMIC_DISPATCH(sightsRow)(row, past, count, through_by, fixed);
}

PastSight FreeSpace::sightOf(const StereoRig& rig, const Lag& lag, int y) {
  const Remembered& past = lag.past;
  const cv::Mat1f& map = past.nearest_px;
  return {{lag.into_past.H().data(), static_cast<int>(map.step1()), map.cols, map.rows},
          map[0],
          past.farthest_px[0],
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
bool FreeSpace::isRefuted(const Lag& lag, const cv::Mat1b& half_image,
                          const Eigen::Vector3f& cell) {
  const GreyPatch now(half_image, cell.x() / kLatticeStep_px, cell.y() / kLatticeStep_px);
  const auto looksLike = [&](const Eigen::Vector3f& at_px, float scale) {
    return now.differenceFrom(lag.past.half_image, at_px.x() / kLatticeStep_px,
                              at_px.y() / kLatticeStep_px, scale) < kMostDifference;
  };
  // The surface was there, and its disparity was not measured.
  Eigen::Vector3f at = lag.into_past(cell.x(), cell.y(), cell.z());
  if (looksLike(at, at.z() / cell.z())) return true;
  // The background is still there, and the current disparity is wrong. Its place in the past image
  // depends on its own disparity.
  const cv::Mat1f& farthest_px = lag.past.farthest_px;
  const cv::Point p(cvRound(at.x() / kLatticeStep_px), cvRound(at.y() / kLatticeStep_px));
  if (!cv::Rect(cv::Point(), farthest_px.size()).contains(p)) return false;
  const float background = farthest_px(p);
  if (!(background > 0)) return false;
  const Eigen::Vector3f seen_now = lag.into_now(at.x(), at.y(), background);
  if (!(seen_now.z() > 0)) return false;
  at.x() += cell.x() - seen_now.x();
  at.y() += cell.y() - seen_now.y();
  return looksLike(at, background / seen_now.z());
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
                         y,
                         static_cast<float>(rig.cx_left_px),
                         static_cast<float>(rig.fx_px),
                         disparity_times_depth};
      uchar *const moved = evidence_.moved[v], *const fixed = evidence_.fixed[v];
      sightsRow(row, past.data(), static_cast<int>(lags.size()), moved, fixed);
      for (int u = 0; u < row.cells; ++u) {
        if (moved[u] == 0) continue;
        const Eigen::Vector3f cell(static_cast<float>(kCellSide_px * u + kCellCentre_px),
                                   static_cast<float>(y), row.disparity_px[u]);
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
#endif
