#include "odometry/stereo_depth.h"

#include <algorithm>
#include <cmath>

#include "odometry/block_kernel.h"
#include "odometry/patch.h"

namespace predictive_stereo {
namespace {

constexpr int kBlock = kBlockSize;  // blocks are compared at half resolution
constexpr float kSmallestCorrelation = 0.8f;
constexpr float kExpectedCorrelation = 0.9f;  // to be accepted without a search
constexpr float kUniqueness = 0.03f;          // by which the best must beat any other place
constexpr float kLargestSurprisePx = 3;       // from an expected shift
constexpr float kFarthestPx = 4;              // from a place found at half resolution
constexpr int kIterations = 12;

// Shift and row offset of the best place at half resolution [px there].
struct Coarse {
  int shift = 0, row_offset = 0;
  bool found = false;
};

// Correlation of one block with those of a row.
class RowCorrelation {
 public:
  void setBlock(const cv::Mat1b& image, cv::Point corner) {
    grey_ = grey_grey_ = 0;
    for (int y = 0; y < kBlock; ++y)
      for (int x = 0; x < kBlock; ++x) {
        const int g = image(corner.y + y, corner.x + x);
        grey_ += g;
        grey_grey_ += g * g;
        block_[y * kBlock + x] = static_cast<float>(g);
      }
  }

  /// With the blocks whose upper left pixels are in columns `first` to `last`.
  const std::vector<float>& with(const cv::Mat1b& image, int row, int first, int last) {
    const int positions = last - first + 1;
    const auto size = static_cast<size_t>(positions);
    sums_.resize(3 * size);
    correlation_.resize(size);
    const BlockProducts sums{sums_.data(), sums_.data() + size, sums_.data() + 2 * size};
    bestBlockKernel()(block_, image.ptr<uchar>(row) + first, image.step, positions, sums);
    const auto variance = static_cast<float>(kBlockArea * grey_grey_ - grey_ * grey_);
    for (int i = 0; i < positions; ++i) {
      const auto product = static_cast<float>(kBlockArea * sums.products[i] - grey_ * sums.grey[i]);
      const auto other =
          static_cast<float>(kBlockArea * sums.grey_grey[i] - sums.grey[i] * sums.grey[i]);
      correlation_[static_cast<size_t>(i)] = product / std::sqrt(std::max(variance * other, 1.f));
    }
    return correlation_;
  }

 private:
  float block_[kBlockArea];
  int grey_, grey_grey_;
  std::vector<int32_t> sums_;
  std::vector<float> correlation_;
};

// `row_of_shift` tells the row offset to search around, for a shift [px at half resolution].
template <class RowOfShift>
Coarse searchCoarse(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point2f point,
                    const RowOfShift& row_of_shift, const StereoSearch& search) {
  Coarse coarse;
  const cv::Point corner(cvRound(point.x) - kBlock / 2, cvRound(point.y) - kBlock / 2);
  if (corner.x < 0 || corner.y < 0 || corner.x + kBlock > left.cols ||
      corner.y + kBlock > left.rows)
    return coarse;
  const int first = std::max((search.smallest_shift_px - 1) / 2, corner.x + kBlock - right.cols);
  const int last = std::min((search.largest_shift_px + 1) / 2, corner.x);
  if (first > last) return coarse;
  const int row_radius = (search.row_radius_px + 1) / 2;

  float best = -1;
  // The best of all rows for every shift, to see whether another shift does as well.
  thread_local std::vector<float> of_shift;
  of_shift.assign(last - first + 1, -1.f);
  thread_local RowCorrelation block;
  block.setBlock(left, corner);
  // Shifts that look along the same row are compared together.
  for (int begin = first; begin <= last;) {
    const int middle = cvRound(row_of_shift(begin));
    int end = begin + 1;
    while (end <= last && cvRound(row_of_shift(end)) == middle) ++end;
    for (int offset = middle - row_radius; offset <= middle + row_radius; ++offset) {
      const int row = corner.y + offset;
      if (row < 0 || row + kBlock > right.rows) continue;
      const std::vector<float>& correlation =
          block.with(right, row, corner.x - end + 1, corner.x - begin);
      for (int shift = begin; shift < end; ++shift) {
        const float c = correlation[end - 1 - shift];
        of_shift[shift - first] = std::max(of_shift[shift - first], c);
        if (c > best) {
          best = c;
          coarse.shift = shift;
          coarse.row_offset = offset;
        }
      }
    }
    begin = end;
  }
  float second = -1;
  for (int shift = first; shift <= last; ++shift)
    if (std::abs(shift - coarse.shift) > 2) second = std::max(second, of_shift[shift - first]);
  coarse.found = best > kSmallestCorrelation && second < best - kUniqueness;
  return coarse;
}

void matchPoint(const ImagePyramid& left, const ImagePyramid& right,
                const RowOffsetModel& alignment, const StereoSearch& search, StereoMatch& match) {
  const cv::Point2f point = match.point;
  match.found = false;
  Patch patch;
  if (!patch.sample(left.level(0), point)) return;
  // The alignment's columns are the right image's.
  const auto rowOffset = [&](float shift_px) {
    return static_cast<float>(alignment.offset(point.x - shift_px, point.y, right.level(0).size()));
  };

  const auto refine = [&](cv::Point2f start, float farthest, float smallest_correlation) {
    const Patch::Match fine = patch.align(right.level(0), start, kIterations);
    const cv::Point2f moved = fine.position - start;
    if (!fine.converged || fine.correlation < smallest_correlation ||
        moved.dot(moved) > farthest * farthest)
      return false;
    match.shift_px = point.x - fine.position.x;
    match.row_offset_px = fine.position.y - point.y;
    match.shift_by_row = patch.columnErrorFromRowError(1);
    match.found = true;
    return true;
  };

  if (match.expected && refine({point.x - match.shift_px, point.y + rowOffset(match.shift_px)},
                               kLargestSurprisePx, kExpectedCorrelation))
    return;
  const Coarse coarse = searchCoarse(
      left.level(1), right.level(1), point * 0.5f,
      [&](int shift) { return 0.5f * rowOffset(2.f * shift); }, search);
  if (!coarse.found) return;
  const float row =
      search.row_radius_px > 0 ? 2.f * coarse.row_offset : rowOffset(2.f * coarse.shift);
  refine({point.x - 2.f * coarse.shift, point.y + row}, kFarthestPx, kSmallestCorrelation);
}

}  // namespace

void matchStereo(const ImagePyramid& left, const ImagePyramid& right,
                 const RowOffsetModel& alignment, const StereoSearch& search,
                 std::vector<StereoMatch>& matches) {
  CV_Assert(left.levels() > 1 && right.levels() > 1);
  cv::parallel_for_(cv::Range(0, static_cast<int>(matches.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i)
      matchPoint(left, right, alignment, search, matches[i]);
  });
}

}  // namespace predictive_stereo
