#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "predictive_stereo/params.h"

namespace predictive_stereo {

/// Conversions between parameter values and their text in yaml files and command lines.
/// @param name  of the parameter, for messages.
/// @throws std::invalid_argument (parseParam) if the text is not a value of this type.
std::string formatParam(double value);
std::string formatParam(int value);
std::string formatParam(bool value);
void parseParam(const std::string& name, const std::string& text, double& value);
void parseParam(const std::string& name, const std::string& text, int& value);
void parseParam(const std::string& name, const std::string& text, bool& value);

/// The name in `known`, which must not be empty, that is most similar to `name`.
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

/// A parameter struct as a list of names whose values are read and set as text, for readers of
/// yaml, ROS parameters and command lines. Refers to the struct, which must outlive it.
class ParamTable {
 public:
  enum class Type { kInt, kDouble, kBool, kChoice, kText };
  struct Entry {
    std::string name;  ///< "struct/member"
    Type type;
    std::string limits;  ///< "[0.5, 64]", "straight_4 | all_8", ... for help texts
    std::function<std::string()> get;
    std::function<void(const std::string&)> set;  ///< throws std::invalid_argument
    double smallest = 0, largest = 0;             ///< of numbers
    std::vector<std::string> choices = {};
  };

  /// @param prefix  of all names, e.g. "disparity/".
  template <class Params>
  explicit ParamTable(Params& params, const std::string& prefix = "") {
    params.visit(Collector{*this, prefix});
  }

  const std::vector<Entry>& entries() const { return entries_; }
  bool has(const std::string& name) const;
  /// @throws std::invalid_argument for an unknown name (the nearest known one is suggested).
  const Entry& entry(const std::string& name) const;
  /// Removes the parameters whose names begin with `beginning`.
  void remove(const std::string& beginning);
  /// @throws std::invalid_argument as entry() does, for a text that is not a value of this type, or
  ///   for a value outside its limits.
  void set(const std::string& name, const std::string& text) { entry(name).set(text); }
  /// Sets a parameter from "name=value".
  /// @throws std::invalid_argument as set() does, or if there is no "=" or no name.
  void setAssignment(const std::string& assignment);

 private:
  struct Collector {
    ParamTable& table;
    std::string prefix;

    template <class T>
    void operator()(const char* name, T& value, T smallest, T largest) const {
      const std::string full = prefix + name;
      table.entries_.push_back({full, std::is_same_v<T, int> ? Type::kInt : Type::kDouble,
                                "[" + formatParam(smallest) + ", " + formatParam(largest) + "]",
                                [&value] { return formatParam(value); },
                                [&value, full, smallest, largest](const std::string& text) {
                                  T parsed;
                                  parseParam(full, text, parsed);
                                  if (!(parsed >= smallest && parsed <= largest))
                                    throwOutOfRange(full, parsed, smallest, largest);
                                  value = parsed;
                                },
                                static_cast<double>(smallest), static_cast<double>(largest)});
    }

    template <class Enum>
    void operator()(const char* name, Enum& value, Choices<Enum> choices) const {
      const std::string full = prefix + name;
      const std::vector<std::pair<std::string, Enum>> list(choices.begin(), choices.end());
      std::string names;
      std::vector<std::string> texts;
      for (const auto& choice : list) {
        names += (names.empty() ? "" : " | ") + choice.first;
        texts.push_back(choice.first);
      }
      table.entries_.push_back({full, Type::kChoice, names,
                                [&value, list] {
                                  for (const auto& choice : list)
                                    if (choice.second == value) return choice.first;
                                  return std::string("?");
                                },
                                [&value, full, list, names](const std::string& text) {
                                  for (const auto& choice : list)
                                    if (choice.first == text) {
                                      value = choice.second;
                                      return;
                                    }
                                  throw std::invalid_argument(full + " = " + text +
                                                              ": must be one of " + names);
                                },
                                0, 0, texts});
    }

    void operator()(const char* name, bool& value) const {
      const std::string full = prefix + name;
      const auto set = [&value, full](const std::string& text) { parseParam(full, text, value); };
      table.entries_.push_back(
          {full, Type::kBool, "true | false", [&value] { return formatParam(value); }, set});
    }

    void operator()(const char* name, std::string& value) const {
      const auto set = [&value](const std::string& text) { value = text; };
      table.entries_.push_back(
          {prefix + name, Type::kText, "text", [&value] { return value; }, set});
    }

    template <class Struct, class = std::enable_if_t<std::is_class_v<Struct>>>
    void operator()(const char* name, Struct& nested) const {
      nested.visit(Collector{table, prefix + name + "/"});
    }
  };

  std::vector<Entry> entries_;
};

/// What config/predictive_stereo.yaml says of each parameter, allowed values in brackets included:
/// "section/struct/member" -> the comment behind its value, or else in the lines above.
const std::map<std::string, std::string>& paramTexts();

}  // namespace predictive_stereo
