#pragma once

#include <map>
#include <string>

namespace predictive_stereo {

/// What config/predictive_stereo.yaml says of each parameter, allowed values in brackets included:
/// "section/struct/member" -> the comment behind its value, or else in the lines above.
const std::map<std::string, std::string>& paramTexts();

}  // namespace predictive_stereo
