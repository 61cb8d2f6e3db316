#include "params/param_table.h"

#include <boost/lexical_cast/try_lexical_convert.hpp>
#include <cstdlib>
#include <limits>

namespace predictive_stereo {

extern const char* const kAnnotatedYaml;  // made by CMake from config/predictive_stereo.yaml

namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& text, const char* expected) {
  throw std::invalid_argument(name + " = " + text + ": must be " + expected);
}

/// Levenshtein distance: number of letters to insert, delete or replace to get from `a` to `b`.
size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return row[b.size()];
}

/// `text` without the "#" and the spaces before it.
std::string afterHash(const std::string& text) {
  const size_t begin = text.find_first_not_of("# ");
  return begin == std::string::npos ? "" : text.substr(begin);
}

std::map<std::string, std::string> readTexts() {
  std::map<std::string, std::string> texts;
  std::vector<std::string> path;  // keys that lead to the line
  std::string above;
  std::istringstream lines(kAnnotatedYaml);
  for (std::string line; std::getline(lines, line);) {
    const size_t indent = line.find_first_not_of(' ');
    if (indent == std::string::npos) {
      above.clear();
    } else if (line[indent] == '#') {
      above += (above.empty() ? "" : " ") + afterHash(line.substr(indent));
    } else {
      path.resize(indent / 2);
      path.push_back(line.substr(indent, line.find(':') - indent));
      std::string name;
      for (const std::string& key : path) name += (name.empty() ? "" : "/") + key;
      const size_t hash = line.find('#');
      texts[name] = hash == std::string::npos ? above : afterHash(line.substr(hash));
      above.clear();
    }
  }
  return texts;
}

}  // namespace

std::string formatParam(double value) {
  // The shortest text that is parsed as the same value.
  for (int digits = 6; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    std::ostringstream text;
    text.precision(digits);
    text << value;
    if (std::strtod(text.str().c_str(), nullptr) == value) return text.str();
  }
  return std::to_string(value);
}

std::string formatParam(int value) { return std::to_string(value); }
std::string formatParam(bool value) { return value ? "true" : "false"; }

void parseParam(const std::string& name, const std::string& text, double& value) {
  if (!boost::conversion::try_lexical_convert(text, value)) refuse(name, text, "a number");
}

void parseParam(const std::string& name, const std::string& text, int& value) {
  if (!boost::conversion::try_lexical_convert(text, value)) refuse(name, text, "a whole number");
}

void parseParam(const std::string& name, const std::string& text, bool& value) {
  if (text == "true" || text == "True" || text == "1")
    value = true;
  else if (text == "false" || text == "False" || text == "0")
    value = false;
  else
    refuse(name, text, "true or false");
}

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  // Longer names resemble no known one, and the distance is slow to compute.
  constexpr size_t kLongest = 100;
  const std::string beginning = name.substr(0, kLongest);
  std::string nearest;
  size_t least = std::numeric_limits<size_t>::max();
  for (const std::string& candidate : known) {
    const size_t distance = editDistance(beginning, candidate);
    if (distance >= least) continue;
    least = distance;
    nearest = candidate;
  }
  return nearest;
}

bool ParamTable::has(const std::string& name) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [&](const Entry& entry) { return entry.name == name; });
}

void ParamTable::remove(const std::string& beginning) {
  entries_.erase(std::remove_if(entries_.begin(), entries_.end(),
                                [&](const Entry& entry) {
                                  return entry.name.compare(0, beginning.size(), beginning) == 0;
                                }),
                 entries_.end());
}

const ParamTable::Entry& ParamTable::entry(const std::string& name) const {
  std::vector<std::string> known;
  for (const Entry& entry : entries_) {
    if (entry.name == name) return entry;
    known.push_back(entry.name);
  }
  throw std::invalid_argument(
      "unknown parameter " + name +
      (known.empty() ? "" : "; did you mean " + nearestName(name, known) + "?"));
}

void ParamTable::setAssignment(const std::string& assignment) {
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0)
    throw std::invalid_argument("\"" + assignment + "\": must be name=value");
  set(assignment.substr(0, equals), assignment.substr(equals + 1));
}

const std::map<std::string, std::string>& paramTexts() {
  static const std::map<std::string, std::string> texts = readTexts();
  return texts;
}

}  // namespace predictive_stereo
