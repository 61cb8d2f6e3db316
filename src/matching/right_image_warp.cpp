#include <algorithm>
#include <cmath>
#include <cstdint>

#include "parallel/tasks.h"
#include "predictive_stereo/row_alignment.h"

namespace predictive_stereo {
namespace {

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
