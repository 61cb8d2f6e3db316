#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/console.h>
#include <ros/node_handle.h>
#include <ros/wall_timer.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <utility>

#include "predictive_stereo/stage_times.h"

namespace predictive_stereo {

/// Text of the exception that is being handled, of whatever type: call it within a catch block.
inline std::string whatWasThrown() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (const XmlRpc::XmlRpcException& error) {  // is no std::exception
    return error.getMessage();
  } catch (...) {
    return "an exception of unknown type";
  }
}

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
         const std::string& title, std::function<std::string()> silence)
      : name_(name), silence_(std::move(silence)), updater_(node, private_node, name) {
    updater_.setHardwareID("none");
    updater_.add(title, this, &Health::report);
    // Wall time, because a paused simulation or bag must be reported as well.
    timer_ = node.createWallTimer(
        ros::WallDuration(1.0),
        [this](const ros::WallTimerEvent&) { guard("timer", [this] { onTimer(); }); }, false,
        false);
  }

  /// Starts to publish diagnostics and to call `silence`.
  void start() { timer_.start(); }

  /// After this has returned, `silence` is not called.
  void stop() { timer_.stop(); }

  /// Runs a callback. roscpp catches next to nothing, so an exception that leaves a callback ends
  /// the manager with all its nodelets. Here it ends, whatever it is: it is counted, and is a
  /// problem of `source` until this works again.
  /// @param source  name of the topic, service, ...
  /// @returns false if something was thrown.
  template <class Work>
  bool guard(const std::string& source, const Work& work, Severity severity = Severity::kDegraded) {
    try {
      work();
    } catch (...) {
      refuse(source, severity, whatWasThrown());
      return false;
    }
    solved(source);
    return true;
  }

  /// Reports a problem. It is logged if `text` differs from the last text of this cause by more
  /// than its numbers. An empty text: it is solved. It stays for three seconds at least, so that
  /// the diagnostics show it, and that one which comes and goes is logged once.
  void problem(const std::string& cause, const std::string& text,
               Severity severity = Severity::kDegraded) {
    if (text.empty()) return solved(cause);
    const std::lock_guard<std::mutex> lock(mutex_);
    tell(cause, severity, text);
  }

  /// Ends the problem of this cause, if there is one.
  void solved(const std::string& cause) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto known = problems_.find(cause);
    if (known == problems_.end()) return;
    known->second.is_solved = true;
    endSolved();
  }
  /// Logs one line.
  void event(const std::string& text) { ROS_INFO_STREAM(name_ << ": " << text); }
  void warning(const std::string& text) { ROS_WARN_STREAM(name_ << ": " << text); }
  /// Counts a published frame.
  void frame(ros::Time stamp, double latency_ms, const StageTimes& times) {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_output_ = Clock::now();
    outputs_.push_back(last_output_);
    if (!last_stamp_.isZero()) stamp_gap_s_ = (stamp - last_stamp_).toSec();
    last_stamp_ = stamp;
    ++frames_;
    latency_ms_.add(latency_ms);
    for (const StageTime& time : times) stages_ms_[time.name].add(time.ms);
    if (!silence_text_.empty()) {
      silence_text_.clear();
      ROS_INFO_STREAM(name_ << ": output is published again");
    }
  }

  /// Sets a value of the last frame in the diagnostics.
  void figure(const std::string& name, double value, const char* format = "%.3g") {
    figure(name, cv::format(format, value));
  }

  void figure(const std::string& name, const std::string& value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    figures_[name] = value;
  }

  /// While a nodelet is asleep because it has no subscribers, missing output is not a fault, and
  /// the problems of earlier frames are forgotten.
  void setAsleep(bool asleep) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (asleep_ && !asleep) last_output_ = Clock::now();
    asleep_ = asleep;
    if (!asleep) return;
    // Problems of these causes do not come from frames.
    const std::set<std::string> lasting = {"parameters", "subscriptions", "tf"};
    for (auto problem = problems_.begin(); problem != problems_.end();)
      problem = lasting.count(problem->first) ? std::next(problem) : problems_.erase(problem);
  }

 private:
  using Clock = std::chrono::steady_clock;

  static constexpr auto kRateWindow = std::chrono::seconds(5);
  static constexpr auto kSilence = std::chrono::seconds(3);  // until missing output is reported
  static constexpr auto kShown = std::chrono::seconds(3);    // a problem, at least

  struct Problem {
    Severity severity = Severity::kDegraded;
    std::string text;
    Clock::time_point shown_until;
    bool is_solved = false;
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

  void refuse(const std::string& source, Severity severity, const std::string& what) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++refused_[source];
    tell(source, severity, source + ": " + what);
  }

  void tell(const std::string& cause, Severity severity, const std::string& text) {
    const Problem problem{severity, text, Clock::now() + kShown};
    const std::string before = std::exchange(problems_[cause], problem).text;
    if (withoutNumbers(before) == withoutNumbers(text)) return;
    if (severity == Severity::kBroken)
      ROS_ERROR_STREAM(name_ << ": " << text);
    else
      ROS_WARN_STREAM(name_ << ": " << text);
  }

  static std::string withoutNumbers(std::string text) {
    const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
    text.erase(std::remove_if(text.begin(), text.end(), is_digit), text.end());
    return text;
  }

  void endSolved() {
    for (auto problem = problems_.begin(); problem != problems_.end();) {
      if (!problem->second.is_solved || Clock::now() < problem->second.shown_until) {
        ++problem;
        continue;
      }
      ROS_INFO_STREAM(name_ << ": " << problem->first << ": problem solved");
      problem = problems_.erase(problem);
    }
  }

  void onTimer() {
    bool silent;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      silent = !asleep_ && Clock::now() - last_output_ > kSilence;
    }
    // Called without the lock, because it reads the state of the nodelet.
    std::string text = silent ? silence_() : "";
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!text.empty())
        last_missing_ = Clock::now();
      else if (silent && Clock::now() - last_missing_ <= kSilence)
        text = silence_text_;  // the first input is being processed
      else if (silent && problems_.empty())
        text = "input arrives but no output is published yet";
      if (!text.empty() && text != silence_text_) ROS_WARN_STREAM(name_ << ": no output: " << text);
      silence_text_ = text;
    }
    updater_.force_update();
  }

  void report(diagnostic_updater::DiagnosticStatusWrapper& status) {
    using diagnostic_msgs::DiagnosticStatus;
    const std::lock_guard<std::mutex> lock(mutex_);
    endSolved();
    const auto now = Clock::now();
    while (!outputs_.empty() && now - outputs_.front() > kRateWindow) outputs_.pop_front();
    const double rate_hz =
        outputs_.size() > 1
            ? static_cast<double>(outputs_.size() - 1) /
                  std::max(1e-3, std::chrono::duration<double>(now - outputs_.front()).count())
            : 0.0;

    if (asleep_)
      status.summary(DiagnosticStatus::OK, "asleep: nobody subscribes to the outputs");
    else
      status.summaryf(DiagnosticStatus::OK, "%.1f Hz", rate_hz);
    for (const auto& [cause, problem] : problems_)
      status.mergeSummary(
          problem.severity == Severity::kBroken ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN,
          problem.text);
    if (!silence_text_.empty())
      status.mergeSummary(DiagnosticStatus::ERROR, "no output: " + silence_text_);

    status.addf("rate [Hz]", "%.2f", rate_hz);
    status.add("frames", frames_);
    status.addf("stamp gap [s]", "%.4f", stamp_gap_s_);
    status.addf("latency [ms]", "%.1f", latency_ms_.value());
    for (const auto& [stage, ms] : stages_ms_) status.addf(stage + " [ms]", "%.2f", ms.value());
    for (const auto& [name, value] : figures_) status.add(name, value);
    for (const auto& [source, count] : refused_) status.add("refused: " + source, count);
  }

  const std::string name_;
  std::function<std::string()> silence_;

  std::mutex mutex_;
  std::map<std::string, Problem> problems_;
  std::map<std::string, uint64_t> refused_;  // calls of each source that threw
  std::string silence_text_;                 // as last logged
  bool asleep_ = false;
  Clock::time_point last_output_ = Clock::now();
  Clock::time_point last_missing_;         // when silence_ last named missing input
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
