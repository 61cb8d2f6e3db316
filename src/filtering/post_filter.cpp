#include "predictive_stereo/post_filter.h"

#include <algorithm>
#include <array>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <string>

#include "filtering/post_filter_kernels.h"

namespace predictive_stereo {
namespace {

// Beside what is hidden the census window, which reaches as far, sees both surfaces.
constexpr float kHiddenSlack_px = 4.0f;

void createApart(const char* name, const cv::Mat1f& input, cv::Mat1f& output) {
  output.create(input.size());
  if (!input.empty() && output.datastart < input.dataend && input.datastart < output.dataend)
    throw std::invalid_argument(std::string(name) +
                                ": input and output share memory; give it another output");
}

// Calls kernel(rows around y, output row) for every row; rows outside the image are null.
template <int kReach, class Kernel>
void filterRows(const char* name, const cv::Mat1f& input, cv::Mat1f& output, const Kernel& kernel) {
  createApart(name, input, output);
  cv::parallel_for_(cv::Range(0, input.rows), [&](const cv::Range& range) {
    for (int y = range.start; y < range.end; ++y) {
      std::array<const float*, 2 * kReach + 1> rows{};
      for (int i = -kReach; i <= kReach; ++i)
        if (y + i >= 0 && y + i < input.rows) rows[i + kReach] = input[y + i];
      kernel(rows.data(), output[y]);
    }
  });
}

}  // namespace

void filterBySupport(const DisparityRange& range, int min_support, const cv::Mat1f& disparity_px,
                     cv::Mat1f& filtered_px) {
  filterRows<2>(
      "filterBySupport", disparity_px, filtered_px, [&](const float* const* rows, float* filtered) {
        filterRowBySupport(rows, disparity_px.cols, static_cast<float>(range.min_disparity),
                           range.invalid(), min_support, filtered);
      });
}

void median3x3(const DisparityRange& range, const cv::Mat1f& disparity_px, cv::Mat1f& filtered_px) {
  filterRows<1>("median3x3", disparity_px, filtered_px,
                [&](const float* const* rows, float* filtered) {
                  medianOfRow(rows, disparity_px.cols, static_cast<float>(range.min_disparity),
                              range.invalid(), filtered);
                });
}

void fillHoles(const DisparityRange& range, int max_width, float tolerance_px,
               const cv::Mat1f& disparity_px, cv::Mat1f& filled_px) {
  filled_px.create(disparity_px.size());
  const HoleLimits limits{max_width, tolerance_px, kHiddenSlack_px};
  cv::parallel_for_(cv::Range(0, disparity_px.rows), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      float* row = filled_px[y];
      if (row != disparity_px[y]) std::copy_n(disparity_px[y], disparity_px.cols, row);
      fillHolesOfRow(disparity_px.cols, static_cast<float>(range.min_disparity), limits, row);
    }
  });
}

void fillHolesAndMedian3x3(const DisparityRange& range, int max_width, float tolerance_px,
                           const cv::Mat1f& disparity_px, cv::Mat1f& filtered_px) {
  createApart("fillHolesAndMedian3x3", disparity_px, filtered_px);
  const auto smallest_valid = static_cast<float>(range.min_disparity);
  const HoleLimits limits{max_width, tolerance_px, kHiddenSlack_px};
  const cv::Size size = disparity_px.size();
  constexpr int kBandRows = 32;
  const int bands = (size.height + kBandRows - 1) / kBandRows;
  cv::parallel_for_(cv::Range(0, bands), [&](const cv::Range& part) {
    cv::AutoBuffer<float, 3 * 2048> memory(static_cast<size_t>(3 * size.width));
    const auto filled = [&](int y) { return memory.data() + y % 3 * size.width; };
    for (int band = part.start; band < part.end; ++band) {
      const int begin = band * kBandRows, end = std::min(begin + kBandRows, size.height);
      int next = std::max(begin - 1, 0);  // the first row that is not filled yet
      for (int y = begin; y < end; ++y) {
        for (; next <= std::min(y + 1, size.height - 1); ++next) {
          std::copy_n(disparity_px[next], size.width, filled(next));
          fillHolesOfRow(size.width, smallest_valid, limits, filled(next));
        }
        const float* const rows[3] = {y > 0 ? filled(y - 1) : nullptr, filled(y),
                                      y + 1 < size.height ? filled(y + 1) : nullptr};
        medianOfRow(rows, size.width, smallest_valid, range.invalid(), filtered_px[y]);
      }
    }
  });
}

}  // namespace predictive_stereo
