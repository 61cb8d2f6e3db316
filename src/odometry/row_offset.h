#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_motion.h"
#include "predictive_stereo/row_alignment.h"

namespace predictive_stereo {

/// Row offset of one stereo match, seen at `position` of the left image.
struct RowOffsetSample {
  cv::Point2f position;
  float offset_px;
};

/// The offset of `alignment` at a position of the left image.
float rowOffset(const RowAlignment& alignment, cv::Point2f position, cv::Size size);

/// Robust fit of the offset's six coefficients, drawn towards `past` by `params.smoothing`. Returns
/// `past` where samples are too few, do not agree, or show an offset that is too large.
RowAlignment fitRowOffset(const std::vector<RowOffsetSample>& samples, cv::Size size,
                          const RowAlignment& past, const RowAlignmentParams& params);

}  // namespace predictive_stereo
