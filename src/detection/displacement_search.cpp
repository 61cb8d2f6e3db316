#include "detection/displacement_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include "detection/constants.h"
#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detection/displacement_search.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

// Copies whole vectors: memcpy may write in two halves, which stalls the vector load that follows.
HWY_INLINE void copyPairs(const uint8_t* HWY_RESTRICT bytes, uint16_t (&pairs)[kShiftBlock]) {
  const hn::CappedTag<uint8_t, sizeof pairs> d;
  auto* copy = reinterpret_cast<uint8_t*>(pairs);
  for (size_t i = 0; i < sizeof pairs; i += hn::Lanes(d))
    hn::StoreU(hn::LoadU(d, bytes + i), d, copy + i);
}

// Short loops without branches, which compilers vectorise.
HWY_NOINLINE void totalsOfShifts(const uint8_t* HWY_RESTRICT grey, const uint8_t* const* before,
                                 int samples, int trials, int32_t* HWY_RESTRICT total) {
  int16_t differences[kMostShiftedSamples][kShiftBlock];
  const auto count = static_cast<int16_t>(samples);
  for (int k = 0; k < trials; k += kShiftBlock) {
    int16_t sum[kShiftBlock] = {};
    for (int i = 0; i < samples; ++i) {
      const auto now = static_cast<int16_t>(grey[i]);
      uint16_t pairs[kShiftBlock];  // of columns; the first one is in the lower byte
      copyPairs(before[i] + 2 * k, pairs);
      for (int j = 0; j < kShiftBlock; ++j) {
        differences[i][j] = static_cast<int16_t>(now - static_cast<int16_t>(pairs[j] & 0xFF));
        sum[j] = static_cast<int16_t>(sum[j] + differences[i][j]);
      }
    }
    int32_t totals[kShiftBlock] = {};
    for (int i = 0; i < samples; ++i)
      for (int j = 0; j < kShiftBlock; ++j) {
        const auto scaled = static_cast<int16_t>(count * differences[i][j]);
        const auto rest = static_cast<int16_t>(std::max(scaled, sum[j]) - std::min(scaled, sum[j]));
        totals[j] += rest;
      }
    std::memcpy(total + k, totals, sizeof totals);
  }
}

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(totalsOfShifts);

constexpr size_t kMostPoints = 160;
constexpr int kMostCoarsePoints = kMostShiftedSamples;
constexpr int kReachY = 6;  // lattice points
constexpr int kCoarse = 2;  // lattice points between coarse trials
constexpr int kTrialsY = 2 * kReachY / kCoarse + 1;
constexpr int kMostTrialsX =  // rounded up to whole blocks
    (2 * kSearchReach / kCoarse + kShiftBlock) / kShiftBlock * kShiftBlock;

// Current points, and their positions in the previous image if they are static.
struct Samples {
  int count = 0;
  uint8_t grey[kMostPoints + 1];
  cv::Point at[kMostPoints + 1];           // lattice
  std::ptrdiff_t offset[kMostPoints + 1];  // of `at` in memory
  cv::Rect around;                         // all of them
};

// Mean |difference| after subtracting the mean difference; infinity if too many points leave the
// image. Sums are exact.
/// @param step  every step-th sample is compared.
float mismatchAt(const cv::Mat1b& previous, const Samples& samples, int step, cv::Point shift) {
  int32_t difference[kMostPoints + 1];
  int n = 0;
  int32_t sum = 0;
  const cv::Rect image(cv::Point(), previous.size()), shifted = samples.around + shift;
  const bool all_inside = (shifted & image) == shifted;
  const std::ptrdiff_t offset = shift.y * static_cast<std::ptrdiff_t>(previous.step) + shift.x;
  for (int i = 0; i < samples.count; i += step) {
    if (!all_inside && !image.contains(samples.at[i] + shift)) continue;
    difference[n] = samples.grey[i] - previous.data[offset + samples.offset[i]];
    sum += difference[n++];
  }
  if (3 * n * step < 2 * samples.count) return std::numeric_limits<float>::infinity();
  int32_t total = 0;
  for (int i = 0; i < n; ++i) total += std::abs(n * difference[i] - sum);
  return static_cast<float>(total) / static_cast<float>(n * n);
}

