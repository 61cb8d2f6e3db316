#include <functional>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <utility>

#include "nodelets/frame_nodelet.h"
#include "nodelets/message_input.h"
#include "nodelets/odometry_input.h"
#include "nodelets/output_topics.h"

namespace predictive_stereo {
namespace {

/// The clouds of Disparity, points2 and points2_static. They need the mask of moving objects of
/// their frame, which arrives a little later, or not at all.
///
/// Thread-safe.
class CloudOutput {
 public:
  /// @param changed  see Outputs.
  CloudOutput(const ros::NodeHandle& node, std::function<void()> changed, Health& health,
              const PointsParams& params)
      : health_(health), params_(params), outputs_(node, std::move(changed)) {
    visitCloudOutputs(outputs_);
  }

  bool wanted() const { return outputs_.wanted(); }
  /// The clouds of this frame may wait until its mask or the next frame arrives.
  void publish(const DisparityMessages& messages, const MessageInput<sensor_msgs::Image>& masks) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_) publishPending(nullptr);
    if (!wanted()) return;
    pending_ = CloudSource{messages.disparity, messages.left, messages.rig, params_, nullptr};
    const sensor_msgs::ImageConstPtr mask = masks.history().of(messages.left->header.stamp);
    if (mask || !masks.isPublished()) publishPending(mask);
  }

  /// Publishes the clouds that wait for this mask.
  void finish(const sensor_msgs::ImageConstPtr& mask) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pending_ && pending_->disparity->header.stamp == mask->header.stamp) publishPending(mask);
  }

  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    pending_.reset();
    missing_masks_ = 0;
  }

 private:
  void publishPending(const sensor_msgs::ImageConstPtr& mask) {
    health_.guard("points2", [&] {
      pending_->mask = mask;
      outputs_.publish(*pending_);
      if (outputs_.wanted("points2_static")) reportMissingMask(!mask);
    });
    pending_.reset();
  }

  void reportMissingMask(bool missing) {
    constexpr int kTellMissingMasks = 10;
    missing_masks_ = missing ? missing_masks_ + 1 : 0;
    if (!missing) health_.solved("points2_static");
    if (missing_masks_ == kTellMissingMasks)
      health_.problem("points2_static",
                      "points2_static is not published, as the mask of moving objects is missing: "
                      "run the MovingObjects nodelet (launch argument moving_objects:=true)");
  }

  Health& health_;
  const PointsParams params_;
  Outputs<CloudSource> outputs_;
  std::mutex mutex_;
  std::optional<CloudSource> pending_;
  int missing_masks_ = 0;  // consecutive clouds without a mask
};

