#include "params/yaml_params.h"

#include <yaml-cpp/yaml.h>

#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/split.hpp>
#include <fstream>
#include <iterator>
#include <sstream>

namespace predictive_stereo {
namespace {

[[noreturn]] void refuse(const std::string& source, const YAML::Node& node,
                         const std::string& reason) {
  std::string place = source;
  if (node.Mark().line >= 0) place += ":" + std::to_string(node.Mark().line + 1);
  throw std::invalid_argument(place + ": " + reason);
}

/// @param path  keys from the top level to `node`, each followed by a slash.
void setFromNode(const YAML::Node& node, const std::string& path, const std::string& source,
                 ParamTable& table) {
  if (node.IsNull() || !node.IsDefined()) return;
  if (!node.IsMap())
    refuse(source, node, (path.empty() ? "the top level" : path) + ": expected keys with values");
  for (const auto& item : node) {
    const std::string name = path + item.first.Scalar();
    if (item.second.IsMap()) {
      setFromNode(item.second, name + "/", source, table);
      continue;
    }
    if (!item.second.IsScalar()) refuse(source, item.second, name + ": expected a single value");
    try {
      table.set(name, item.second.Scalar());
    } catch (const std::invalid_argument& error) {
      refuse(source, item.first, error.what());
    }
  }
}

}  // namespace

void setFromYaml(const std::string& yaml, const std::string& source, ParamTable& table) {
  YAML::Node node;
  try {
    node = YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(source + ": not valid yaml: " + error.what());
  }
  setFromNode(node, "", source, table);
}

void setFromYamlFile(const std::string& path, ParamTable& table) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  setFromYaml(text, path, table);
}

std::string toYaml(const ParamTable& table) {
  std::ostringstream yaml;
  std::vector<std::string> open;  // sections of the last written line
  for (const auto& entry : table.entries()) {
    std::vector<std::string> path;
    boost::algorithm::split(path, entry.name, boost::algorithm::is_any_of("/"));
    size_t common = 0;
    while (common < open.size() && common + 1 < path.size() && open[common] == path[common])
      ++common;
    open.resize(common);
    for (; common + 1 < path.size(); ++common) {
      yaml << std::string(2 * common, ' ') << path[common] << ":\n";
      open.push_back(path[common]);
    }
    YAML::Emitter value;  // quotes texts if yaml needs it
    value << entry.get();
    const bool is_text = entry.type == ParamTable::Type::kText;
    yaml << std::string(2 * common, ' ') << path.back() << ": "
         << (is_text ? value.c_str() : entry.get()) << "  # " << entry.limits << "\n";
  }
  return yaml.str();
}

}  // namespace predictive_stereo
