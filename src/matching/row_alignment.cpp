#include "predictive_stereo/row_alignment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "imaging/size_check.h"
#include "matching/row_offset_sample.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kCellPx = 16;  // one sample is tried in every cell of this many pixels

constexpr double kAgreementPx = 0.5;
constexpr double kLeastAgreement = 0.5;
// Scales of the robust loss, from coarse to fine: one reweighted solution each.
constexpr double kScalesPx[] = {2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25, 0.25, 0.25};
constexpr double kPriorWeight = 0.5;  // of the last frame's offset, in samples

Vector6 polynomialTerms(double u, double v) {
  Vector6 t;
  t << 1, u, v, u * u, u * v, v * v;
  return t;
}

void requireSizes(cv::Size left, cv::Size right, cv::Size coarse) {
  if (left.empty()) throw std::invalid_argument("row alignment: the left image is empty");
  requireSize("row alignment: the right image", right, left, "but the left one is");
  requireSize("row alignment: the half-resolution match", coarse, left / 2,
              "but half the size of the images is");
}

// From offsets on a grid that includes the corners. A coarse grid is enough: the model is
// quadratic.
void summarise(RowOffsetModel& alignment) {
  constexpr int kSteps = 8;
  double squares = 0, largest = 0;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j) {
      const double offset_px =
          alignment.coefficients_px.dot(polynomialTerms(j / double{kSteps}, i / double{kSteps}));
      squares += offset_px * offset_px;
      largest = std::max(largest, std::abs(offset_px));
    }
  constexpr int kPoints = (2 * kSteps + 1) * (2 * kSteps + 1);
  alignment.rms_offset_px = std::sqrt(squares / kPoints);
  alignment.largest_offset_px = largest;
}

constexpr int kTile = 64;  // columns that are warped together
constexpr int kBits = 7;   // fixed point of offsets and weights
constexpr int kOne = 1 << kBits;

// Rows of the right image, shifted horizontally by a constant; borders are replicated.
class ShiftedRows {
 public:
  ShiftedRows(const cv::Mat1b& image, double shift_px) : image_(image) {
    const auto shift = static_cast<int>(std::lround(shift_px * kOne));
    whole_ = static_cast<int>(std::floor(-shift / static_cast<double>(kOne)));
    fraction_ = -shift - whole_ * kOne;
  }
  // `count` pixels from column x on; rows outside the image repeat its border. Without a shift the
  // result points into the image.
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

std::uint8_t blend(std::uint8_t a, std::uint8_t b, std::uint16_t weight) {
  return static_cast<std::uint8_t>(
      static_cast<std::uint16_t>(a * (kOne - weight) + b * weight + kOne / 2) / kOne);
}

// Warps one row in fixed point.
void warpRow(const ShiftedRows& right, int y, const RowOffsetModel& alignment, cv::Size size,
             std::uint8_t* out) {
  // The offset as a quadratic of x only, scaled, and made positive so that truncation rounds.
  constexpr int kBias = 1 << 14;
  const Eigen::Vector3d along_x = kOne * alignment.alongRow(y, size);
  const auto k0 = static_cast<float>(along_x[0] + 0.5);
  const auto k1 = static_cast<float>(along_x[1]), k2 = static_cast<float>(along_x[2]);
  const auto offsetAt = [=](int x) {
    const auto fx = static_cast<float>(x);
    return static_cast<int>((k0 + fx * (k1 + fx * k2)) + kBias) - kBias;
  };
  // Within a tile the offset exceeds the interval between its two ends by less than this.
  const int bulge = 1 + static_cast<int>(std::abs(k2) * (kTile * kTile / 4));

  std::int16_t offsets[kTile];
  std::uint8_t buffers[2][kTile];
  for (int x = 0; x < size.width; x += kTile) {
    const int count = std::min(kTile, size.width - x);
    for (int i = 0; i < count; ++i) offsets[i] = static_cast<std::int16_t>(offsetAt(x + i));
    const int first = (std::min(offsets[0], offsets[count - 1]) - bulge) >> kBits;
    const int last = (std::max(offsets[0], offsets[count - 1]) + bulge) >> kBits;
    // The two source rows change only a few times along the row: one pass for each of them.
    for (int row = first; row <= last; ++row) {
      const std::uint8_t* a = right.get(y + row, x, count, buffers[0]);
      const std::uint8_t* b = right.get(y + row + 1, x, count, buffers[1]);
      if (first == last) {
        for (int i = 0; i < count; ++i) out[x + i] = blend(a[i], b[i], offsets[i] & (kOne - 1));
      } else {
        for (int i = 0; i < count; ++i)
          if (offsets[i] >> kBits == row) out[x + i] = blend(a[i], b[i], offsets[i] & (kOne - 1));
      }
    }
  }
}

}  // namespace

double RowOffsetModel::offset(double x_right_px, double y_px, cv::Size size) const {
  return coefficients_px.dot(
      polynomialTerms(2 * x_right_px / size.width - 1, 2 * y_px / size.height - 1));
}

Eigen::Vector3d RowOffsetModel::alongRow(double y_px, cv::Size size) const {
  const Vector6& c = coefficients_px;
  const double v = 2 * y_px / size.height - 1, u_per_px = 2.0 / size.width;
  const double c0 = c[0] + c[2] * v + c[5] * v * v, c1 = c[1] + c[4] * v, c2 = c[3];
  return {c0 - c1 + c2, u_per_px * (c1 - 2 * c2), u_per_px * u_per_px * c2};
}

RowOffsetFilter::RowOffsetFilter(const RowAlignmentParams& params) : params_(params) {
  validate(params, "row_alignment/");
}

