/// The paper's detector: section 4.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// Windows of all sizes whose mean difference reaches params.min_mean_difference_px, from an
/// integral image; in the order of sizes, rows, columns.
std::vector<cv::Rect> movingWindows(const cv::Mat1f& difference_px,
                                    const PaperDetectionParams& params);

/// While two boxes overlap by at least `min_iou`, replaces the pair with the highest intersection
/// over union by the smallest box that contains both; of equal pairs, the first one.
void mergeBoxes(double min_iou, std::vector<cv::Rect>& boxes);

/// movingWindows, merged, without boxes that are too small. The step is doubled until there are at
/// most 2000 windows: a near car can have more, and a wrong pose many more.
std::vector<cv::Rect> movingBoxes(const cv::Mat1f& difference_px,
                                  const PaperDetectionParams& params);

}  // namespace predictive_stereo
