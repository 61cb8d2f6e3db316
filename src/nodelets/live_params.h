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

#include "params/param_table.h"

namespace predictive_stereo {

/// dynamic_reconfigure's topics and service for the parameters of a table, described by it alone:
/// names, types, limits and choices are those of the structs, so that there is nothing to generate.
///
/// dynamic_reconfigure's own server would clamp what is out of range without a word. Here a request
/// with a value that is not allowed changes nothing, fails, and the log says why.
class ReconfigureServer {
 public:
  using Assignments = std::vector<std::pair<std::string, std::string>>;

  /// @param node  in whose namespace topics, service and ROS parameters are.
  /// @param values  the values that hold; must outlive this object.
  /// @param defaults  what the description calls the defaults, for the same names.
  /// @param set  sets all or nothing; throws std::invalid_argument for what is refused.
  ReconfigureServer(const ros::NodeHandle& node, const ParamTable& values,
                    const ParamTable& defaults, std::function<void(const Assignments&)> set);

 private:
  bool serve(dynamic_reconfigure::Reconfigure::Request& request,
             dynamic_reconfigure::Reconfigure::Response& response);
  void storeAsRosParams(const Assignments& changes) const;

  ros::NodeHandle node_;
  const ParamTable& values_;
  std::function<void(const Assignments&)> set_;
  ros::Publisher description_, updates_;
  ros::ServiceServer service_;  // last: it uses all of the above
};

/// A parameter struct that users change while its nodelet runs. Requests come in ROS's threads; the
/// nodelet takes what has changed when it is between two frames.
template <class Params>
class LiveParams {
 public:
  /// @param check  throws std::invalid_argument for values that are not allowed together.
  /// @param fixed  beginnings of the names of members that are not offered.
  LiveParams(const ros::NodeHandle& node, const Params& params,
             std::function<void(const Params&)> check, const std::vector<std::string>& fixed = {})
      : params_(params),
        trial_(params),
        check_(std::move(check)),
        table_(without(fixed, ParamTable(params_))),
        trial_table_(without(fixed, ParamTable(trial_))),
        server_(node, table_, without(fixed, ParamTable(defaults_)),
                [this](const ReconfigureServer::Assignments& values) { set(values); }) {}

  LiveParams(const LiveParams&) = delete;
  LiveParams& operator=(const LiveParams&) = delete;

  /// All parameters, where some were changed since the last call.
  std::optional<Params> takeChanged() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(changed_, std::nullopt);
  }

 private:
  static ParamTable without(const std::vector<std::string>& fixed, ParamTable table) {
    for (const std::string& beginning : fixed) table.remove(beginning);
    return table;
  }

  void set(const ReconfigureServer::Assignments& values) {
    trial_ = params_;
    for (const auto& [name, text] : values) trial_table_.set(name, text);
    check_(trial_);
    const std::lock_guard<std::mutex> lock(mutex_);
    params_ = trial_;
    changed_ = params_;
  }

  Params params_, trial_, defaults_;
  std::function<void(const Params&)> check_;
  ParamTable table_, trial_table_;
  std::mutex mutex_;
  std::optional<Params> changed_;
  ReconfigureServer server_;  // last: it uses all of the above
};

}  // namespace predictive_stereo