// The same for trials along a row, every kCoarse columns from `first` on.
void mismatchesAlong(const cv::Mat1b& previous, const Samples& samples, int step, cv::Point first,
                     int trials, float* mismatch) {
  const cv::Rect image(cv::Point(), previous.size());
  const cv::Point last = first + cv::Point(kCoarse * (trials - 1), 0);
  const cv::Rect swept = (samples.around + first) | (samples.around + last);
  // Whole blocks are read, beyond the end of a row but not of the image.
  const auto row = static_cast<std::ptrdiff_t>(previous.step);
  const std::ptrdiff_t end = (swept.br().y - 1) * row + (samples.around + first).br().x +
                             kCoarse * static_cast<std::ptrdiff_t>(kMostTrialsX);
  if ((swept & image) != swept || end > image.height * row) {
    for (int k = 0; k < trials; ++k)
      mismatch[k] = mismatchAt(previous, samples, step, first + cv::Point(kCoarse * k, 0));
    return;
  }
  static_assert(kCoarse == 2, "see totalsOfShifts");
  uint8_t grey[kMostCoarsePoints];
  const uint8_t* before[kMostCoarsePoints];
  int n = 0;
  for (int i = 0; i < samples.count; i += step) {
    grey[n] = samples.grey[i];
    before[n++] = previous.data + samples.offset[i] + first.y * row + first.x;
  }
  int32_t total[kMostTrialsX];
  HWY_DYNAMIC_DISPATCH(totalsOfShifts)(grey, before, n, trials, total);
  for (int k = 0; k < trials; ++k)
    mismatch[k] = static_cast<float>(total[k]) / static_cast<float>(n * n);
}

}  // namespace

void totalsOfShifts(const uint8_t* grey, const uint8_t* const* before, int samples, int trials,
                    int32_t* total) {
  HWY_DYNAMIC_DISPATCH(totalsOfShifts)(grey, before, samples, trials, total);
}

std::optional<ShiftFound> searchShift(const PastView& view, const std::vector<cv::Point>& points,
                                      int reach) {
  const cv::Mat1b& image = view.past_images().level(1);
  const auto right = static_cast<float>(image.cols - 1),
             bottom = static_cast<float>(image.rows - 1);
  Samples samples;
  const size_t step = points.size() / (kMostPoints + 1) + 1;
  cv::Point first(image.cols, image.rows), last;
  for (size_t i = 0; i < points.size(); i += step) {
    const cv::Point pixel = 2 * points[i];
    const Eigen::Vector3f at = view.staticSource(pixel);
    const float x = 0.5f * at.x(), y = 0.5f * at.y();
    if (!(x >= 0 && y >= 0 && x < right && y < bottom && at.z() > 0)) continue;
    samples.grey[samples.count] = view.images().level(1)(points[i]);
    const cv::Point before(cvRound(x), cvRound(y));
    samples.at[samples.count] = before;
    samples.offset[samples.count++] = before.y * static_cast<std::ptrdiff_t>(image.step) + before.x;
    first = {std::min(first.x, before.x), std::min(first.y, before.y)};
    last = {std::max(last.x, before.x), std::max(last.y, before.y)};
  }
  if (samples.count < static_cast<int>(kFewestPoints)) return std::nullopt;
  samples.around = cv::Rect(first, last + cv::Point(1, 1));

  const int side = std::clamp(reach, kCoarse, kSearchReach) / kCoarse;
  const int trials = 2 * side + 1;
  const auto coarse = [side](int row, int column) {
    return cv::Point(kCoarse * (column - side), kCoarse * row - kReachY);
  };
  const int step_of_coarse = (samples.count + kMostCoarsePoints - 1) / kMostCoarsePoints;
  float mismatch[kTrialsY][kMostTrialsX];
  for (int row = 0; row < kTrialsY; ++row)
    mismatchesAlong(image, samples, step_of_coarse, coarse(row, 0), trials, mismatch[row]);
  float best = std::numeric_limits<float>::infinity();
  cv::Point at;
  for (int row = 0; row < kTrialsY; ++row)
    for (int column = 0; column < trials; ++column) {
      const float m = mismatch[row][column];
      if (m < best) best = m, at = coarse(row, column);
    }
  if (!std::isfinite(best)) return std::nullopt;
  const cv::Point centre = at;
  best = mismatchAt(image, samples, 1, at);
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const cv::Point shift = centre + cv::Point(dx, dy);
      const float m = mismatchAt(image, samples, 1, shift);
      if (m < best) best = m, at = shift;
    }
  const float still = mismatchAt(image, samples, 1, {});
  // Mismatches below half of a decisive difference are noise.
  return ShiftFound{{2.0f * static_cast<float>(at.x), 2.0f * static_cast<float>(at.y)},
                    still / std::max(best, 0.5f * kDecisive_grey)};
}

}  // namespace predictive_stereo
#endif
