#include "matching/row_offset_sample.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

namespace predictive_stereo {
namespace {

constexpr int kPatchCols = 16;
constexpr int kPatchRows = 9;
constexpr int kPatchPixels = kPatchCols * kPatchRows;
constexpr int kRowReach = 3;     // searched up and down
constexpr int kColumnReach = 2;  // searched left and right of the half-resolution disparity
constexpr int kRowShifts = 2 * kRowReach + 1;

constexpr double kSmallestCurvature = 40;  // per pixel, grey levels^2 per px^2
constexpr double kLargestMisfit = 0.5;     // lowest score / curvature
constexpr double kUniqueness = 0.7;        // lowest score / lowest one that is not its neighbour
constexpr int kLineReach = 6;              // columns in which neighbouring rows may match too
constexpr double kLeastHold = 0.2;         // curvature with these columns free / with them fixed

// Zero-mean mean of squared differences of two patches, from exact sums.
double dissimilarity(const cv::Mat1b& left, cv::Point l, const cv::Mat1b& right, cv::Point r) {
  std::int16_t sums[kPatchCols] = {};  // of columns
  int squares = 0;
  for (int y = 0; y < kPatchRows; ++y) {
    const std::uint8_t* a = left.ptr(l.y + y) + l.x;
    const std::uint8_t* b = right.ptr(r.y + y) + r.x;
    for (int x = 0; x < kPatchCols; ++x) {
      const auto difference = static_cast<std::int16_t>(a[x] - b[x]);
      sums[x] = static_cast<std::int16_t>(sums[x] + difference);
      squares += difference * difference;
    }
  }
  int sum = 0;
  for (const std::int16_t of_column : sums) sum += of_column;
  const std::int64_t exact =
      static_cast<std::int64_t>(squares) * kPatchPixels - static_cast<std::int64_t>(sum) * sum;
  return static_cast<double>(exact) / (kPatchPixels * kPatchPixels);
}

}  // namespace

bool measureRowOffset(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point centre,
                      int disparity_px, double& offset_px) {
  const cv::Point corner(centre.x - kPatchCols / 2, centre.y - kPatchRows / 2);
  const int first_column = corner.x - disparity_px - kColumnReach;
  if (corner.x < 0 || corner.x + kPatchCols > left.cols || first_column < 0 ||
      first_column + 2 * kColumnReach + kPatchCols > right.cols || corner.y < kRowReach ||
      corner.y + kPatchRows + kRowReach > left.rows)
    return false;

  // The curvature of a perfect match is twice the difference to the next row. This rejects most
  // patches without texture before the search.
  if (2 * dissimilarity(left, corner, left, {corner.x, corner.y + 1}) < kSmallestCurvature)
    return false;

  const auto score = [&](int column, int row) {
    return dissimilarity(left, corner, right,
                         {first_column + kColumnReach + column, corner.y + row - kRowReach});
  };
  double scores[kRowShifts];
  int best_row = 0;
  for (int i = 0; i < kRowShifts; ++i) {
    scores[i] = score(0, i);
    if (scores[i] < scores[best_row]) best_row = i;
  }
  if (best_row == 0 || best_row == kRowShifts - 1) return false;
  for (int i = 0; i < kRowShifts; ++i)
    if (std::abs(i - best_row) > 1 && scores[best_row] > kUniqueness * scores[i]) return false;

  // The half-resolution disparity may have an error of a pixel: scores of three rows in each
  // neighbouring column.
  double around[2 * kColumnReach + 1][3];
  const auto fillScores = [&](int column) {
    for (int i = 0; i < 3; ++i) around[kColumnReach + column][i] = score(column, best_row + i - 1);
  };
  int best_column = 0;
  std::copy_n(scores + best_row - 1, 3, around[kColumnReach]);
  for (int column : {-1, 1}) {
    fillScores(column);
    if (around[kColumnReach + column][1] < around[kColumnReach + best_column][1])
      best_column = column;
  }
  if (best_column != 0) fillScores(2 * best_column);
  const double* before = around[kColumnReach + best_column - 1];
  const double* middle = around[kColumnReach + best_column];
  const double* after = around[kColumnReach + best_column + 1];
  const double best = middle[1];
  if (before[1] < best || after[1] < best || middle[0] < best || middle[2] < best) return false;

  // A quadratic fit in both directions. The curvature is that with a free column: a diagonal edge
  // does not determine the row offset.
  const double gx = (after[1] - before[1]) / 2;
  const double gy = (middle[2] - middle[0]) / 2;
  const double hxx = after[1] + before[1] - 2 * best;
  const double hyy = middle[2] + middle[0] - 2 * best;
  const double hxy = (after[2] - after[0] - before[2] + before[0]) / 4;
  if (hxx <= 0 || hyy <= 0) return false;
  const double curvature = hyy - hxy * hxy / hxx;
  if (curvature < kSmallestCurvature || best > kLargestMisfit * curvature) return false;

  // A nearly horizontal line escapes the quadratic fit: it matches in every row, some columns
  // further to one side, and best in row 0, where the disparity was measured.
  const int aside = hxy < 0 ? 1 : -1;  // direction of the better columns in the row below
  const auto lowestOfRow = [&](int row, int step) {
    double lowest = std::numeric_limits<double>::max();
    for (int i = 0; i <= kLineReach; ++i) {
      const int column = best_column + i * step;
      const int first = first_column + kColumnReach + column;
      if (first < 0 || first + kPatchCols > right.cols) break;
      lowest = std::min(lowest, score(column, row));
    }
    return lowest;
  };
  const double along_line =
      lowestOfRow(best_row - 1, -aside) + lowestOfRow(best_row + 1, aside) - 2 * best;
  if (along_line < kLeastHold * hyy) return false;

  const double fraction = -(gy - hxy * gx / hxx) / curvature;
  if (!(std::abs(fraction) <= 1)) return false;
  offset_px = best_row - kRowReach + fraction;
  return true;
}

}  // namespace predictive_stereo
