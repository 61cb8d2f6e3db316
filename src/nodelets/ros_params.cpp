#include "nodelets/ros_params.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <map>

namespace predictive_stereo {
namespace {

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

std::string rosParamPrefix(const ros::NodeHandle& node) { return node.getNamespace() + "/"; }

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

}  // namespace predictive_stereo
