#include "odometry/stereo_depth.h"

#include <algorithm>
#include <cmath>

#include "imaging/patch.h"
#include "odometry/block_kernel.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kBlock = kBlockSize;  // blocks are compared at half resolution
constexpr float kSmallestCorrelation = 0.8f;
constexpr float kExpectedCorrelation = 0.9f;  // to accept an expected match without a search
constexpr float kUniqueness = 0.05f;          // between the best correlation and any other
constexpr float kLargestSurprisePx = 3;       // from the expected position
constexpr float kFarthestPx = 4;              // from the position found at half resolution
constexpr int kIterations = 12;

// Best shift and row offset at half resolution [px of half resolution].
struct Coarse {
  int shift = 0, row_offset = 0;
  bool found = false;
};

// `row_of_shift` gives the row offset to search around for a shift [px of half resolution].
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
  // The best correlation of all rows for every shift, for the uniqueness test.
  thread_local std::vector<float> of_shift, correlation;
  of_shift.assign(static_cast<size_t>(last - first + 1), -1.f);
  correlation.resize(of_shift.size());
  const BlockAt block{left[corner.y] + corner.x, left.step};
  // Shifts with the same row are correlated together.
  for (int begin = first; begin <= last;) {
    const int middle = row_of_shift(begin);
    int end = begin + 1;
    while (end <= last && row_of_shift(end) == middle) ++end;
    for (int offset = middle - row_radius; offset <= middle + row_radius; ++offset) {
      const int row = corner.y + offset;
      if (row < 0 || row + kBlock > right.rows) continue;
      blockKernelInUse()(block, {right[row] + corner.x - end + 1, right.step}, end - begin,
                         correlation.data());
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
  // The alignment is a function of right image columns.
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
    match.shift_variance_px2 = patch.columnVariance();
    match.found = true;
    return true;
  };

  if (match.expected) {
    if (!patch.sample(left.level(0), point)) return;
    if (refine({point.x - match.shift_px, point.y + rowOffset(match.shift_px)}, kLargestSurprisePx,
               kExpectedCorrelation))
      return;
  }
  const Eigen::Vector3d along = alignment.alongRow(point.y, right.level(0).size());
  const auto coarseRow = [&](int shift) {
    const double x = point.x - 2.0 * shift;
    return cvRound(0.5 * (along[0] + x * (along[1] + x * along[2])));
  };
  const Coarse coarse =
      searchCoarse(left.level(1), right.level(1), point * 0.5f, coarseRow, search);
  if (!coarse.found) return;
  if (!match.expected && !patch.sample(left.level(0), point)) return;
  const float row =
      search.row_radius_px > 0 ? 2.f * coarse.row_offset : rowOffset(2.f * coarse.shift);
  refine({point.x - 2.f * coarse.shift, point.y + row}, kFarthestPx, kSmallestCorrelation);
}

}  // namespace

void matchStereo(const ImagePyramid& left, const ImagePyramid& right,
                 const RowOffsetModel& alignment, const StereoSearch& search,
                 std::vector<StereoMatch>& matches) {
  CV_Assert(left.levels() > 1 && right.levels() > 1);
  parallelForEach(static_cast<int>(matches.size()),
                  [&](int i) { matchPoint(left, right, alignment, search, matches[i]); });
}

}  // namespace predictive_stereo
