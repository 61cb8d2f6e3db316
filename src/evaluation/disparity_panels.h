/// Pictures of one frame's disparities.
#pragma once

#include <string>
#include <vector>

#include "evaluation/disparity_method.h"
#include "evaluation/report.h"
#include "evaluation/sequence.h"

namespace predictive_stereo {

/// Pictures of one frame and method: its disparities, its errors and (ours) its standard
/// deviations, search widths and, with a past, the difference of measured and predicted disparities
/// with the detected objects (the paper's figure 4). The first method also shows the left image.
std::vector<Panel> panelsOf(const SequenceFrame& frame, const std::string& title,
                            const std::string& method, bool first, const DisparityRange& range,
                            const MethodOutput& output);

}  // namespace predictive_stereo
