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

/// @throws std::invalid_argument always: "name = value: must be within [smallest, largest]".
template <class T>
[[noreturn]] void throwOutOfRange(const std::string& name, T value, T smallest, T largest) {
  std::ostringstream text;
  text << name << " = " << value << ": must be within [" << smallest << ", " << largest << "]";
  throw std::invalid_argument(text.str());
}

/// A visitor that checks values against their limits.
class ParamValidator {
 public:
  /// @param prefix  of the names in messages, e.g. "search/".
  explicit ParamValidator(std::string prefix = "") : prefix_(std::move(prefix)) {}

  /// @throws std::invalid_argument if `value` is NaN or outside [smallest, largest].
  template <class T>
  void operator()(const char* name, T& value, T smallest, T largest) {
    if (!(value >= smallest && value <= largest))
      throwOutOfRange(prefix_ + name, value, smallest, largest);
  }
  /// @throws std::invalid_argument if `value` is none of `choices`.
  template <class Enum>
  void operator()(const char* name, Enum& value, Choices<Enum> choices) {
    for (const auto& choice : choices)
      if (choice.second == value) return;
    throw std::invalid_argument(prefix_ + name + " = " + std::to_string(static_cast<int>(value)) +
                                ": must be one of its enumerators");
  }
  void operator()(const char*, bool&) {}
  void operator()(const char*, std::string&) {}
  /// @throws std::invalid_argument as for the members of `nested`.
  template <class Struct, class = std::enable_if_t<std::is_class_v<Struct>>>
  void operator()(const char* name, Struct& nested) {
    nested.visit(ParamValidator(prefix_ + name + "/"));
  }

 private:
  std::string prefix_;
};

/// Checks every member of a parameter struct against its limits.
/// @param prefix  of the names in messages, e.g. "search/".
/// @throws std::invalid_argument if a member is outside its limits; the message has the name, the
///   value and the limits.
template <class Params>
void validate(Params params, const std::string& prefix = "") {
  params.visit(ParamValidator(prefix));
}

}  // namespace predictive_stereo
