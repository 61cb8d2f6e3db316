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

// Calls kernel(rows around y, output row) for every row; rows outside the image are null.
template <int kReach, class Kernel>
void filterRows(const char* name, const cv::Mat1f& input, cv::Mat1f& output, const Kernel& kernel) {
  output.create(input.size());
  if (input.empty()) return;
  if (output.datastart < input.dataend && input.datastart < output.dataend)
    throw std::invalid_argument(std::string(name) +
                                ": input and output share memory; give it another output");
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

}  // namespace predictive_stereo
