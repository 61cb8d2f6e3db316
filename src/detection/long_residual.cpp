#include "detection/long_residual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detection/constants.h"
#include "detection/depth_cells.h"
#include "parallel/tasks.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/long_residual.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "detection/row_motion-inl.h"

#ifndef PREDICTIVE_STEREO_LONG_ROW
#define PREDICTIVE_STEREO_LONG_ROW
namespace predictive_stereo {

// Computes the parallax to a past camera, from its position in the current camera's frame and the
// rig.
struct PastCamera {
  float x_m, y_m, z_m;
  float focal_px, cx_px, cy_px, disparity_times_depth;

  // Motion [px] of a static point in the image since then, without that of the camera's rotation;
  // infinity if the point was behind the camera.
  float parallax(float x, float y, float d) const {
    const float depth = disparity_times_depth - d * z_m;  // past depth times d
    const float across = std::abs((x - cx_px) * z_m - focal_px * x_m);
    const float down = std::abs((y - cy_px) * z_m - focal_px * y_m);
    const float moved = d * std::max(across, down) / depth;
    return depth > 0 ? moved : std::numeric_limits<float>::infinity();
  }
};

struct PastDisparities : PastMap {
  const float* disparity_px;
};

struct PastPairOfRow {
  PastCamera camera;
  PastDisparities past, halfway;
  float scale;  // time since the past frame / time since the halfway frame
};

struct LongRow {
  const float* cells_px;
  int y, cells;
  const PastPairOfRow* pairs;
  int pair_count;
  float smallest_valid_px, most_parallax_px;
};

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Short loops without branches over kChunk points at a time, see frame_comparison.cpp.
constexpr int kChunk = 64;

struct Chunk {
  int x0, count;  // column [px] of the first cell
  const float* d;
};

struct Residuals {
  float value[kChunk];
  int32_t known[kChunk];
};

// Past disparities of static points minus measured ones.
HWY_INLINE void residualsAtPast(const LongRow& row, const PastDisparities& then, const Chunk& cells,
                                Residuals& residuals) {
  const RowMotion motion(then, row.y);
  const float smallest = row.smallest_valid_px;
  float expected[kChunk], measured[kChunk];
  int32_t offset[kChunk], inside[kChunk];
  for (int i = 0; i < cells.count; ++i) {
    const auto x = static_cast<float>(cells.x0 + kCellSide_px * i);
    const float d = cells.d[i];
    const float w = motion.w(x, d);
    const float column = motion.x(x, d) / w + 0.5f, line = motion.y(x, d) / w + 0.5f;
    expected[i] = motion.d(x, d) / w;
    offset[i] = motion.offset(column, line, expected[i] > 0, inside[i]);
  }
  for (int i = 0; i < cells.count; ++i) measured[i] = then.disparity_px[offset[i]];
  for (int i = 0; i < cells.count; ++i) {
    residuals.value[i] = expected[i] - measured[i];
    residuals.known[i] = ((inside[i] != 0) & (measured[i] >= smallest)) ? 1 : 0;
  }
}

// The first pair with little enough parallax, for each cell; -1: none.
HWY_INLINE void choosePairs(const LongRow& row, const Chunk& cells, int32_t* HWY_RESTRICT pair) {
  const auto y = static_cast<float>(row.y);
  const float most = row.most_parallax_px;
  for (int i = 0; i < cells.count; ++i) pair[i] = -1;
  for (int k = row.pair_count - 1; k >= 0; --k) {
    const PastCamera camera = row.pairs[k].camera;
    for (int i = 0; i < cells.count; ++i) {
      const float d = cells.d[i];
      const float moved = camera.parallax(static_cast<float>(cells.x0 + kCellSide_px * i), y, d);
      pair[i] = ((moved <= most) & (d > 0)) ? k : pair[i];
    }
  }
}

HWY_NOINLINE void longResidualRow(const LongRow& row, float* HWY_RESTRICT residual_px,
                                  uint8_t* HWY_RESTRICT pair) {
  Residuals far, near;
  int32_t chosen[kChunk];
  for (int first = 0; first < row.cells; first += kChunk) {
    const Chunk cells{kCellCentre_px + kCellSide_px * first, std::min(kChunk, row.cells - first),
                      row.cells_px + first};
    float* HWY_RESTRICT out = residual_px + first;
    std::fill_n(out, cells.count, kUnknownResidual);
    choosePairs(row, cells, chosen);
    for (int k = 0; k < row.pair_count; ++k) {
      int32_t any = 0;
      for (int i = 0; i < cells.count; ++i) any |= chosen[i] == k ? 1 : 0;
      if (any == 0) continue;
      const PastPairOfRow& of_row = row.pairs[k];
      residualsAtPast(row, of_row.past, cells, far);
      residualsAtPast(row, of_row.halfway, cells, near);
      const float scale = of_row.scale;
      for (int i = 0; i < cells.count; ++i) {
        const float f = far.value[i], n = near.value[i] * scale;
        const float smaller = std::abs(n) < std::abs(f) ? n : f;
        const float both = n * f <= 0 ? 0.0f : smaller;
        out[i] = ((chosen[i] == k) & (far.known[i] != 0) & (near.known[i] != 0)) ? both : out[i];
      }
    }
    for (int i = 0; i < cells.count; ++i)
      pair[first + i] = chosen[i] < 0 ? kNoPair : static_cast<uint8_t>(chosen[i]);
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(longResidualRow);

PastCamera cameraOf(const StereoRig& rig, const PastFrame& past) {
  const Eigen::Vector3f position = past.T_past_cam.inverse().translation().cast<float>();
  return {position.x(),
          position.y(),
          position.z(),
          static_cast<float>(rig.fx_px),
          static_cast<float>(rig.cx_left_px),
          static_cast<float>(rig.cy_px),
          static_cast<float>(rig.disparityTimesDepth())};
}

PastDisparities disparitiesOf(const PastFrame& past, const SourceOf& source_of) {
  const cv::Mat1f& map = past.frame->disparity_px;
  return {{source_of.H().data(), static_cast<int>(map.step1()), map.cols, map.rows}, map[0]};
}

}  // namespace

void longResidual(const StereoRig& rig, const cv::Mat1f& cells_px, const DisparityRange& range,
                  const std::vector<PastPair>& pairs, double most_px, cv::Mat1f& residual_px,
                  cv::Mat1b& pair) {
  std::vector<SourceOf> sources;  // two for each pair: past and halfway frame
  for (const PastPair& p : pairs)
    for (const PastFrame* frame : {&p.past, &p.halfway})
      sources.emplace_back(disparityMotion(rig, frame->T_past_cam));
  std::vector<PastPairOfRow> of_row;
  for (size_t k = 0; k < pairs.size(); ++k)
    of_row.push_back({cameraOf(rig, pairs[k].past), disparitiesOf(pairs[k].past, sources[2 * k]),
                      disparitiesOf(pairs[k].halfway, sources[2 * k + 1]),
                      static_cast<float>(pairs[k].past.seconds / pairs[k].halfway.seconds)});
  residual_px.create(cells_px.size());
  pair.create(cells_px.size());
  parallelForEach(cells_px.rows, [&](int v) {
    HWY_DYNAMIC_DISPATCH(longResidualRow)
    ({cells_px[v], kCellSide_px * v + kCellCentre_px, cells_px.cols, of_row.data(),
      static_cast<int>(of_row.size()), static_cast<float>(range.min_disparity),
      static_cast<float>(most_px)},
     residual_px[v], pair[v]);
  });
}

}  // namespace predictive_stereo
#endif
