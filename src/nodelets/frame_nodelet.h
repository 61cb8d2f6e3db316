#pragma once

#include <nodelet/nodelet.h>
#include <std_srvs/Empty.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nodelets/callbacks.h"
#include "nodelets/health.h"
#include "nodelets/live_params.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/outputs.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/synced_topics.h"
#include "nodelets/tf_input.h"
#include "nodelets/threads.h"
#include "predictive_stereo/sequence_guard.h"

namespace predictive_stereo {

/// The skeleton of a nodelet that processes frames: parameters, health, demand, the input of the
/// frames, a thread that processes them. A nodelet says its topics, and what happens to a frame.
/// Its destructor calls shutDown() first.
///
/// Changed parameters and ~reset take effect between two frames. Awake, it receives its inputs;
/// asleep, because nobody wants its outputs, only tf; when it wakes up, the processor has been
/// reset.
/// @tparam Input  the topics of a frame, as StereoInput.
/// @tparam Processor  has setParams(Live), reset(), and an Output per frame.
/// @tparam Core  of the processor: refuses Live parameters that exclude each other.
template <class Params, class Input, class Processor, class Core, class Live>
class FrameNodelet : public nodelet::Nodelet {
 protected:
  using Frame = typename Input::Frame;
  struct Job {
    Frame frame;
    std::chrono::steady_clock::time_point arrival = std::chrono::steady_clock::now();
  };

  /// @param title  in the diagnostics. @param section  of config/predictive_stereo.yaml.
  /// @param live  the parameters that can change at run time. @param fixed  prefixes of those that
  ///   cannot.
  FrameNodelet(const std::string& title, const std::string& section, Live Params::*live,
               const std::vector<std::string>& fixed)
      : title_(title), section_(section), live_(live), fixed_(fixed) {}

  /// Makes inputs and outputs, the input of the frames by makeInput(). The nodelet is asleep.
  virtual void connect(ros::NodeHandle& node) = 0;
  virtual bool wanted() const { return outputs_->wanted(); }
  /// Inputs other than the frames. Before the frames, so that no motion is missed. Also called
  /// awake, whenever demand may have changed or something was thrown: then it does nothing for
  /// those that it has.
  virtual void subscribeInputs() = 0;
  /// Also called if connect() was not, or was not completed. After it has returned, no callback of
  /// an input runs.
  virtual void unsubscribeInputs() = 0;
  /// The stamps of the frames went back to this one; in the thread of the frames.
  virtual void goBackTo(ros::Time) {}
  /// Called in the thread of the frames, within Health::guard.
  virtual void process(const Job& job) = 0;
  virtual TfInput::Listener tfListener() { return {}; }
  /// So many of Input::topics() make a frame now, from the first one on.
  virtual size_t neededTopics() const { return Input::topics().size(); }

  void makeInput(ros::NodeHandle& node, const SyncParams& params) {
    input_ = std::make_unique<SyncedTopics>(
        node, *health_, params, Input::topics(), Input::cures(),
        [this](const SyncedTopics::Set& set) { worker_.push({Input::frame(set)}); });
  }

  /// After this has returned, nothing calls the nodelet.
  void shutDown() {
    arrivals_.stop();
    if (health_) health_->stop();
    {
      const std::lock_guard<std::mutex> lock(demand_mutex_);
      follows_demand_ = false;
    }
    if (health_) sleep();
    worker_.stop();
    tf_.reset();
  }

  /// A view of a mask of moving objects as input of the core; it shares the message's memory.
  /// Empty, and a problem, if the mask cannot be used: the frame goes on without it.
  /// @param mask  may be nullptr. @param left  an image of the sequence.
  cv::Mat1b usableMask(const sensor_msgs::ImageConstPtr& mask, const sensor_msgs::Image& left) {
    cv::Mat1b view;
    if (mask) health_->guard(kMaskTopic, [&] { view = movedMask(*mask, left); });
    return view;
  }

  /// Tells how a frame continues the sequence: one that starts anew is logged, two are a problem.
  /// @returns false for a frame that is ignored, which is a problem: nothing is done with it.
  bool tell(const SequenceGuard::Result& sequence) {
    if (sequence.verdict == SequenceGuard::Verdict::kBackward)
      health_->warning(sequence.reason);  // the pose jumps to the origin
    else if (sequence.startsAnew())
      health_->event(sequence.reason);
    health_->problem("order", sequence.isIgnored() ? sequence.reason : "");
    if (sequence.isIgnored()) return false;
    const bool again = std::exchange(starts_anew_, sequence.startsAnew()) && starts_anew_;
    health_->problem("past", again ? "frame after frame: " + sequence.reason : "");
    return true;
  }

