#pragma once

#include <sstream>
#include <stdexcept>

#include "predictive_stereo/matcher.h"

namespace predictive_stereo {

/// @throws std::invalid_argument if a parameter is outside its limits, range.count is not a
///   multiple of 16, or p2 <= p1.
inline void validateMatcher(const MatcherParams& params) {
  validate(params);
  std::ostringstream text;
  if (params.range.count % 16 != 0)
    text << "range/count = " << params.range.count << ": must be a multiple of 16";
  else if (params.p2 <= params.p1)
    text << "p2 = " << params.p2 << ": must be larger than p1 = " << params.p1;
  if (!text.str().empty()) throw std::invalid_argument(text.str());
}

}  // namespace predictive_stereo
