#include "predictive_stereo/post_filter.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "filtering/hole_kernels.h"
#include "filtering/post_filter_kernels.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// At an occlusion boundary the census window, of this reach, covers both surfaces.
constexpr float kHiddenSlack_px = 4.0f;

void createApart(const char* name, const cv::Mat1f& input, cv::Mat1f& output) {
  output.create(input.size());
  if (!input.empty() && output.datastart < input.dataend && input.datastart < output.dataend)
    throw std::invalid_argument(std::string(name) +
                                ": input and output share memory; give another cv::Mat as output");
}

// Calls prepare(y, row) for every row of an image, then kernel(y, rows) with the prepared rows from
// y - kReach to y + kReach while they are in the cache. Rows and columns outside the image are
// `outside`.
template <int kReach, class T, class Prepare, class Kernel>
void filterRows(cv::Size size, T outside, const Prepare& prepare, const Kernel& kernel) {
  constexpr int kBandRows = 32, kRows = 2 * kReach + 1;
  const int bands = (size.height + kBandRows - 1) / kBandRows;
  const int step = size.width + 2 * kReach;
  parallelFor(cv::Range(0, bands), [&](const cv::Range& part) {
    cv::AutoBuffer<T, (kRows + 1) * 2048> memory(static_cast<size_t>((kRows + 1) * step));
    std::fill_n(memory.data(), memory.size(), outside);
    const auto row = [&](int y) {
      const int place = y < 0 || y >= size.height ? kRows : y % kRows;
      return memory.data() + place * step + kReach;
    };
    for (int band = part.start; band < part.end; ++band) {
      const int begin = band * kBandRows, end = std::min(begin + kBandRows, size.height);
      int next = std::max(begin - kReach, 0);  // first row that is not prepared yet
      for (int y = begin; y < end; ++y) {
        for (; next <= std::min(y + kReach, size.height - 1); ++next) prepare(next, row(next));
        std::array<const T*, kRows> rows;
        for (int i = 0; i < kRows; ++i) rows[i] = row(y + i - kReach);
        kernel(y, rows.data());
      }
    }
  });
}

}  // namespace

void filterBySupport(const DisparityRange& range, int min_support, const cv::Mat1f& disparity_px,
                     cv::Mat1f& filtered_px) {
  createApart("filterBySupport", disparity_px, filtered_px);
  const cv::Size size = disparity_px.size();
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  filterRows<2>(
      size, kNoSupportKey,
      [&](int y, int32_t* keys) {
        supportKeysOfRow(disparity_px[y], size.width, smallest_valid, keys);
      },
      [&](int y, const int32_t* const* keys) {
        filterRowBySupport(disparity_px[y], keys, size.width, smallest_valid, range.invalid(),
                           min_support, filtered_px[y]);
      });
}

void fillHoles(const DisparityRange& range, int max_length, float tolerance_px,
               const cv::Mat1f& disparity_px, cv::Mat1f& filled_px) {
  createApart("fillHoles", disparity_px, filled_px);
  const cv::Size size = disparity_px.size();
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  const HoleLimits limits{max_length, tolerance_px, kHiddenSlack_px};
  parallelFor(cv::Range(0, size.height), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      std::copy_n(disparity_px[y], size.width, filled_px[y]);
      fillHolesOfRow(size.width, smallest_valid, limits, filled_px[y]);
    }
  });
  constexpr int kStrip = 64;  // columns
  parallelFor(cv::Range(0, (size.width + kStrip - 1) / kStrip), [&](const cv::Range& strips) {
    for (int x = strips.start * kStrip; x < std::min(strips.end * kStrip, size.width); x += kStrip)
      fillHolesOfColumns(filled_px[0] + x, static_cast<ptrdiff_t>(filled_px.step1()),
                         std::min(kStrip, size.width - x), size.height, smallest_valid, limits);
  });
}

void median3x3(const DisparityRange& range, const cv::Mat1f& disparity_px, cv::Mat1f& filtered_px) {
  createApart("median3x3", disparity_px, filtered_px);
  const cv::Size size = disparity_px.size();
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  filterRows<1>(
      size, range.invalid(),
      [&](int y, float* row) { std::copy_n(disparity_px[y], size.width, row); },
      [&](int y, const float* const* rows) {
        medianOfRow(rows, size.width, smallest_valid, range.invalid(), filtered_px[y]);
      });
}

}  // namespace predictive_stereo
