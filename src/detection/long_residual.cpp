#include "detection/long_residual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detection/constants.h"
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
  const float* disparity_px;  // of the first point; the others follow at kLongStep_px
  int y, points;
  const PastPairOfRow* pairs;
  int pair_count;
  float smallest_valid_px, most_parallax_px;
};

}  // namespace predictive_stereo
#endif

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Short loops without branches over kChunk points at a time, see frame_comparison.cpp.
constexpr int kChunk = 64;

struct Points {
  int first, count;
  float d[kChunk];
};

struct Residuals {
  float value[kChunk];
  int32_t known[kChunk];
};

// Past disparities of static points minus measured ones.
HWY_INLINE void residualsAtPast(const LongRow& row, const PastDisparities& then,
                                const Points& points, Residuals& residuals) {
  const RowMotion motion(then, row.y);
  const float smallest = row.smallest_valid_px;
  const int x0 = kLongStep_px * points.first;
  float expected[kChunk], measured[kChunk];
  int32_t offset[kChunk], inside[kChunk];
  for (int i = 0; i < points.count; ++i) {
    const auto x = static_cast<float>(x0 + kLongStep_px * i);
    const float d = points.d[i];
    const float w = motion.w(x, d);
    const float column = motion.x(x, d) / w + 0.5f, line = motion.y(x, d) / w + 0.5f;
    expected[i] = motion.d(x, d) / w;
    offset[i] = motion.offset(column, line, expected[i] > 0, inside[i]);
  }
  for (int i = 0; i < points.count; ++i) measured[i] = then.disparity_px[offset[i]];
  for (int i = 0; i < points.count; ++i) {
    const float residual = expected[i] - measured[i];
    residuals.value[i] = std::min(std::max(residual, -kLargestResidual_px), kLargestResidual_px);
    residuals.known[i] = ((inside[i] != 0) & (measured[i] >= smallest)) ? 1 : 0;
  }
}

// The first pair with little enough parallax, for each point; -1: none.
HWY_INLINE void choosePairs(const LongRow& row, const Points& points, int32_t* HWY_RESTRICT pair) {
  const auto y = static_cast<float>(row.y);
  const float most = row.most_parallax_px, smallest = row.smallest_valid_px;
  const int x0 = kLongStep_px * points.first;
  for (int i = 0; i < points.count; ++i) pair[i] = -1;
  for (int k = row.pair_count - 1; k >= 0; --k) {
    const PastCamera camera = row.pairs[k].camera;
    for (int i = 0; i < points.count; ++i) {
      const float d = points.d[i];
      const float moved = camera.parallax(static_cast<float>(x0 + kLongStep_px * i), y, d);
      pair[i] = ((moved <= most) & (d >= smallest)) ? k : pair[i];
    }
  }
}

HWY_NOINLINE void longResidualRow(const LongRow& row, float* HWY_RESTRICT residual_px,
                                  uint8_t* HWY_RESTRICT pair) {
  Points points;
  Residuals far, near;
  int32_t chosen[kChunk];
  for (points.first = 0; points.first < row.points; points.first += kChunk) {
    points.count = std::min(kChunk, row.points - points.first);
    const float* HWY_RESTRICT disparity = row.disparity_px + kLongStep_px * points.first;
    float* HWY_RESTRICT out = residual_px + points.first;
    for (int i = 0; i < points.count; ++i) {
      points.d[i] = disparity[kLongStep_px * i];
      out[i] = kUnknownResidual;
    }
    choosePairs(row, points, chosen);
    for (int k = 0; k < row.pair_count; ++k) {
      int32_t any = 0;
      for (int i = 0; i < points.count; ++i) any |= chosen[i] == k ? 1 : 0;
      if (any == 0) continue;
      const PastPairOfRow& of_row = row.pairs[k];
      residualsAtPast(row, of_row.past, points, far);
      residualsAtPast(row, of_row.halfway, points, near);
      const float scale = of_row.scale;
      for (int i = 0; i < points.count; ++i) {
        const float f = far.value[i], n = near.value[i] * scale;
        const float smaller = std::abs(n) < std::abs(f) ? n : f;
        const float both = n * f <= 0 ? 0.0f : smaller;
        out[i] = ((chosen[i] == k) & (far.known[i] != 0) & (near.known[i] != 0)) ? both : out[i];
      }
    }
    for (int i = 0; i < points.count; ++i)
      pair[points.first + i] = chosen[i] < 0 ? kNoPair : static_cast<uint8_t>(chosen[i]);
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

template <class T>
void repeatEach(const T* points, int width, T* lattice) {
  for (int i = 0; i < width / 2; ++i) lattice[2 * i] = lattice[2 * i + 1] = points[i];
  if (width % 2 != 0) lattice[width - 1] = points[width / 2];
}

}  // namespace

void longResidual(const StereoRig& rig, const cv::Mat1f& disparity_px, const DisparityRange& range,
                  const std::vector<PastPair>& pairs, double most_px, cv::Size lattice,
                  cv::Mat1f& residual_px, cv::Mat1b& pair) {
  std::vector<SourceOf> sources;  // two for each pair: past and halfway frame
  for (const PastPair& p : pairs)
    for (const PastFrame* frame : {&p.past, &p.halfway})
      sources.emplace_back(disparityMotion(rig, frame->T_past_cam));
  std::vector<PastPairOfRow> of_row;
  for (size_t k = 0; k < pairs.size(); ++k)
    of_row.push_back({cameraOf(rig, pairs[k].past), disparitiesOf(pairs[k].past, sources[2 * k]),
                      disparitiesOf(pairs[k].halfway, sources[2 * k + 1]),
                      static_cast<float>(pairs[k].past.seconds / pairs[k].halfway.seconds)});
  residual_px.create(lattice);
  pair.create(lattice);
  const int points = (lattice.width + 1) / 2;
  parallelFor(cv::Range(0, (lattice.height + 1) / 2), [&](const cv::Range& rows) {
    cv::AutoBuffer<float, 1024> residuals(static_cast<size_t>(points));
    cv::AutoBuffer<uchar, 1024> pairs_of(static_cast<size_t>(points));
    for (int v = 2 * rows.start; v < 2 * rows.end; v += 2) {
      const int y = 2 * v;
      HWY_DYNAMIC_DISPATCH(longResidualRow)
      ({disparity_px[y], y, points, of_row.data(), static_cast<int>(of_row.size()),
        static_cast<float>(range.min_disparity), static_cast<float>(most_px)},
       residuals.data(), pairs_of.data());
      repeatEach(residuals.data(), lattice.width, residual_px[v]);
      repeatEach(pairs_of.data(), lattice.width, pair[v]);
      if (v + 1 == lattice.height) continue;
      std::copy_n(residual_px[v], lattice.width, residual_px[v + 1]);
      std::copy_n(pair[v], lattice.width, pair[v + 1]);
    }
  });
}

}  // namespace predictive_stereo
#endif
