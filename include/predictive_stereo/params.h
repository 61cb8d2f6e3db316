/// Parameter structs: one mechanism for defaults, limits, reading and checking.
///
/// A stage's parameter struct holds documented members with default values, the only source of
/// defaults, and one member template that names each of them:
///
///     struct CorrectionParams {
///       double gate_sigma = 3.0;  ///< innovations beyond this many sigma reset the filter
///       template <class Visitor>
///       void visit(Visitor&& v) {
///         v("gate_sigma", gate_sigma, 1.0, 100.0);
///       }
///     };
///
/// A numeric member is visited as (name, value, smallest, largest), both limits allowed; a bool or
/// a std::string as (name, value); an enum as (name, value, choices), where `choices` is a list of
/// (text, enumerator) pairs; a nested struct as (name, struct), its members then being named
/// "struct/member". Readers of yaml files, of the ROS parameter server and of command lines are
/// such visitors, and so is `validate` below.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace predictive_stereo {

/// Texts by which an enum is set in yaml and on command lines.
template <class Enum>
using Choices = std::initializer_list<std::pair<const char*, Enum>>;

/// Throws std::invalid_argument with "name = value: must be within [smallest, largest]".
template <class T>
[[noreturn]] void throwOutOfRange(const std::string& name, T value, T smallest, T largest) {
  std::ostringstream text;
  text << name << " = " << value << ": must be within [" << smallest << ", " << largest << "]";
  throw std::invalid_argument(text.str());
}

/// A visitor that refuses values outside their limits (NaN included).
class ParamValidator {
 public:
  explicit ParamValidator(std::string prefix = "") : prefix_(std::move(prefix)) {}

  template <class T>
  void operator()(const char* name, T& value, T smallest, T largest) {
    if (!(value >= smallest && value <= largest))
      throwOutOfRange(prefix_ + name, value, smallest, largest);
  }
  template <class Enum>
  void operator()(const char* name, Enum& value, Choices<Enum> choices) {
    for (const auto& choice : choices)
      if (choice.second == value) return;
    throw std::invalid_argument(prefix_ + name + " = " + std::to_string(static_cast<int>(value)) +
                                ": is none of its choices");
  }
  void operator()(const char*, bool&) {}
  void operator()(const char*, std::string&) {}
  template <class Struct, class = std::enable_if_t<std::is_class_v<Struct>>>
  void operator()(const char* name, Struct& nested) {
    nested.visit(ParamValidator(prefix_ + name + "/"));
  }

 private:
  std::string prefix_;
};

/// Checks every member of a parameter struct against its limits.
/// @throws std::invalid_argument that names the parameter, its value and the allowed range.
template <class Params>
void validate(Params params, const std::string& prefix = "") {
  params.visit(ParamValidator(prefix));
}

}  // namespace predictive_stereo
