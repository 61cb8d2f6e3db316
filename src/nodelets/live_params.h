#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/console.h>
#include <ros/node_handle.h>

#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nodelets/callbacks.h"
#include "params/param_table.h"

namespace predictive_stereo {

/// Sets the parameters of the table from the ROS parameter server, in the namespace of `node`.
/// Parameters that the server does not have keep their values.
/// @param table  its names begin with that namespace, so that errors show full names.
/// @returns a warning for each name in that namespace that the table does not have.
/// @throws std::invalid_argument for a wrong value, with the parameter, the value and its limits.
std::vector<std::string> setFromRosParams(const ros::NodeHandle& node, ParamTable& table);

/// The launch files load their file `config` here, too.
constexpr char kConfigNamespace[] = "predictive_stereo_config";

/// @param node  of the camera's namespace.
/// @returns a warning for each section of that file that no nodelet reads.
std::vector<std::string> unknownSections(const ros::NodeHandle& node);

// Conversions to and from the messages of dynamic_reconfigure. `section` of
// config/predictive_stereo.yaml describes the parameters.
using Assignments = std::vector<std::pair<std::string, std::string>>;  // name, value
dynamic_reconfigure::ConfigDescription descriptionOf(const ParamTable& defaults,
                                                     const std::string& section);
dynamic_reconfigure::Config configOf(const ParamTable& table);
/// Those that change a value: some clients send all parameters to change one.
Assignments changesBy(const dynamic_reconfigure::Config& request, const ParamTable& table);
/// So a restarted nodelet keeps the changed values.
void storeAsRosParams(const Assignments& changes, const ParamTable& table,
                      const ros::NodeHandle& node);

/// A parameter struct that users can change while the nodelet runs, by dynamic_reconfigure. Names,
/// types, limits and choices are those of its ParamTable, so no code is generated.
///
/// The server of dynamic_reconfigure clamps values silently. Here a request with a value that is
/// not allowed fails and changes nothing, and the log says why. Requests arrive in ROS's threads;
/// the nodelet takes the changed values between two frames.
template <class Params>
class LiveParams {
 public:
  /// @param node  its namespace has the topics, the service and the ROS parameters.
  /// @param check  throws std::invalid_argument for values that exclude each other.
  /// @param fixed  name prefixes of the parameters that cannot change.
  LiveParams(const ros::NodeHandle& node, Health& health, const Params& params,
             const std::string& section, std::function<void(const Params&)> check,
             const std::vector<std::string>& fixed)
      : node_(node), params_(params), check_(std::move(check)), fixed_(fixed) {
    using namespace dynamic_reconfigure;
    Params defaults;
    description_ = node_.advertise<ConfigDescription>("parameter_descriptions", 1, true);
    description_.publish(descriptionOf(tableOf(defaults), section));
    updates_ = node_.advertise<Config>("parameter_updates", 1, true);
    updates_.publish(configOf(table_));
    service_ = advertiseService<ReconfigureRequest, ReconfigureResponse>(
        node_, health, "set_parameters", [this](const auto& request, auto& response) {
          return onRequest(request.config, response.config);
        });
  }

  LiveParams(const LiveParams&) = delete;
  LiveParams& operator=(const LiveParams&) = delete;

  /// All parameters, if some were changed since the last call.
  std::optional<Params> takeChanged() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(changed_, std::nullopt);
  }

 private:
  ParamTable tableOf(Params& params) const {
    ParamTable table(params);
    for (const std::string& beginning : fixed_) table.remove(beginning);
    return table;
  }

  bool onRequest(const dynamic_reconfigure::Config& request,
                 dynamic_reconfigure::Config& response) {
    const Assignments changes = changesBy(request, table_);
    try {
      if (!changes.empty()) set(changes);
    } catch (const std::exception& error) {
      ROS_WARN_STREAM(node_.getNamespace() << ": nothing is reconfigured: " << error.what());
      return false;
    }
    for (const auto& [name, text] : changes)
      ROS_INFO_STREAM(node_.getNamespace() << ": from now on " << name << " = " << text);
    response = configOf(table_);
    updates_.publish(response);
    storeAsRosParams(changes, table_, node_);
    return true;
  }

  // All of them, or none, and throws std::invalid_argument.
  void set(const Assignments& changes) {
    Params trial = params_;
    ParamTable table = tableOf(trial);
    for (const auto& [name, text] : changes) table.set(name, text);
    check_(trial);
    const std::lock_guard<std::mutex> lock(mutex_);
    params_ = trial;
    changed_ = trial;
  }

  ros::NodeHandle node_;
  Params params_;
  const std::function<void(const Params&)> check_;
  const std::vector<std::string> fixed_;
  const ParamTable table_ = tableOf(params_);
  std::mutex mutex_;
  std::optional<Params> changed_;
  ros::Publisher description_, updates_;
  ros::ServiceServer service_;  // last: uses the members above
};

}  // namespace predictive_stereo
