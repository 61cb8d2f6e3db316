#include "matching/row_offset_sample.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace predictive_stereo {
namespace {

constexpr int kPatchCols = 16;
constexpr int kPatchRows = 9;
constexpr int kPatchPixels = kPatchCols * kPatchRows;
constexpr int kRowReach = 3;     // searched up and down
constexpr int kColumnReach = 2;  // searched left and right of the half-resolution disparity
constexpr int kRowShifts = 2 * kRowReach + 1;
constexpr int kColumnShifts = 2 * kColumnReach + 1;

constexpr double kSmallestCurvature = 40;  // per pixel, grey levels^2 per px^2
constexpr double kLargestMisfit = 0.5;     // lowest score by the curvature
constexpr double kUniqueness = 0.7;        // lowest score by the lowest that is no neighbour

// Zero-mean sum of squared differences, times the number of pixels: an integer.
std::int64_t dissimilarity(const cv::Mat1b& left, cv::Point l, const cv::Mat1b& right,
                           cv::Point r) {
  int sum = 0, squares = 0;
  for (int y = 0; y < kPatchRows; ++y) {
    const std::uint8_t* a = left.ptr(l.y + y) + l.x;
    const std::uint8_t* b = right.ptr(r.y + y) + r.x;
    for (int x = 0; x < kPatchCols; ++x) {
      const auto difference = static_cast<std::int16_t>(a[x] - b[x]);
      sum += difference;
      squares += difference * difference;
    }
  }
  return static_cast<std::int64_t>(squares) * kPatchPixels - static_cast<std::int64_t>(sum) * sum;
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

  double scores[kRowShifts][kColumnShifts];
  int best_row = 0, best_column = 0;
  for (int i = 0; i < kRowShifts; ++i)
    for (int j = 0; j < kColumnShifts; ++j) {
      const cv::Point shifted(first_column + j, corner.y + i - kRowReach);
      scores[i][j] = static_cast<double>(dissimilarity(left, corner, right, shifted)) /
                     (kPatchPixels * kPatchPixels);
      if (scores[i][j] < scores[best_row][best_column]) best_row = i, best_column = j;
    }
  if (best_row == 0 || best_row == kRowShifts - 1 || best_column == 0 ||
      best_column == kColumnShifts - 1)
    return false;

  const double best = scores[best_row][best_column];
  for (int i = 0; i < kRowShifts; ++i)
    if (std::abs(i - best_row) > 1)
      for (double score : scores[i])
        if (best > kUniqueness * score) return false;

  // A quadratic in both directions, of which the column is then left free: an edge that runs
  // diagonally tells nothing of rows.
  const int i = best_row, j = best_column;
  const double gx = (scores[i][j + 1] - scores[i][j - 1]) / 2;
  const double gy = (scores[i + 1][j] - scores[i - 1][j]) / 2;
  const double hxx = scores[i][j + 1] + scores[i][j - 1] - 2 * scores[i][j];
  const double hyy = scores[i + 1][j] + scores[i - 1][j] - 2 * scores[i][j];
  const double hxy =
      (scores[i + 1][j + 1] - scores[i + 1][j - 1] - scores[i - 1][j + 1] + scores[i - 1][j - 1]) /
      4;
  if (hxx <= 0 || hyy <= 0) return false;
  const double curvature = hyy - hxy * hxy / hxx;
  if (curvature < kSmallestCurvature || best > kLargestMisfit * curvature) return false;
  const double fraction = -(gy - hxy * gx / hxx) / curvature;
  if (!(std::abs(fraction) <= 1)) return false;
  offset_px = i - kRowReach + fraction;
  return true;
}

}  // namespace predictive_stereo
