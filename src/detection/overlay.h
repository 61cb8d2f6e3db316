#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// The left image in colour, moving pixels tinted, each object with its box, id, distance and
/// speed.
void drawMovingObjects(const cv::Mat1b& left, const Detections& detections, cv::Mat3b& overlay);

}  // namespace predictive_stereo
