#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/node_handle.h>

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

/// Topics and service of dynamic_reconfigure for the parameters of a table. Names, types, limits
/// and choices are those of the table, so no code is generated.
///
/// The server of dynamic_reconfigure clamps values silently. Here a request with a value that is
/// not allowed fails and changes nothing, and the log says why.
class ReconfigureServer {
 public:
  using Assignments = std::vector<std::pair<std::string, std::string>>;

  /// @param node  its namespace has the topics, the service and the ROS parameters.
  /// @param values  the current values; must outlive this object.
  /// @param defaults  default values of the same names, for the description.
  /// @param section  of config/predictive_stereo.yaml, which describes them.
  /// @param set  sets all values, or none and throws std::invalid_argument.
  ReconfigureServer(const ros::NodeHandle& node, Health& health, const ParamTable& values,
                    const ParamTable& defaults, const std::string& section,
                    std::function<void(const Assignments&)> set);

 private:
  bool onRequest(const dynamic_reconfigure::Config& request, dynamic_reconfigure::Config& response);
  void storeAsRosParams(const Assignments& changes) const;

  ros::NodeHandle node_;
  const ParamTable& values_;
  std::function<void(const Assignments&)> set_;
  ros::Publisher description_, updates_;
  ros::ServiceServer service_;  // last: uses the members above
};

/// A parameter struct that users can change while the nodelet runs. Requests arrive in ROS's
/// threads; the nodelet takes the changed values between two frames.
template <class Params>
class LiveParams {
 public:
  /// @param section  of config/predictive_stereo.yaml, which describes the parameters.
  /// @param check  throws std::invalid_argument for values that exclude each other.
  /// @param fixed  name prefixes of the parameters that cannot change.
  LiveParams(const ros::NodeHandle& node, Health& health, const Params& params,
             const std::string& section, std::function<void(const Params&)> check,
             const std::vector<std::string>& fixed = {})
      : params_(params),
        check_(std::move(check)),
        fixed_(fixed),
        table_(tableOf(params_)),
        server_(node, health, table_, tableOf(defaults_), section,
                [this](const ReconfigureServer::Assignments& values) { set(values); }) {}

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

  void set(const ReconfigureServer::Assignments& values) {
    Params trial = params_;
    ParamTable table = tableOf(trial);
    for (const auto& [name, text] : values) table.set(name, text);
    check_(trial);
    const std::lock_guard<std::mutex> lock(mutex_);
    params_ = trial;
    changed_ = trial;
  }

  Params params_, defaults_;
  const std::function<void(const Params&)> check_;
  const std::vector<std::string> fixed_;
  ParamTable table_;
  std::mutex mutex_;
  std::optional<Params> changed_;
  ReconfigureServer server_;  // last: uses the members above
};

}  // namespace predictive_stereo
