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

#include "predictive_stereo/stage_times.h"

namespace predictive_stereo {

/// Text of the exception that is being handled, of whatever type: call it within a catch block.
std::string whatWasThrown();

/// Reports of a nodelet to its user: diagnostics at 1 Hz, each problem once in the log, and the
/// reason why there is no output. It is also the guard of all that ROS calls.
///
/// Thread-safe.
class Health {
 public:
  enum class Severity { kDegraded, kBroken };

  /// @param title  of the status in /diagnostics, after the nodelet's name.
  /// @param silence  text that names the missing input and the cure; may be empty. Called by the
  ///   timer while there is no output.
  Health(const ros::NodeHandle& node, const ros::NodeHandle& private_node, const std::string& name,
         const std::string& title, std::function<std::string()> silence);

  /// Starts to publish diagnostics and to call `silence`.
  void start() { timer_.start(); }

  /// After this has returned, `silence` is not called.
  void stop() { timer_.stop(); }

  /// Runs a callback. roscpp catches next to nothing, so an exception that leaves a callback ends
  /// the manager with all its nodelets. Here it ends, whatever it is: it is counted, and is a
  /// problem of `source` until this works again, but for three seconds at least, so that the
  /// diagnostics show it.
  /// @param source  name of the topic, service, ...
  /// @returns false if something was thrown.
  template <class Work>
  bool guard(const std::string& source, const Work& work, Severity severity = Severity::kDegraded) {
    try {
      work();
    } catch (...) {
      failed(source, severity, whatWasThrown());
      return false;
    }
    worked(source);
    return true;
  }

  /// Reports a problem. It is logged if `text` differs from the last text of this cause by more
  /// than its numbers. An empty text: it is solved.
  void problem(const std::string& cause, const std::string& text,
               Severity severity = Severity::kDegraded);
  /// Ends the problem of this cause.
  void solved(const std::string& cause);
  /// Logs one line.
  void event(const std::string& text);

  /// Counts a published frame.
  void frame(ros::Time stamp, double latency_ms, const StageTimes& times);
  /// Sets a value of the last frame in the diagnostics.
  void figure(const std::string& name, double value, const char* format = "%.3g");
  void figure(const std::string& name, const std::string& value);
  /// While a nodelet is asleep because it has no subscribers, missing output is not a fault, and
  /// the problems of earlier frames are forgotten.
  void setAsleep(bool asleep);

 private:
  using Clock = std::chrono::steady_clock;
  struct Problem {
    Severity severity;
    std::string text;
    Clock::time_point shown_until;
    bool works_again = false;
  };
  // Exponential mean over about the last ten frames.
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

  void failed(const std::string& source, Severity severity, const std::string& what);
  void worked(const std::string& source);
  Problem& tell(const std::string& cause, const std::string& text, Severity severity);
  void endOldProblems();
  void onTimer();
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  const std::string name_;
  std::function<std::string()> silence_;

  std::mutex mutex_;
  std::map<std::string, Problem> problems_;
  std::map<std::string, uint64_t> refused_;  // calls of each source that threw
  std::string silence_text_;                 // as last logged
  bool asleep_ = false;
  Clock::time_point last_output_ = Clock::now();
  std::deque<Clock::time_point> outputs_;  // of the last seconds
  uint64_t frames_ = 0;
  ros::Time last_stamp_;
  double stamp_gap_s_ = 0;
  Mean latency_ms_;
  std::map<std::string, Mean> stages_ms_;
  std::map<std::string, std::string> figures_;

  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;  // last: uses the members above
};

}  // namespace predictive_stereo
