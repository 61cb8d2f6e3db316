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

// A patch of the left image, and where it is searched for in the right one.
struct Search {
  const cv::Mat1b &left, &right;
  cv::Point corner;  ///< of the patch
  int first_column;  ///< of the right image, that is searched

  bool isInside() const {
    return corner.x >= 0 && corner.x + kPatchCols <= left.cols && first_column >= 0 &&
           first_column + 2 * kColumnReach + kPatchCols <= right.cols && corner.y >= kRowReach &&
           corner.y + kPatchRows + kRowReach <= left.rows;
  }
  // `row` counts from 0, kRowReach is the patch's own; `column` from the measured disparity.
  double score(int column, int row) const {
    return dissimilarity(left, corner, right,
                         {first_column + kColumnReach + column, corner.y + row - kRowReach});
  }
};

// The row with the lowest score at the measured disparity; -1: it is not unique.
int bestRow(const Search& search, double (&scores)[kRowShifts]) {
  int best = 0;
  for (int i = 0; i < kRowShifts; ++i) {
    scores[i] = search.score(0, i);
    if (scores[i] < scores[best]) best = i;
  }
  if (best == 0 || best == kRowShifts - 1) return -1;
  for (int i = 0; i < kRowShifts; ++i)
    if (std::abs(i - best) > 1 && scores[best] > kUniqueness * scores[i]) return -1;
  return best;
}

// Scores of the best row and its neighbours, in the best column and its neighbours.
struct Surroundings {
  double scores[2 * kColumnReach + 1][3];
  int column = 0;  ///< the best one

  const double* at(int step) const { return scores[kColumnReach + column + step]; }
  bool haveLowestInside() const {
    const double best = at(0)[1];
    return at(-1)[1] >= best && at(1)[1] >= best && at(0)[0] >= best && at(0)[2] >= best;
  }
};

// The half-resolution disparity may have an error of a pixel: each neighbouring column is tried.
Surroundings surroundingsOf(const Search& search, int best_row, const double* scores) {
  Surroundings around;
  const auto fillScores = [&](int column) {
    for (int i = 0; i < 3; ++i)
      around.scores[kColumnReach + column][i] = search.score(column, best_row + i - 1);
  };
  std::copy_n(scores + best_row - 1, 3, around.scores[kColumnReach]);
  for (int column : {-1, 1}) {
    fillScores(column);
    if (around.scores[kColumnReach + column][1] < around.at(0)[1]) around.column = column;
  }
  if (around.column != 0) fillScores(2 * around.column);
  return around;
}

// A nearly horizontal line escapes the quadratic fit: it matches in every row, some columns further
// to one side, and best in row 0, where the disparity was measured. Returns by how much the scores
// along it exceed the best one.
double riseAlongLine(const Search& search, int best_row, const Surroundings& around, double hxy) {
  const int aside = hxy < 0 ? 1 : -1;  // direction of the better columns in the row below
  const auto lowestOfRow = [&](int row, int step) {
    double lowest = std::numeric_limits<double>::max();
    for (int i = 0; i <= kLineReach; ++i) {
      const int column = around.column + i * step;
      const int first = search.first_column + kColumnReach + column;
      if (first < 0 || first + kPatchCols > search.right.cols) break;
      lowest = std::min(lowest, search.score(column, row));
    }
    return lowest;
  };
  return lowestOfRow(best_row - 1, -aside) + lowestOfRow(best_row + 1, aside) - 2 * around.at(0)[1];
}

}  // namespace

bool measureRowOffset(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point centre,
                      int disparity_px, double& offset_px) {
  const cv::Point corner(centre.x - kPatchCols / 2, centre.y - kPatchRows / 2);
  const Search search{left, right, corner, corner.x - disparity_px - kColumnReach};
  if (!search.isInside()) return false;

  // The curvature of a perfect match is twice the difference to the next row. This rejects most
  // patches without texture before the search.
  if (2 * dissimilarity(left, corner, left, {corner.x, corner.y + 1}) < kSmallestCurvature)
    return false;

  double scores[kRowShifts];
  const int best_row = bestRow(search, scores);
  if (best_row < 0) return false;
  const Surroundings around = surroundingsOf(search, best_row, scores);
  if (!around.haveLowestInside()) return false;

  // A quadratic fit in both directions. The curvature is that with a free column: a diagonal edge
  // does not determine the row offset.
  const double *before = around.at(-1), *middle = around.at(0), *after = around.at(1);
  const double best = middle[1];
  const double gx = (after[1] - before[1]) / 2;
  const double gy = (middle[2] - middle[0]) / 2;
  const double hxx = after[1] + before[1] - 2 * best;
  const double hyy = middle[2] + middle[0] - 2 * best;
  const double hxy = (after[2] - after[0] - before[2] + before[0]) / 4;
  if (hxx <= 0 || hyy <= 0) return false;
  const double curvature = hyy - hxy * hxy / hxx;
  if (curvature < kSmallestCurvature || best > kLargestMisfit * curvature) return false;
  if (riseAlongLine(search, best_row, around, hxy) < kLeastHold * hyy) return false;

  const double fraction = -(gy - hxy * gx / hxx) / curvature;
  if (!(std::abs(fraction) <= 1)) return false;
  offset_px = best_row - kRowReach + fraction;
  return true;
}

}  // namespace predictive_stereo
