/// Parameter structs from and to yaml: nested keys, "matcher/p1" being p1 within matcher.
#pragma once

#include <string>

#include "params/param_table.h"

namespace predictive_stereo {

/// Sets the parameters that a yaml text names; the others keep their values.
/// @param source  a name for the text in error messages.
/// @param section  keys that lead to the parameters, e.g. "disparity/matcher"; empty: the top. A
///   section that is not there sets nothing.
/// @throws std::invalid_argument for what is not yaml, unknown keys (the nearest known one is
///   suggested), and values that are refused, each with source and line.
void setFromYaml(const std::string& yaml, const std::string& source, ParamTable& table,
                 const std::string& section = "");

/// The same from a file.
/// @throws std::runtime_error where it cannot be read.
void setFromYamlFile(const std::string& path, ParamTable& table, const std::string& section = "");

/// All parameters with their values, their limits as comments.
std::string toYaml(const ParamTable& table);

}  // namespace predictive_stereo
