/// Semi-global matching in plain C++: the slow reference that every kernel must equal bit for bit.
#pragma once

#include <opencv2/core.hpp>

#include "matching/principal_offset.h"
#include "matching/search_windows.h"
#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// Fills every member of `match` except search_width.
void matchReference(const cv::Mat1b& left, const cv::Mat1b& right, const MatcherParams& params,
                    const PrincipalOffset& offset, const SearchWindows& windows, Match& match);

}  // namespace predictive_stereo