  /// @param frames, images  what is dropped, and what finds no partner.
  void finish(const Job& job, const StageTimes& times, const std::string& frames,
              const std::string& images) {
    const auto dropped = static_cast<double>(worker_.dropped());
    const auto unmatched = static_cast<double>(input_->unmatched());
    health_->problem("speed",
                     dropped_.isHalf(dropped)
                         ? "more than half of the " + frames +
                               " are dropped, as this computer is too slow for them: lower "
                               "the camera's rate or resolution"
                         : "");
    health_->problem("partners", unmatched_.isHalf(unmatched)
                                     ? "more than half of the " + images +
                                           " find no partners: are the other topics, also "
                                           "camera_info, published as often and with their stamps?"
                                     : "");
    health_->figure("dropped " + frames, dropped, "%.0f");
    health_->figure("unmatched " + images, unmatched, "%.0f");
    const std::chrono::duration<double, std::milli> age =
        std::chrono::steady_clock::now() - job.arrival;
    health_->frame(job.frame.left->header.stamp, age.count(), times);
  }

  /// Wakes the nodelet or puts it to sleep, if the demand for its outputs has changed.
  void updateDemand() {
    const std::lock_guard<std::mutex> lock(demand_mutex_);
    if (!follows_demand_) return;
    const auto follow = [this] {
      if (wanted()) {
        awake_ = true;
        health_->setAsleep(false);
        subscribeInputs();
        input_->start(neededTopics());
      } else if (awake_) {
        sleep();
      }
    };
    health_->guard("subscriptions", follow, Health::Severity::kBroken);
  }

  Params params_;
  std::unique_ptr<Health> health_;
  Arrivals arrivals_;
  std::unique_ptr<Processor> processor_;
  std::unique_ptr<TfInput> tf_;
  std::optional<Outputs<typename Processor::Output>> outputs_;

 private:
  void onInit() override {
    health_ =
        std::make_unique<Health>(getNodeHandle(), getPrivateNodeHandle(), getName(), title_,
                                 [this] { return input_ ? input_->describeMissingInput() : ""; });
    health_->guard(
        "parameters", [this] { start(); }, Health::Severity::kBroken);
    health_->start();
  }

  void start() {
    ros::NodeHandle &node = getNodeHandle(), &private_node = getPrivateNodeHandle();
    ParamTable table(params_, private_node.getNamespace() + "/");
    for (const std::string& warning : setFromRosParams(private_node, table))
      health_->warning(warning);
    limitThreads(params_.threads);
    processor_ = std::make_unique<Processor>(params_);
    tf_ = std::make_unique<TfInput>(node, *health_, arrivals_, tfListener());
    health_->setAsleep(true);
    live_params_ = std::make_unique<LiveParams<Live>>(
        private_node, *health_, params_.*live_, section_, [](const Live& params) { Core{params}; },
        fixed_);
    reset_service_ = advertiseService<std_srvs::EmptyRequest, std_srvs::EmptyResponse>(
        private_node, *health_, "reset", [this](std_srvs::EmptyRequest&, std_srvs::EmptyResponse&) {
          reset_requested_ = true;
          return true;
        });
    outputs_.emplace(node, [this] { updateDemand(); });
    connect(node);
    {
      const std::lock_guard<std::mutex> lock(demand_mutex_);
      follows_demand_ = true;
    }
    updateDemand();
  }

  void sleep() {
    if (input_) input_->stop();
    unsubscribeInputs();
    forget_ = true;
    awake_ = false;
    health_->setAsleep(true);
  }

  void processNext(const Job& job) {
    // Not before the last frame of a pass has ended: it may wait for its motion.
    goBack(job.frame.left->header.stamp);
    if (const auto params = live_params_->takeChanged()) processor_->setParams(*params);
    const bool reset = reset_requested_.exchange(false);
    // The state from before a sleep is too old to be useful.
    if (forget_.exchange(false) || reset) processor_->reset();
    if (reset) health_->event("reset: the next frame is the first");
    if (awake_) process(job);
  }

  // A frame that is only late is ignored, and the messages that the next one needs are kept.
  void goBack(ros::Time stamp) {
    const double back_s = toSeconds(stampOf(last_stamp_) - stampOf(stamp));
    const bool is_another_pass = back_s > SequenceGuard::kLargestDelay_s;
    if (back_s < 0 || is_another_pass) last_stamp_ = stamp;
    if (!is_another_pass) return;
    tf_->goBackTo(stamp);
    goBackTo(stamp);
  }

  // What was lost before the last ten or so frames that were not.
  struct Losses {
    double total = 0, share = 0;
    bool isHalf(double now) {
      const double news = now - std::exchange(total, now);
      share += 0.1 * (news / (news + 1) - share);
      return share > 0.5;
    }
  };

  const std::string title_, section_;
  Live Params::*const live_;
  const std::vector<std::string> fixed_;
  std::unique_ptr<SyncedTopics> input_;
  ros::Time last_stamp_;
  bool starts_anew_ = false;  // the last frame
  Losses dropped_, unmatched_;
  std::atomic<bool> reset_requested_{false}, forget_{false}, awake_{false};
  std::unique_ptr<LiveParams<Live>> live_params_;
  ros::ServiceServer reset_service_;
  std::mutex demand_mutex_;
  bool follows_demand_ = false;
  FrameWorker<Job> worker_{[this](const Job& job) {
                             health_->guard(
                                 "input", [&] { processNext(job); }, Health::Severity::kBroken);
                           },
                           arrivals_};  // last: uses the members above
};

}  // namespace predictive_stereo
