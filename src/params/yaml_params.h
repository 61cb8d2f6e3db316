/// Parameter structs from and to yaml: nested keys, "matcher/p1" being p1 within matcher.
#pragma once

#include <string>

#include "params/param_table.h"

namespace predictive_stereo {

/// Sets the parameters that a yaml text contains; the others keep their values.
/// @param source  name of the text in error messages.
/// @throws std::invalid_argument if the text is not yaml, for unknown keys (the nearest known one
///   is suggested), and for values that are not allowed; the message has source and line.
void setFromYaml(const std::string& yaml, const std::string& source, ParamTable& table);

/// The same from a file.
/// @throws std::invalid_argument as setFromYaml does.
/// @throws std::runtime_error if the file cannot be read.
void setFromYamlFile(const std::string& path, ParamTable& table);

/// All parameters with their values, and with their limits as comments.
std::string toYaml(const ParamTable& table);

}  // namespace predictive_stereo
