#include "predictive_stereo/row_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <string>

namespace predictive_stereo {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kCellPx = 16;  // one sample is tried in every cell of this many pixels
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

constexpr double kAgreementPx = 0.5;
constexpr double kLeastAgreement = 0.5;
// Scales of the robust loss, from coarse to fine: one reweighted solution each.
constexpr double kScalesPx[] = {2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.25, 0.25};
constexpr double kPriorWeight = 0.5;  // of offset 0, in samples

Vector6 terms(double u, double v) {
  Vector6 t;
  t << 1, u, v, u * u, u * v, v * v;
  return t;
}

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

// The vertical offset of the right image at a place of the left one, to a fraction of a pixel.
// False where the patch leaves an image, has too little texture, or fits in more than one place.
bool measureOffset(const cv::Mat1b& left, const cv::Mat1b& right, cv::Point centre,
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

void requireSizes(cv::Size left, cv::Size right, cv::Size coarse) {
  const auto text = [](cv::Size size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
  };
  if (left.empty()) throw std::invalid_argument("row alignment: the left image is empty");
  if (left != right)
    throw std::invalid_argument("row alignment: the left image is " + text(left) +
                                ", the right one " + text(right) + ": they must have one size");
  if (coarse != left / 2)
    throw std::invalid_argument("row alignment: the half-resolution match is " + text(coarse) +
                                " but the images are " + text(left));
}

// Largest |offset| on a grid that reaches the corners; a quadratic has no narrow peaks.
double largestOffset(const Vector6& coefficients_px) {
  double largest = 0;
  for (int i = -8; i <= 8; ++i)
    for (int j = -8; j <= 8; ++j)
      largest = std::max(largest, std::abs(coefficients_px.dot(terms(j / 8.0, i / 8.0))));
  return largest;
}

}  // namespace

double RowAlignment::offset(double x_right_px, double y_px, cv::Size size) const {
  return coefficients_px.dot(terms(2 * x_right_px / size.width - 1, 2 * y_px / size.height - 1));
}

RowAligner::RowAligner(const RowAlignmentParams& params) : params_(params) {
  validate(params, "row_alignment/");
}

void RowAligner::reset() {
  past_ = Fit();
  prior_px_.setZero();
}

// The constant term shakes from frame to frame (cameras that vibrate, or expose not quite at once)
// by as much as 0.2 px on KITTI, the others stay: what is known of it is dropped.
void RowAligner::Fit::fade(double weight) {
  if (information(0, 0) > 0) {
    const Vector6 column = information.col(0) / information(0, 0);
    weighted_offset -= column * weighted_offset(0);
    information -= column * information.row(0).eval();
  }
  information *= weight;
  weighted_offset *= weight;
  samples *= weight;
  squared_residuals *= weight;
}

RowAlignment RowAligner::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                  const cv::Mat1f& coarse_disparity_px,
                                  const DisparityRange& range) {
  requireSizes(left.size(), right.size(), coarse_disparity_px.size());
  if (!params_.enabled) return RowAlignment();

  const cv::Size cells(left.cols / kCellPx, left.rows / kCellPx);
  samples_.resize(cells.area());
  cv::parallel_for_(cv::Range(0, cells.height), [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row)
      for (int column = 0; column < cells.width; ++column) {
        const cv::Point centre(column * kCellPx + kCellPx / 2, row * kCellPx + kCellPx / 2);
        Sample& sample = samples_[row * cells.width + column];
        const float disparity_px = coarse_disparity_px(centre / 2);
        sample.valid = range.isValid(disparity_px) &&
                       measureOffset(left, right, centre, cvRound(disparity_px), sample.offset_px);
        if (sample.valid)
          sample.terms =
              terms(2 * (centre.x - disparity_px) / left.cols - 1, 2.0 * centre.y / left.rows - 1);
      }
  });

  past_.fade(params_.smoothing);
  // Reweighted least squares (Geman-McClure) from a wide to a narrow scale, so that the result does
  // not hang on a first guess.
  const auto solve = [&](const Fit& fit) -> Vector6 {
    Matrix6 information = fit.information + past_.information;
    information.diagonal().array() += kPriorWeight;
    return information.ldlt().solve(fit.weighted_offset + past_.weighted_offset +
                                    kPriorWeight * prior_px_);
  };
  Vector6 coefficients_px = solve(Fit());
  for (double scale_px : kScalesPx) {
    Fit fit;
    for (const Sample& sample : samples_) {
      if (!sample.valid) continue;
      const double r = (sample.offset_px - coefficients_px.dot(sample.terms)) / scale_px;
      const double weight = 1 / ((1 + r * r) * (1 + r * r));
      fit.information.noalias() += weight * sample.terms * sample.terms.transpose();
      fit.weighted_offset += weight * sample.offset_px * sample.terms;
    }
    coefficients_px = solve(fit);
  }

  Fit fit;
  int tried = 0;
  for (const Sample& sample : samples_) {
    if (!sample.valid) continue;
    ++tried;
    const double residual = sample.offset_px - coefficients_px.dot(sample.terms);
    if (std::abs(residual) > kAgreementPx) continue;
    fit.information.noalias() += sample.terms * sample.terms.transpose();
    fit.weighted_offset += sample.offset_px * sample.terms;
    fit.samples += 1;
    fit.squared_residuals += residual * residual;
  }
  const bool agree = fit.samples >= kLeastAgreement * tried;
  if (agree) {
    past_.information += fit.information;
    past_.weighted_offset += fit.weighted_offset;
    past_.samples += fit.samples;
    past_.squared_residuals += fit.squared_residuals;
  }
  if (past_.samples < params_.min_samples) return RowAlignment();

  RowAlignment alignment;
  alignment.coefficients_px = solve(Fit());
  alignment.samples = static_cast<int>(past_.samples);
  alignment.residual_px = std::sqrt(past_.squared_residuals / past_.samples);
  alignment.largest_offset_px = largestOffset(alignment.coefficients_px);
  if (alignment.largest_offset_px > params_.max_offset_px) {
    reset();
    return RowAlignment();
  }
  prior_px_ = alignment.coefficients_px;
  return alignment;
}

