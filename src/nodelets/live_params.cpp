#include "nodelets/live_params.h"

#include <ros/console.h>

#include <exception>
#include <map>

#include "params/param_texts.h"

namespace predictive_stereo {
namespace {

using dynamic_reconfigure::Config;
using dynamic_reconfigure::ConfigDescription;
using Entry = ParamTable::Entry;
using Type = ParamTable::Type;

const char* typeName(Type type) {
  switch (type) {
    case Type::kInt:
      return "int";
    case Type::kDouble:
      return "double";
    case Type::kBool:
      return "bool";
    case Type::kChoice:
    case Type::kText:
      break;
  }
  return "str";
}

template <class Value>
Value parsed(const std::string& name, const std::string& text) {
  Value value{};
  parseParam(name, text, value);
  return value;
}

template <class Parameter, class Value>
void append(std::vector<Parameter>& list, const std::string& name, const Value& value) {
  list.emplace_back();
  list.back().name = name;
  list.back().value = value;
}

void append(const Entry& entry, const std::string& text, Config& config) {
  switch (entry.type) {
    case Type::kInt:
      return append(config.ints, entry.name, parsed<int>(entry.name, text));
    case Type::kDouble:
      return append(config.doubles, entry.name, parsed<double>(entry.name, text));
    case Type::kBool:
      return append(config.bools, entry.name, parsed<bool>(entry.name, text));
    case Type::kChoice:
    case Type::kText:
      return append(config.strs, entry.name, text);
  }
}

/// One group per nested struct. Group 0 contains all of them.
class Groups {
 public:
  Groups() { add("", "Default", 0); }

  /// Group of a parameter: that of "a/b" for "a/b/name".
  dynamic_reconfigure::Group& of(const std::string& name) {
    return groups_[static_cast<size_t>(find(name))];
  }
  const std::vector<dynamic_reconfigure::Group>& all() const { return groups_; }

 private:
  int find(const std::string& name) {
    const size_t slash = name.rfind('/');
    if (slash == std::string::npos) return 0;
    const std::string path = name.substr(0, slash);
    const auto known = ids_.find(path);
    if (known != ids_.end()) return known->second;
    const int parent = find(path);
    return add(path, path.substr(path.rfind('/') + 1), parent);
  }

  int add(const std::string& path, const std::string& title, int parent) {
    dynamic_reconfigure::Group group;
    group.name = title;
    group.parent = parent;
    group.id = static_cast<int>(groups_.size());
    groups_.push_back(group);
    return ids_[path] = group.id;
  }

