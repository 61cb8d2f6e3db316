#include "params/yaml_params.h"

#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iterator>
#include <sstream>

namespace predictive_stereo {
namespace {

class YamlReader {
 public:
  YamlReader(const std::string& source, ParamTable& table) : source_(source), table_(table) {}

  /// @param path  keys from the top level to `node`, each followed by a slash.
  void read(const YAML::Node& node, const std::string& path) {
    if (node.IsNull() || !node.IsDefined()) return;
    if (!node.IsMap())
      refuse(node, (path.empty() ? "the top level" : path) + ": expected keys with values");
    for (const auto& item : node) {
      const std::string name = path + item.first.Scalar();
      if (item.second.IsMap()) {
        read(item.second, name + "/");
        continue;
      }
      if (!item.second.IsScalar()) refuse(item.second, name + ": expected a single value");
      try {
        table_.set(name, item.second.Scalar());
      } catch (const std::invalid_argument& error) {
        refuse(item.first, error.what());
      }
    }
  }

  [[noreturn]] void refuse(const YAML::Node& node, const std::string& reason) const {
    std::string place = source_;
    if (node.Mark().line >= 0) place += ":" + std::to_string(node.Mark().line + 1);
    throw std::invalid_argument(place + ": " + reason);
  }

 private:
  std::string source_;
  ParamTable& table_;
};

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream text(path);
  for (std::string part; std::getline(text, part, '/');)
    if (!part.empty()) parts.push_back(part);
  return parts;
}

}  // namespace

void setFromYaml(const std::string& yaml, const std::string& source, ParamTable& table,
                 const std::string& section) {
  YAML::Node node;
  try {
    node = YAML::Load(yaml);
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(source + ": not valid yaml: " + error.what());
  }
  YamlReader reader(source, table);
  for (const std::string& key : split(section)) {
    if (node.IsNull()) return;
    if (!node.IsMap()) reader.refuse(node, "expected keys with values");
    const YAML::Node next = node[key];
    if (!next.IsDefined()) return;
    node.reset(next);
  }
  reader.read(node, "");
}

void setFromYamlFile(const std::string& path, ParamTable& table, const std::string& section) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  setFromYaml(text, path, table, section);
}

std::string toYaml(const ParamTable& table) {
  std::ostringstream yaml;
  std::vector<std::string> open;  // sections of the last written line
  for (const auto& entry : table.entries()) {
    const std::vector<std::string> path = split(entry.name);
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