void RowOffsetFilter::setParams(const RowAlignmentParams& params) {
  validate(params, "row_alignment/");
  params_ = params;
}

void RowOffsetFilter::reset() {
  past_ = Fit();
  prior_px_.setZero();
}

// The constant term changes from frame to frame by up to 0.2 px on KITTI (the cameras vibrate, or
// are not exposed at exactly the same time). The other terms are stable. Therefore the past
// information on the constant term is removed (marginalised).
void RowOffsetFilter::Fit::fade(double weight) {
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

void RowOffsetFilter::Fit::add(const Fit& other) {
  information += other.information;
  weighted_offset += other.weighted_offset;
  samples += other.samples;
  squared_residuals += other.squared_residuals;
}

RowOffsetFilter::Vector6 RowOffsetFilter::solve(const Fit& fit) const {
  Matrix6 information = fit.information + past_.information;
  information.diagonal().array() += kPriorWeight;
  return information.ldlt().solve(fit.weighted_offset + past_.weighted_offset +
                                  kPriorWeight * prior_px_);
}

RowOffsetModel RowOffsetFilter::update(const std::vector<RowOffsetMeasurement>& samples,
                                       cv::Size size) {
  past_.fade(params_.smoothing);
  terms_.clear();
  for (const RowOffsetMeasurement& sample : samples)
    terms_.push_back(
        polynomialTerms(2 * sample.x_right_px / size.width - 1, 2 * sample.y_px / size.height - 1));

  // Reweighted least squares (Geman-McClure) from a wide to a narrow scale: the result does not
  // depend on the initial value.
  Vector6 coefficients_px = solve(Fit());
  for (double scale_px : kScalesPx) {
    Fit fit;
    for (size_t i = 0; i < samples.size(); ++i) {
      const double r = (samples[i].offset_px - coefficients_px.dot(terms_[i])) / scale_px;
      const double weight = 1 / ((1 + r * r) * (1 + r * r));
      fit.information.noalias() += weight * terms_[i] * terms_[i].transpose();
      fit.weighted_offset += weight * samples[i].offset_px * terms_[i];
    }
    coefficients_px = solve(fit);
  }

  Fit agreeing;
  for (size_t i = 0; i < samples.size(); ++i) {
    const double residual_px = samples[i].offset_px - coefficients_px.dot(terms_[i]);
    if (std::abs(residual_px) > kAgreementPx) continue;
    agreeing.information.noalias() += terms_[i] * terms_[i].transpose();
    agreeing.weighted_offset += samples[i].offset_px * terms_[i];
    agreeing.samples += 1;
    agreeing.squared_residuals += residual_px * residual_px;
  }
  if (agreeing.samples >= kLeastAgreement * static_cast<double>(samples.size()))
    past_.add(agreeing);
  if (past_.samples < params_.min_samples) return RowOffsetModel();

  RowOffsetModel alignment;
  alignment.coefficients_px = solve(Fit());
  alignment.samples = static_cast<int>(past_.samples);
  alignment.residual_px = std::sqrt(past_.squared_residuals / past_.samples);
  summarise(alignment);
  if (alignment.largest_offset_px > params_.max_offset_px) {
    reset();
    return RowOffsetModel();
  }
  prior_px_ = alignment.coefficients_px;
  return alignment;
}

RowAligner::RowAligner(const RowAlignmentParams& params) : params_(params), filter_(params) {}

void RowAligner::setParams(const RowAlignmentParams& params) {
  filter_.setParams(params);
  params_ = params;
}

void RowAligner::reset() { filter_.reset(); }

RowOffsetModel RowAligner::estimate(const cv::Mat1b& left, const cv::Mat1b& right,
                                    const cv::Mat1f& coarse_disparity_px,
                                    const DisparityRange& range, double principal_offset_px) {
  requireSizes(left.size(), right.size(), coarse_disparity_px.size());
  if (!params_.enabled) return RowOffsetModel();

  const cv::Size cells(left.cols / kCellPx, left.rows / kCellPx);
  tried_.resize(static_cast<size_t>(cells.area()));
  parallelForEach(cells.height, [&](int row) {
    for (int column = 0; column < cells.width; ++column) {
      const cv::Point centre(column * kCellPx + kCellPx / 2, row * kCellPx + kCellPx / 2);
      const float disparity_px = coarse_disparity_px(centre / 2);
      Tried& tried = tried_[static_cast<size_t>(row * cells.width + column)];
      tried.sample.x_right_px = centre.x - disparity_px - principal_offset_px;
      tried.sample.y_px = centre.y;
      tried.valid =
          range.isValid(disparity_px) &&
          measureRowOffset(left, right, centre, cvRound(disparity_px + principal_offset_px),
                           tried.sample.offset_px);
    }
  });
  samples_.clear();
  for (const Tried& tried : tried_)
    if (tried.valid) samples_.push_back(tried.sample);
  return filter_.update(samples_, left.size());
}

void alignRightImage(const cv::Mat1b& right, const RowOffsetModel& alignment,
                     double column_shift_px, cv::Mat1b& aligned) {
  if (alignment.isIdentity() && column_shift_px == 0) {
    aligned = right;
    return;
  }
  // Do not write to pixels that another cv::Mat shares: they may be the image of an earlier frame.
  if (!aligned.u || aligned.u->refcount > 1) aligned.release();
  aligned.create(right.size());
  const ShiftedRows rows(right, column_shift_px);
  parallelForEach(right.rows,
                  [&](int y) { warpRow(rows, y, alignment, right.size(), aligned.ptr(y)); });
}

}  // namespace predictive_stereo