namespace {

constexpr int kTile = 64;  // columns that are warped together
constexpr int kOne = 128;  // fixed point of offsets and weights

// A row of the right image moved horizontally by a constant shift, borders replicated.
class ShiftedRows {
 public:
  ShiftedRows(const cv::Mat1b& image, double shift_px) : image_(image) {
    const auto shift = static_cast<int>(std::lround(shift_px * kOne));
    whole_ = static_cast<int>(std::floor(-shift / static_cast<double>(kOne)));
    fraction_ = -shift - whole_ * kOne;
  }
  // `count` pixels from column x on; rows outside the image are those of its border. The result
  // points into the image where nothing is to be moved.
  const std::uint8_t* get(int row, int x, int count, std::uint8_t* buffer) const {
    const std::uint8_t* pixels = image_.ptr(std::clamp(row, 0, image_.rows - 1));
    if (whole_ == 0 && fraction_ == 0) return pixels + x;
    for (int i = 0; i < count; ++i) {
      const int a = pixels[std::clamp(x + i + whole_, 0, image_.cols - 1)];
      const int b = pixels[std::clamp(x + i + whole_ + 1, 0, image_.cols - 1)];
      buffer[i] =
          static_cast<std::uint8_t>((a * (kOne - fraction_) + b * fraction_ + kOne / 2) / kOne);
    }
    return buffer;
  }

 private:
  const cv::Mat1b& image_;
  int whole_, fraction_;
};

// Warps one row in fixed point.
void warpRow(const ShiftedRows& right, int y, const Vector6& c, cv::Size size, std::uint8_t* out) {
  // The offset as a quadratic of x alone, scaled, and positive so that truncation rounds.
  constexpr int kBias = 1 << 14;
  const double v = 2.0 * y / size.height - 1, du = 2.0 / size.width;
  const double c0 = c[0] + c[2] * v + c[5] * v * v, c1 = c[1] + c[4] * v, c2 = c[3];
  const auto k0 = static_cast<float>(kOne * (c0 - c1 + c2) + 0.5);
  const auto k1 = static_cast<float>(kOne * du * (c1 - 2 * c2));
  const auto k2 = static_cast<float>(kOne * du * du * c2);

  std::int32_t offsets[kTile];
  std::int16_t weights[kTile];
  std::uint8_t buffers[2][kTile];
  for (int x = 0; x < size.width; x += kTile) {
    const int count = std::min(kTile, size.width - x);
    int smallest = INT32_MAX, largest = INT32_MIN;
    for (int i = 0; i < count; ++i) {
      const auto fx = static_cast<float>(x + i);
      offsets[i] = static_cast<int>((k0 + fx * (k1 + fx * k2)) + kBias) - kBias;
      smallest = std::min(smallest, offsets[i]);
      largest = std::max(largest, offsets[i]);
      weights[i] = static_cast<std::int16_t>(offsets[i] & (kOne - 1));
    }
    // The two source rows change a few times along the row: one pass for each.
    for (int row = smallest >> 7; row <= largest >> 7; ++row) {
      const std::uint8_t* a = right.get(y + row, x, count, buffers[0]);
      const std::uint8_t* b = right.get(y + row + 1, x, count, buffers[1]);
      if (smallest >> 7 == largest >> 7) {
        for (int i = 0; i < count; ++i)
          out[x + i] = static_cast<std::uint8_t>(
              (a[i] * (kOne - weights[i]) + b[i] * weights[i] + kOne / 2) >> 7);
      } else {
        for (int i = 0; i < count; ++i)
          if (offsets[i] >> 7 == row)
            out[x + i] = static_cast<std::uint8_t>(
                (a[i] * (kOne - weights[i]) + b[i] * weights[i] + kOne / 2) >> 7);
      }
    }
  }
}

}  // namespace

void alignRightImage(const cv::Mat1b& right, const RowAlignment& alignment, double column_shift_px,
                     cv::Mat1b& aligned) {
  if (alignment.isIdentity() && column_shift_px == 0) {
    aligned = right;
    return;
  }
  // Not into pixels that someone else shares: those may be the image of an earlier frame.
  if (!aligned.u || aligned.u->refcount > 1) aligned.release();
  aligned.create(right.size());
  const ShiftedRows rows(right, column_shift_px);
  cv::parallel_for_(cv::Range(0, right.rows), [&](const cv::Range& range) {
    for (int y = range.start; y < range.end; ++y)
      warpRow(rows, y, alignment.coefficients_px, right.size(), aligned.ptr(y));
  });
}

}  // namespace predictive_stereo
