#include "nodelets/health.h"

#include <ros/console.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <iterator>
#include <set>
#include <utility>

namespace predictive_stereo {
namespace {

constexpr auto kRateWindow = std::chrono::seconds(5);
constexpr auto kSilence = std::chrono::seconds(3);  // without output, until it is reported
constexpr auto kShown = std::chrono::seconds(3);    // a problem that ended at once

// Causes of problems that do not come from frames: they last while a nodelet is asleep.
const std::set<std::string> kLasting = {"parameters", "subscriptions", "tf"};

std::string withoutNumbers(std::string text) {
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  text.erase(std::remove_if(text.begin(), text.end(), is_digit), text.end());
  return text;
}

}  // namespace

std::string whatWasThrown() {
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

Health::Health(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
               const std::string& name, const std::string& title,
               std::function<std::string()> silence)
    : name_(name), silence_(std::move(silence)), updater_(node, private_node, name) {
  updater_.setHardwareID("none");
  updater_.add(title, this, &Health::report);
  // Wall time, because a paused simulation or bag must be reported as well.
  timer_ = node.createWallTimer(
      ros::WallDuration(1.0),
      [this](const ros::WallTimerEvent&) { guard("timer", [this] { onTimer(); }); }, false, false);
}

void Health::failed(const std::string& source, Severity severity, const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++refused_[source];
  Problem& problem = tell(source, source + ": " + what, severity);
  problem.shown_until = Clock::now() + kShown;
  problem.works_again = false;
}

void Health::worked(const std::string& source) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = problems_.find(source);
  if (known != problems_.end()) known->second.works_again = true;
}

void Health::endOldProblems() {
  for (auto problem = problems_.begin(); problem != problems_.end();) {
    if (!problem->second.works_again || Clock::now() < problem->second.shown_until) {
      ++problem;
      continue;
    }
    ROS_INFO_STREAM(name_ << ": " << problem->first << ": problem solved");
    problem = problems_.erase(problem);
  }
}

void Health::problem(const std::string& cause, const std::string& text, Severity severity) {
  if (text.empty()) return solved(cause);
  const std::lock_guard<std::mutex> lock(mutex_);
  tell(cause, text, severity);
}

Health::Problem& Health::tell(const std::string& cause, const std::string& text,
                              Severity severity) {
  Problem& known = problems_[cause];
  const bool is_known = withoutNumbers(known.text) == withoutNumbers(text);
  known.severity = severity;
  known.text = text;
  if (is_known) return known;
  if (severity == Severity::kBroken)
    ROS_ERROR_STREAM(name_ << ": " << text);
  else
    ROS_WARN_STREAM(name_ << ": " << text);
  return known;
}

void Health::solved(const std::string& cause) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (problems_.erase(cause)) ROS_INFO_STREAM(name_ << ": " << cause << ": problem solved");
}

void Health::event(const std::string& text) { ROS_INFO_STREAM(name_ << ": " << text); }

void Health::frame(ros::Time stamp, double latency_ms, const StageTimes& times) {
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

void Health::figure(const std::string& name, double value, const char* format) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  figure(name, std::string(text));
}

void Health::figure(const std::string& name, const std::string& value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  figures_[name] = value;
}

void Health::setAsleep(bool asleep) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (asleep_ && !asleep) last_output_ = Clock::now();
  asleep_ = asleep;
  if (!asleep) return;
  for (auto problem = problems_.begin(); problem != problems_.end();)
    problem = kLasting.count(problem->first) ? std::next(problem) : problems_.erase(problem);
}

void Health::onTimer() {
  bool silent;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    silent = !asleep_ && Clock::now() - last_output_ > kSilence;
  }
  // Called without the lock, because it reads the state of the nodelet.
  std::string text = silent ? silence_() : "";
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (silent && text.empty() && problems_.empty())
      text = "input arrives but no output is published yet";
    if (!text.empty() && text != silence_text_) ROS_WARN_STREAM(name_ << ": no output: " << text);
    silence_text_ = text;
  }
  updater_.force_update();
}

void Health::report(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(mutex_);
  endOldProblems();
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

}  // namespace predictive_stereo
