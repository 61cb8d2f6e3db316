#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "params/param_table.h"

namespace predictive_stereo {

/// Sets every parameter of the table that the ROS parameter server has in the namespace of `node`;
/// the others keep their values.
/// @param table  made with rosParamPrefix(node), so that errors show full names.
/// @returns a warning for each name there that the table does not have.
/// @throws std::invalid_argument that names the parameter, its value and what is allowed.
std::vector<std::string> setFromRosParams(const ros::NodeHandle& node, ParamTable& table);

std::string rosParamPrefix(const ros::NodeHandle& node);

}  // namespace predictive_stereo
