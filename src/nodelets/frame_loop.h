#pragma once

#include <ros/node_handle.h>
#include <std_srvs/Empty.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "nodelets/callbacks.h"
#include "nodelets/health.h"
#include "nodelets/latest_worker.h"
#include "nodelets/live_params.h"

namespace predictive_stereo {

/// Processing loop of a nodelet, in its own thread: it processes one frame at a time, always the
/// newest one. Changed parameters and ~reset take effect between two frames. The loop starts
/// asleep. When it wakes up, the processor has been reset. Frames run within Health::guard.
///
/// Processor has setParams(Params) and reset().
template <class Frame, class Processor, class Params>
class FrameLoop {
 public:
  struct Job {
    Frame frame;
    std::chrono::steady_clock::time_point arrival = std::chrono::steady_clock::now();

    double ageMs() const {
      const auto age = std::chrono::steady_clock::now() - arrival;
      return std::chrono::duration<double, std::milli>(age).count();
    }
  };
  struct Hooks {
    std::function<void(const Job&)> process;  ///< called in the loop's thread; may throw
    /// Throws std::invalid_argument for values that exclude each other.
    std::function<void(const Params&)> check;
    std::string section;  ///< of config/predictive_stereo.yaml, which describes the parameters
    std::vector<std::string> fixed;  ///< name prefixes of the parameters that cannot change
  };

  /// @param params  the current ones of the processor.
  FrameLoop(ros::NodeHandle& private_node, Health& health, Processor& processor,
            const Params& params, const Hooks& hooks)
      : health_(health),
        processor_(processor),
        hooks_(hooks),
        live_params_(private_node, health, params, hooks.section, hooks.check, hooks.fixed),
        reset_service_(advertiseService<std_srvs::EmptyRequest, std_srvs::EmptyResponse>(
            private_node, health, "reset",
            [this](std_srvs::EmptyRequest&, std_srvs::EmptyResponse&) {
              reset_requested_ = true;
              return true;
            })) {
    health_.setAsleep(true);
  }

  void push(Frame frame) { worker_.push(Job{std::move(frame)}); }

  /// While the loop is asleep, it drops all frames.
  void setAwake(bool awake) {
    if (!awake) forget_ = true;
    awake_ = awake;
    health_.setAsleep(!awake);
  }

  /// Number of frames that were replaced by a newer one before they were processed.
  uint64_t dropped() const { return worker_.dropped(); }

  /// After this has returned, no hook is called.
  void stop() { worker_.stop(); }

 private:
  void processJob(const Job& job) {
    const auto process = [&] {
      if (applyRequests()) hooks_.process(job);
    };
    health_.guard("input", process, Health::Severity::kBroken);
  }

  bool applyRequests() {
    if (const auto params = live_params_.takeChanged()) processor_.setParams(*params);
    const bool reset = reset_requested_.exchange(false);
    // The state from before a sleep is too old to be useful.
    if (forget_.exchange(false) || reset) processor_.reset();
    if (reset) health_.event("reset: the next frame is the first");
    return awake_;
  }

  Health& health_;
  Processor& processor_;
  const Hooks hooks_;
  LiveParams<Params> live_params_;
  std::atomic<bool> reset_requested_{false}, forget_{false}, awake_{false};
  ros::ServiceServer reset_service_;
  LatestWorker<Job> worker_{[this](Job& job) { processJob(job); }};  // last: uses the members above
};

}  // namespace predictive_stereo
