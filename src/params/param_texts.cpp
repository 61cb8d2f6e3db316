#include <sstream>
#include <vector>

#include "params/param_table.h"

namespace predictive_stereo {

extern const char* const kAnnotatedYaml;  // made by CMake from config/predictive_stereo.yaml

namespace {

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

const std::map<std::string, std::string>& paramTexts() {
  static const std::map<std::string, std::string> texts = readTexts();
  return texts;
}

}  // namespace predictive_stereo
