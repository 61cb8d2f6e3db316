#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "params/param_table.h"

namespace predictive_stereo {

/// Sets the parameters of the table from the ROS parameter server, in the namespace of `node`.
/// Parameters that the server does not have keep their values.
/// @param table  made with rosParamPrefix(node), so that errors show full names.
/// @returns a warning for each name in that namespace that the table does not have.
/// @throws std::invalid_argument for a wrong value, with the parameter, the value and its limits.
std::vector<std::string> setFromRosParams(const ros::NodeHandle& node, ParamTable& table);

std::string rosParamPrefix(const ros::NodeHandle& node);

}  // namespace predictive_stereo
