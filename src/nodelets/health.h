#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <ros/wall_timer.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "predictive_stereo/stage_times.h"

namespace predictive_stereo {

/// Reports of a nodelet to its user: diagnostics at 1 Hz, each problem once per cause
/// in the log, and
/// why nothing comes out while nothing does.
///
/// Thread-safe.
class Health {
 public:
  enum class Severity { kDegraded, kBroken };

  /// @param title  of the status in /diagnostics, after the nodelet's name.
  /// @param silence  says which input is missing, and the cure; called while nothing comes
  ///   out; may return an empty text. Called from the timer.
  Health(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const std::string& name,
         const std::string& title, std::function<std::string()> silence);

  /// From now on diagnostics are published, and `silence` is asked.
  void start() { timer_.start(); }

  /// No more calls of `silence` once this has returned.
  void stop() { timer_.stop(); }

  /// Something is wrong. Logged where `text` differs from what this cause last said.
  void problem(const std::string& cause, Severity severity, const std::string& text);
  /// This cause is gone.
  void solved(const std::string& cause);
  /// Something worth one line in the log.
  void event(const std::string& text);

  /// A frame was published.
  void frame(ros::Time stamp, double latency_ms, const StageTimes& times);
  /// A figure of the last frame.
  void figure(const std::string& name, double value, const char* format = "%.3g");
  void figure(const std::string& name, const std::string& value);
  /// Without subscribers it is no fault that nothing comes out.
  void setAsleep(bool asleep);

 private:
  using Clock = std::chrono::steady_clock;
  struct Problem {
    Severity severity;
    std::string text;
  };
  // Over the last ten frames or so.
  class Mean {
   public:
    void add(double value) {
      weight_ += 0.1 * (1 - weight_);
      value_ += 0.1 / weight_ * (value - value_);
    }
    double value() const { return value_; }

   private:
    double value_ = 0, weight_ = 0;
  };

  void tick();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  const std::string name_;
  std::function<std::string()> silence_;

  std::mutex mutex_;
  std::map<std::string, Problem> problems_;
  std::string silence_text_;  // as last logged
  bool asleep_ = false;
  Clock::time_point last_output_ = Clock::now();
  std::deque<Clock::time_point> outputs_;  // of the last seconds
  uint64_t frames_ = 0;
  ros::Time last_stamp_;
  double stamp_gap_s_ = 0;
  Mean latency_ms_;
  std::vector<std::pair<std::string, Mean>> stages_;
  std::vector<std::pair<std::string, std::string>> figures_;

  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;  // last: it uses all of the above
};

}  // namespace predictive_stereo
