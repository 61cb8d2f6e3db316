#pragma once

#include <nodelet/nodelet.h>

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "nodelets/arrivals.h"
#include "nodelets/frame_loop.h"
#include "nodelets/health.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/outputs.h"
#include "nodelets/ros_params.h"
#include "nodelets/tf_input.h"
#include "nodelets/thread_limit.h"
#include "predictive_stereo/sequence_guard.h"

namespace predictive_stereo {

/// The skeleton of a nodelet that processes frames: parameters, health, demand, the input of the
/// frames, the loop in a thread of its own. A nodelet says its topics, and what happens to a frame.
/// Its destructor calls shutDown() first.
///
/// Awake, it receives its inputs; asleep, because nobody wants its outputs, only tf.
/// @tparam Input  of the frames: StereoInput or DisparityInput.
/// @tparam Core  of the processor: refuses Live parameters that exclude each other.
template <class Params, class Input, class Processor, class Core, class Live>
class FrameNodelet : public nodelet::Nodelet {
 protected:
  using Frame = typename Input::Frame;
  using Loop = FrameLoop<Frame, Processor, Live>;
  using Job = typename Loop::Job;
  using ProcessorParams = decltype(Params::processor);

  /// @param title  in the diagnostics. @param section  of config/predictive_stereo.yaml.
  /// @param live  the parameters that can change at run time. @param fixed  prefixes of those that
  ///   cannot.
  FrameNodelet(const std::string& title, const std::string& section, Live ProcessorParams::*live,
               const std::vector<std::string>& fixed)
      : title_(title), section_(section), live_(live), fixed_(fixed) {}

  /// Makes inputs and outputs, the input of the frames by makeInput(). The nodelet is asleep.
  virtual void connect(ros::NodeHandle& node) = 0;
  virtual bool wanted() const { return outputs_.wanted(); }
  /// Inputs other than the frames. Before the frames, so that no motion is missed.
  virtual void subscribeInputs() = 0;
  /// Also called if connect() was not, or was not completed. After it has returned, no callback of
  /// an input runs.
  virtual void unsubscribeInputs() = 0;
  /// The stamps of the frames went back to this one.
  virtual void goBackTo(ros::Time) {}
  /// Called whenever demand may have changed.
  virtual void followDemand() {}
  /// Called in the loop's thread; may throw.
  virtual void process(const Job& job) = 0;
  virtual TfInput::Listener tfListener() { return {}; }

  /// @param params  see the constructor of Input.
  template <class InputParams>
  void makeInput(ros::NodeHandle& node, const InputParams& params) {
    input_ = std::make_unique<Input>(
        node, *health_, params, [this](const Frame& frame) { loop_->push(frame); },
        [this](ros::Time stamp) {
          tf_->goBackTo(stamp);
          goBackTo(stamp);
        });
  }

  /// After this has returned, nothing calls the nodelet.
  void shutDown() {
    arrivals_.stop();
    if (health_) health_->stop();
    demand_.stop();
    sleep();
    if (loop_) loop_->stop();
    tf_.reset();
  }

  /// Tells how a frame continues the sequence.
  /// @throws std::invalid_argument for a late frame: nothing is done with it.
  void tell(const SequenceGuard::Result& sequence) {
    if (sequence.startsAnew()) health_->event(sequence.reason);
    if (sequence.verdict == SequenceGuard::Verdict::kLate)
      throw std::invalid_argument(sequence.reason);
  }

  /// @param frames, images  what is dropped, and what finds no partner.
  void finish(const Job& job, const StageTimes& times, const std::string& frames,
              const std::string& images) {
    health_->figure("dropped " + frames, static_cast<double>(loop_->dropped()), "%.0f");
    health_->figure("unmatched " + images, static_cast<double>(input_->unmatched()), "%.0f");
    health_->frame(job.frame.left->header.stamp, job.ageMs(), times);
  }

  void updateDemand() { demand_.update(); }

  Params params_;
  std::unique_ptr<Health> health_;
  Arrivals arrivals_;
  std::unique_ptr<Processor> processor_;
  std::unique_ptr<TfInput> tf_;
  Outputs outputs_{[this] { updateDemand(); }};
  std::unique_ptr<Loop> loop_;

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
    ParamTable table(params_, rosParamPrefix(private_node));
    for (const std::string& warning : setFromRosParams(private_node, table))
      health_->event(warning);
    limitThreads(params_.threads);
    processor_ = std::make_unique<Processor>(params_.processor);
    tf_ = std::make_unique<TfInput>(node, *health_, arrivals_, tfListener());
    loop_ = std::make_unique<Loop>(
        private_node, *health_, *processor_, params_.processor.*live_,
        typename Loop::Hooks{[this](const Job& job) { process(job); },
                             [](const Live& params) { Core{params}; }, section_, fixed_});
    connect(node);
    demand_.start();
  }

  void wake() {
    loop_->setAwake(true);
    subscribeInputs();
    input_->start();
  }

  void sleep() {
    if (input_) input_->stop();
    unsubscribeInputs();
    if (loop_) loop_->setAwake(false);
  }

  std::unique_ptr<Input> input_;
  const std::string title_, section_;
  Live ProcessorParams::*const live_;
  const std::vector<std::string> fixed_;
  Demand demand_{{[this] { return wanted(); }, [this] { wake(); }, [this] { sleep(); },
                  [this] { followDemand(); },
                  [this](const std::function<void()>& work) {
                    health_->guard("subscriptions", work, Health::Severity::kBroken);
                  }}};
};

}  // namespace predictive_stereo
