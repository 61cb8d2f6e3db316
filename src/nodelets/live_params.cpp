#include "nodelets/live_params.h"

#include <dynamic_reconfigure/config_tools.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>
#include <map>
#include <set>

namespace predictive_stereo {
namespace {

using dynamic_reconfigure::Config;
using dynamic_reconfigure::ConfigDescription;
using dynamic_reconfigure::ConfigTools;
using dynamic_reconfigure::Group;
using Entry = ParamTable::Entry;
using Type = ParamTable::Type;

const std::map<Type, const char*> kTypeNames = {{Type::kInt, "int"},
                                                {Type::kDouble, "double"},
                                                {Type::kBool, "bool"},
                                                {Type::kChoice, "str"},
                                                {Type::kText, "str"}};

// Calls use(value) with the value of its type that `text` means.
template <class Use>
void useAs(const Entry& entry, const std::string& text, const Use& use) {
  const auto parsed = [&](auto value) {
    parseParam(entry.name, text, value);
    use(value);
  };
  if (entry.type == Type::kInt) return parsed(int());
  if (entry.type == Type::kDouble) return parsed(double());
  if (entry.type == Type::kBool) return parsed(bool());
  use(text);
}

// Description of an enum for dynamic_reconfigure's clients: a Python expression.
std::string editMethod(const Entry& entry) {
  std::string list;
  for (const std::string& choice : entry.choices)
    list += (list.empty() ? "" : ", ") + std::string("{'name': '") + choice + "', 'value': '" +
            choice + "', 'type': 'str', 'description': ''}";
  return list.empty() ? "" : "{'enum': [" + list + "], 'enum_description': ''}";
}

// One group per struct. The first one, of the parameters without a struct, contains the others.
// @param section  of the texts; empty: only limits.
std::vector<Group> groupsOf(const ParamTable& table, const std::string& section = "") {
  std::vector<Group> groups(1);
  groups[0].name = "Default";
  for (const Entry& entry : table.entries()) {
    const size_t slash = entry.name.rfind('/');
    const std::string name = slash == std::string::npos ? "Default" : entry.name.substr(0, slash);
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&](const Group& known) { return known.name == name; });
    if (group == groups.end()) {
      group = groups.emplace(groups.end());
      group->name = name;
      group->id = static_cast<int>(groups.size()) - 1;
    }
    dynamic_reconfigure::ParamDescription parameter;
    parameter.name = entry.name;
    parameter.type = kTypeNames.at(entry.type);
    const auto text = paramTexts().find(section + "/" + entry.name);
    parameter.description = text == paramTexts().end() ? entry.limits : text->second;
    parameter.edit_method = editMethod(entry);
    group->parameters.push_back(parameter);
  }
  return groups;
}

// @param text_of  gives the value of an entry.
template <class TextOf>
Config configOf(const ParamTable& table, const TextOf& text_of) {
  Config config;
  for (const Entry& entry : table.entries())
    useAs(entry, text_of(entry),
          [&](const auto& value) { ConfigTools::appendParameter(config, entry.name, value); });
  for (const Group& group : groupsOf(table)) {
    config.groups.emplace_back();
    config.groups.back().name = group.name;
    config.groups.back().id = group.id;
    config.groups.back().state = true;
  }
  return config;
}

Config limitsOf(const ParamTable& table, bool smallest) {
  return configOf(table, [&](const Entry& entry) {
    const double limit = smallest ? entry.smallest : entry.largest;
    if (entry.type == Type::kInt) return formatParam(static_cast<int>(limit));
    if (entry.type == Type::kDouble) return formatParam(limit);
    return entry.type == Type::kBool ? formatParam(!smallest) : entry.get();
  });
}

// Collects the names of all leaves of nested parameters, and their values as text.
void flatten(const std::string& name, XmlRpc::XmlRpcValue& value,
             std::map<std::string, std::string>& leaves) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeStruct:
      for (auto& member : value) flatten(name + "/" + member.first, member.second, leaves);
      break;
    case XmlRpc::XmlRpcValue::TypeString:
      leaves[name] = static_cast<std::string&>(value);
      break;
    case XmlRpc::XmlRpcValue::TypeInt:
      leaves[name] = formatParam(static_cast<int&>(value));
      break;
    case XmlRpc::XmlRpcValue::TypeDouble:
      leaves[name] = formatParam(static_cast<double&>(value));
      break;
    case XmlRpc::XmlRpcValue::TypeBoolean:
      leaves[name] = formatParam(static_cast<bool&>(value));
      break;
    default:
      leaves[name] = value.toXml();  // a list or a date: no parameter accepts it
  }
}

}  // namespace

std::vector<std::string> setFromRosParams(const ros::NodeHandle& node, ParamTable& table) {
  std::vector<std::string> warnings;
  XmlRpc::XmlRpcValue all;
  if (!node.getParam(node.getNamespace(), all)) return warnings;
  std::map<std::string, std::string> leaves;
  flatten(node.getNamespace(), all, leaves);
  for (const auto& [name, text] : leaves) {
    const bool known = table.has(name);
    try {
      table.set(name, text);
    } catch (const std::invalid_argument& error) {
      if (known) throw;
      warnings.push_back(error.what());
    }
  }
  return warnings;
}

std::vector<std::string> unknownSections(const ros::NodeHandle& node) {
  const std::set<std::string> known = {"ego_motion", "disparity", "moving_objects", "rectify_left",
                                       "rectify_right"};
  std::vector<std::string> warnings;
  XmlRpc::XmlRpcValue config;
  node.getParam(kConfigNamespace, config);
  if (config.getType() != XmlRpc::XmlRpcValue::TypeStruct) return warnings;
  for (const auto& [name, values] : config)
    if (known.count(name) == 0)
      warnings.push_back("config has '" + name +
                         "', which no nodelet reads: write parameters below ego_motion, disparity "
                         "or moving_objects");
  return warnings;
}

Config configOf(const ParamTable& table) {
  return configOf(table, [](const Entry& entry) { return entry.get(); });
}

ConfigDescription descriptionOf(const ParamTable& defaults, const std::string& section) {
  ConfigDescription description;
  description.groups = groupsOf(defaults, section);
  description.dflt = configOf(defaults);
  description.min = limitsOf(defaults, true);
  description.max = limitsOf(defaults, false);
  return description;
}

Assignments changesBy(const Config& request, const ParamTable& table) {
  Assignments changes;
  const auto add = [&](const std::string& name, const std::string& text) {
    if (!table.has(name) || table.entry(name).get() != text) changes.emplace_back(name, text);
  };
  for (const auto& item : request.ints) add(item.name, formatParam(item.value));
  for (const auto& item : request.doubles) add(item.name, formatParam(item.value));
  for (const auto& item : request.bools) add(item.name, formatParam(static_cast<bool>(item.value)));
  for (const auto& item : request.strs) add(item.name, item.value);
  return changes;
}

void storeAsRosParams(const Assignments& changes, const ParamTable& table,
                      const ros::NodeHandle& node) {
  for (const auto& change : changes)
    useAs(table.entry(change.first), change.second,
          [&](const auto& value) { node.setParam(change.first, value); });
}

}  // namespace predictive_stereo