/// Dense disparity with variance, predicted from the past by the camera's motion. Topics, services
/// and parameters: docs/nodes.md.
class DisparityNodelet
    : public FrameNodelet<DisparityNodeletParams, StereoInput, DisparityProcessor,
                          DisparityLoop::Stages, DisparityParams> {
 public:
  DisparityNodelet()
      : FrameNodelet("Disparity", "disparity", &DisparityNodeletParams::disparity,
                     {"use_moving_mask"}) {}
  ~DisparityNodelet() override { shutDown(); }

 private:
  void connect(ros::NodeHandle& node) override {
    for (const std::string& warning : unknownSections(node)) health_->warning(warning);
    reportSimdTarget();
    odometry_.emplace(node, *health_, arrivals_, *tf_, params_, "odometry/row_alignment");
    clouds_.emplace(
        node, [this] { updateDemand(); }, *health_, params_.points);
    masks_.emplace(node, *health_, arrivals_, kMasksKept,
                   [this](const sensor_msgs::ImageConstPtr& mask) { clouds_->finish(mask); });
    makeInput(node, params_.sync);
    for_detection_.emplace(node, [this] { updateDemand(); });
    visitDisparityOutputs(*outputs_, *for_detection_);
  }

  // If the inputs of MovingObjects are the only outputs with subscribers, this nodelet must not
  // keep MovingObjects awake: so it uses the passive topic.
  void subscribeInputs() override {
    odometry_->start();
    const bool needed = params_.disparity.use_moving_mask || clouds_->wanted();
    masks_->listenTo(!needed                                   ? ""
                     : outputs_->wanted() || clouds_->wanted() ? kMaskTopic
                                                               : kPassiveMaskTopic,
                     kMaskQueue);
  }
  void unsubscribeInputs() override {
    if (masks_) masks_->listenTo("");
    if (clouds_) clouds_->forget();
    if (odometry_) odometry_->stop();
  }

  void goBackTo(ros::Time stamp) override { odometry_->goBackTo(stamp); }

  bool wanted() const override {
    return outputs_->wanted() || clouds_->wanted() || for_detection_->wanted();
  }

  void process(const Job& job) override {
    const SequenceGuard::Result sequence = processor_->begin(job.frame);
    if (!tell(sequence)) return;
    if (sequence.verdict != SequenceGuard::Verdict::kContinues) masks_->history().clear();

    StageTimes waiting;
    sensor_msgs::ImageConstPtr mask;  // owns the memory of the view below
    DisparityProcessor::Sources sources;
    sources.motion = [&](const Past& past) {
      std::optional<CameraMotion> motion;
      Stopwatch watch;
      if (past.stamp()) motion = odometry_->motion(rosTime(*past.stamp()), job.frame.left->header);
      watch.lap("waiting for motion", waiting);
      return motion;
    };
    sources.moved = [&](Stamp before) {
      Stopwatch watch;
      mask = masks_->waitFor(rosTime(before), params_.transform_timeout);
      watch.lap("waiting for moving objects", waiting);
      return usableMask(mask, *job.frame.left);
    };
    sources.measured = [&](const auto& frame) { for_detection_->publish(frame); };
    if (const RowAlignmentConstPtr told = odometry_->columns().before(job.frame.left->header.stamp))
      sources.column_offset = columnOffset(*told);
    const DisparityMessages messages = processor_->process(sources);
    StageTimes times = processor_->times();
    times.insert(times.end(), waiting.begin(), waiting.end());
    outputs_->publish(messages);
    clouds_->publish(messages, *masks_);
    report(messages);
    finish(job, times, "pairs", "left images");
  }

  void reportSimdTarget() {
    health_->problem("SIMD target", processor_->slowTargetWarning());
    health_->figure("SIMD target", processor_->simdTarget());
  }

  void report(const DisparityMessages& messages) {
    constexpr double kMostContradicted = 0.3;
    const bool fits = messages.contradicted_fraction <= kMostContradicted;
    health_->problem(
        "prediction",
        fits ? ""
             : "many measured disparities contradict the prediction by the motion of odom_frame '" +
                   params_.odom_frame +
                   "': does this odometry jump? Use another one, or the EgoMotion nodelet. "
                   "Or are images dark or disturbed?");
    health_->figure("prediction contradicted [%]", 100 * messages.contradicted_fraction, "%.1f");
    reportSimdTarget();
    const stereo_msgs::DisparityImage& disparity = *messages.disparity;
    health_->figure("least depth [m]", disparity.f * disparity.T / disparity.max_disparity);
    health_->figure("predicted", messages.predicted ? "yes" : "no");
    health_->figure("mean search width [px]", messages.mean_search_width_px, "%.1f");
    health_->figure("disparity space searched [%]", 100 * messages.searched_fraction, "%.1f");
    health_->figure("largest row offset [px]", messages.row_alignment->largest_offset, "%.2f");
    health_->figure("row offset residual [px]", messages.row_alignment->residual, "%.2f");
    health_->figure("columns corrected by [px]", messages.row_alignment->column_correction, "%.2f");
  }

  std::optional<Outputs<MovingObjectsInput>> for_detection_;
  std::optional<OdometryInput> odometry_;
  std::optional<CloudOutput> clouds_;
  std::optional<MessageInput<sensor_msgs::Image>> masks_;
};

}  // namespace
}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::DisparityNodelet, nodelet::Nodelet)
