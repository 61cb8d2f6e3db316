#include "predictive_stereo/coarse_matcher.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "imaging/half_image.h"
#include "imaging/size_check.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

/// Parameters of the half resolution. Its range covers the full-resolution range, which is checked
/// here: the halved one is always within the limits.
MatcherParams halved(MatcherParams params) {
  validateMatcher(params);
  const DisparityRange full = params.range;
  const auto floorOfHalf = [](int value) { return (value - (value & 1)) / 2; };
  params.range.min_disparity = floorOfHalf(full.min_disparity);
  const int needed = floorOfHalf(full.max_disparity()) - params.range.min_disparity + 1;
  params.range.count = (needed + 15) / 16 * 16;
  if (params.left_right_tolerance_px > 0) params.left_right_tolerance_px = 1;
  params.census = CensusForm::k5x5;
  return params;
}

}  // namespace

CoarseMatcher::CoarseMatcher(const MatcherParams& params, int min_region_px)
    : full_params_(params), min_region_px_(min_region_px), matcher_(halved(params)) {}

void CoarseMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1f& disparity_px,
                          double principal_offset_px) {
  if (left.cols < 2 || left.rows < 2) {
    std::ostringstream text;
    text << "the left image is " << left.cols << "x" << left.rows
         << ": the half-resolution search needs at least 2x2 pixels";
    throw std::invalid_argument(text.str());
  }
  requireSize("the right image", right.size(), left.size(), "but the left one is");
  halveImage(left, left_half_);
  halveImage(right, right_half_);
  matcher_.match(left_half_, right_half_, match_, principal_offset_px / 2);
  constexpr int kPixelsOfHalf = 4;
  region_filter_.filter(matcher_.params().range, min_region_px_ / kPixelsOfHalf,
                        match_.disparity_px);

  // Invalid half disparities, and those that only the halved range has, are outside the range.
  const DisparityRange& range = full_params_.range;
  const auto fullOf = [lowest = static_cast<float>(range.min_disparity),
                       highest = static_cast<float>(range.max_disparity()),
                       invalid = range.invalid()](float half_px) {
    const float full_px = 2 * half_px;
    return full_px >= lowest && full_px <= highest ? full_px : invalid;
  };
  disparity_px.create(match_.disparity_px.size());
  parallelForEach(disparity_px.rows, [&](int y) {
    const float* const half_px = match_.disparity_px[y];
    std::transform(half_px, half_px + disparity_px.cols, disparity_px[y], fullOf);
  });
}

}  // namespace predictive_stereo