  std::vector<dynamic_reconfigure::Group> groups_;
  std::map<std::string, int> ids_;
};

/// Description of an enum for dynamic_reconfigure's clients: a Python expression.
std::string editMethod(const Entry& entry) {
  std::string list;
  for (const std::string& choice : entry.choices)
    list += (list.empty() ? "" : ", ") + std::string("{'name': '") + choice + "', 'value': '" +
            choice + "', 'type': 'str', 'description': ''}";
  return list.empty() ? "" : "{'enum': [" + list + "], 'enum_description': ''}";
}

/// @param section  of the texts; empty: only limits.
Groups groupsOf(const ParamTable& table, const std::string& section = "") {
  Groups groups;
  for (const Entry& entry : table.entries()) {
    dynamic_reconfigure::ParamDescription parameter;
    parameter.name = entry.name;
    parameter.type = typeName(entry.type);
    const auto text = paramTexts().find(section + "/" + entry.name);
    parameter.description = text == paramTexts().end() ? entry.limits : text->second;
    parameter.edit_method = editMethod(entry);
    groups.of(entry.name).parameters.push_back(parameter);
  }
  return groups;
}

Config configOf(const ParamTable& table) {
  Config config;
  for (const Entry& entry : table.entries()) append(entry, entry.get(), config);
  const Groups groups = groupsOf(table);
  for (const dynamic_reconfigure::Group& group : groups.all()) {
    config.groups.emplace_back();
    config.groups.back().name = group.name;
    config.groups.back().id = group.id;
    config.groups.back().parent = group.parent;
    config.groups.back().state = true;
  }
  return config;
}

ConfigDescription descriptionOf(const ParamTable& defaults, const std::string& section) {
  ConfigDescription description;
  description.groups = groupsOf(defaults, section).all();
  description.dflt = configOf(defaults);
  description.min = description.max = description.dflt;
  for (auto* limits : {&description.min, &description.max}) {
    const bool smallest = limits == &description.min;
    limits->ints.clear();
    limits->doubles.clear();
    for (const Entry& entry : defaults.entries()) {
      const double limit = smallest ? entry.smallest : entry.largest;
      if (entry.type == Type::kInt)
        append(limits->ints, entry.name, static_cast<int>(limit));
      else if (entry.type == Type::kDouble)
        append(limits->doubles, entry.name, limit);
    }
    for (auto& flag : limits->bools) flag.value = !smallest;
  }
  return description;
}

ReconfigureServer::Assignments assignmentsOf(const Config& config) {
  ReconfigureServer::Assignments values;
  for (const auto& item : config.ints) values.emplace_back(item.name, formatParam(item.value));
  for (const auto& item : config.doubles) values.emplace_back(item.name, formatParam(item.value));
  for (const auto& item : config.bools)
    values.emplace_back(item.name, formatParam(static_cast<bool>(item.value)));
  for (const auto& item : config.strs) values.emplace_back(item.name, item.value);
  return values;
}

}  // namespace

ReconfigureServer::ReconfigureServer(const ros::NodeHandle& node, Health& health,
                                     const ParamTable& values, const ParamTable& defaults,
                                     const std::string& section,
                                     std::function<void(const Assignments&)> set)
    : node_(node), values_(values), set_(std::move(set)) {
  description_ = node_.advertise<ConfigDescription>("parameter_descriptions", 1, true);
  description_.publish(descriptionOf(defaults, section));
  updates_ = node_.advertise<Config>("parameter_updates", 1, true);
  updates_.publish(configOf(values_));
  using dynamic_reconfigure::ReconfigureRequest;
  using dynamic_reconfigure::ReconfigureResponse;
  service_ = advertiseService<ReconfigureRequest, ReconfigureResponse>(
      node_, health, "set_parameters",
      [this](ReconfigureRequest& request, ReconfigureResponse& response) {
        return onRequest(request, response);
      });
}

bool ReconfigureServer::onRequest(dynamic_reconfigure::Reconfigure::Request& request,
                                  dynamic_reconfigure::Reconfigure::Response& response) {
  // Some clients send all parameters to change one.
  Assignments changes;
  for (const auto& [name, text] : assignmentsOf(request.config))
    if (!values_.has(name) || values_.get(name) != text) changes.emplace_back(name, text);
  try {
    if (!changes.empty()) set_(changes);
  } catch (const std::exception& error) {
    ROS_WARN_STREAM(node_.getNamespace() << ": nothing is reconfigured: " << error.what());
    return false;
  }
  for (const auto& [name, text] : changes)
    ROS_INFO_STREAM(node_.getNamespace() << ": from now on " << name << " = " << text);
  response.config = configOf(values_);
  updates_.publish(response.config);
  storeAsRosParams(changes);
  return true;
}

// So a restarted nodelet keeps the changed values.
void ReconfigureServer::storeAsRosParams(const Assignments& changes) const {
  Config config;
  for (const auto& [name, text] : changes)
    for (const Entry& entry : values_.entries())
      if (entry.name == name) append(entry, text, config);
  for (const auto& item : config.ints) node_.setParam(item.name, item.value);
  for (const auto& item : config.doubles) node_.setParam(item.name, item.value);
  for (const auto& item : config.bools) node_.setParam(item.name, static_cast<bool>(item.value));
  for (const auto& item : config.strs) node_.setParam(item.name, item.value);
}

}  // namespace predictive_stereo
