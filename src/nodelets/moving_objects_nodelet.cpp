#include <image_transport/image_transport.h>
#include <nodelet/nodelet.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <vector>
#ifdef PREDICTIVE_STEREO_HAS_VISION_MSGS
#include <vision_msgs/Detection3DArray.h>
#endif

#include "nodelets/detections3d.h"
#include "nodelets/frame_loop.h"
#include "nodelets/health.h"
#include "nodelets/image_subscriber.h"
#include "nodelets/mask_input.h"
#include "nodelets/message_history.h"
#include "nodelets/moving_objects_processor.h"
#include "nodelets/moving_objects_views.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/odometry_input.h"
#include "nodelets/outputs.h"
#include "nodelets/ros_params.h"
#include "nodelets/stamp_matcher.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/tf_input.h"
#include "nodelets/thread_limit.h"
#include "nodelets/topic_state.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

// The largest standard deviation of the camera's motion since the previous frame. What is not
// positive definite, as of an odometry in the plane, the detector takes for not told.
std::string describeSigma(const Matrix6d& covariance) {
  if (Eigen::LLT<Matrix6d>(covariance).info() != Eigen::Success)
    return "odometry does not tell it: 15 mm are taken";
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f mm",
                1e3 * std::sqrt(covariance.diagonal().head<3>().maxCoeff()));
  return text;
}

}  // namespace

/// Moving objects from measured and predicted disparity.
///
/// Subscribes: measured_disparity, measured_variance, predicted_disparity, predicted_variance,
///   left/image_rect, left/camera_info; /tf (the camera's pose in odom_frame); if they are
///   published, odometry (the covariance of the motion) and row_alignment (the column offset of the
///   disparities).
/// Publishes: moving_objects, moving_objects/mask, and on demand moving_objects/residual,
///   moving_objects/markers, moving_objects/image, moving_objects/detections3d (if vision_msgs was
///   installed at build time); /diagnostics. Without subscribers of its outputs it subscribes only
///   to /tf. Also moving_objects/passive_mask, see MaskInput.
/// Services: ~reset, and those of dynamic_reconfigure.
/// Parameters: MovingObjectsNodeletParams.
class MovingObjectsNodelet : public nodelet::Nodelet {
 public:
  ~MovingObjectsNodelet() override {
    arrivals_.stop();
    if (health_) health_->stop();
    demand_.stop();
    sleep();
    if (loop_) loop_->stop();
  }

 private:
  using Loop = FrameLoop<MovingObjectsInput, MovingObjectsProcessor, DetectionParams>;
  // The first slot has the messages that need partners. Left images do not, because not every one
  // has a disparity.
  enum Slot { kMeasured, kMeasuredVariance, kPredicted, kPredictedVariance, kLeft, kLeftInfo };
  static constexpr size_t kTopics = 6;

  void onInit() override {
    health_ = std::make_unique<Health>(getNodeHandle(), getPrivateNodeHandle(), getName(),
                                       "MovingObjects", [this] { return describeMissingInput(); });
    health_->guard(
        "parameters", [this] { start(getNodeHandle(), getPrivateNodeHandle()); },
        Health::Severity::kBroken);
    health_->start();
  }

  void start(ros::NodeHandle& node, ros::NodeHandle& private_node) {
    ParamTable table(params_, rosParamPrefix(private_node));
    for (const std::string& warning : setFromRosParams(private_node, table))
      health_->event(warning);
    limitThreads(params_.threads);
    processor_ = std::make_unique<MovingObjectsProcessor>(params_.processor);
    tf_ = std::make_unique<TfInput>(node, *health_, arrivals_);
    odometry_ = std::make_unique<OdometryInput>(node, *health_, arrivals_);
    loop_ = std::make_unique<Loop>(
        private_node, *health_, *processor_, params_.processor.detection,
        Loop::Hooks{[this](const Loop::Job& job) { process(job); },
                    [](const DetectionParams& params) { MovingObjectDetector{params}; },
                    "moving_objects",
                    {"range/"}});
    SyncParams exact;
    exact.approximate_sync = false;  // every input has the left image's stamp
    exact.queue_size = params_.queue_size;
    names_ = {"measured_disparity", "measured_variance", "predicted_disparity",
              "predicted_variance", "left/image_rect",   "left/camera_info"};
    std::vector<std::string> topics;
    for (const char* name : names_) topics.push_back(node.resolveName(name));
    matcher_ = std::make_unique<StampMatcher>(topics, exact);
    objects_ = outputs_.advertise<MovingObjectArray>(node, "moving_objects", 10);
    mask_ = outputs_.advertiseImage(node, MaskInput::kTopic, 5);
    residual_ = outputs_.advertise<sensor_msgs::Image>(node, "moving_objects/residual", 5);
    markers_ =
        outputs_.advertise<visualization_msgs::MarkerArray>(node, "moving_objects/markers", 5);
    image_ = outputs_.advertiseImage(node, "moving_objects/image", 5);
#ifdef PREDICTIVE_STEREO_HAS_VISION_MSGS
    detections_ =
        outputs_.advertise<vision_msgs::Detection3DArray>(node, "moving_objects/detections3d", 10);
#endif
    passive_mask_ = node.advertise<sensor_msgs::Image>(MaskInput::kPassiveTopic, 5);
    demand_.start();
  }

  void wake() {
    ros::NodeHandle& node = getNodeHandle();
    loop_->setAwake(true);
    odometry_->start();
    Subscribers subscribers;
    const uint32_t queue = std::max(kRoscppQueue, static_cast<uint32_t>(params_.queue_size));
    const auto subscribeTo = [&](Slot slot, auto type) {
      using Message = typename decltype(type)::element_type;
      subscribers.others[slot] = subscribe<Message>(
          node, *health_, names_[slot], queue,
          [this, slot](const boost::shared_ptr<const Message>& message) { add(slot, message); },
          slot == kLeftInfo ? ZeroStamp::kLegal : ZeroStamp::kRefused);
    };
    subscribeTo(kLeftInfo, boost::shared_ptr<sensor_msgs::CameraInfo>());
    subscribeTo(kMeasured, boost::shared_ptr<stereo_msgs::DisparityImage>());
    subscribeTo(kMeasuredVariance, boost::shared_ptr<sensor_msgs::Image>());
    subscribeTo(kPredicted, boost::shared_ptr<stereo_msgs::DisparityImage>());
    subscribeTo(kPredictedVariance, boost::shared_ptr<sensor_msgs::Image>());
    subscribers.columns = subscribe<RowAlignment>(node, *health_, "row_alignment", queue,
                                                  [this](const RowAlignmentConstPtr& columns) {
                                                    requireRowAlignment(*columns);
                                                    columns_.add(columns);
                                                  });
    subscribers.left =
        ImageSubscriber(node, *health_, names_[kLeft], queue, params_.image_transport,
                        [this](const sensor_msgs::ImageConstPtr& image) { add(kLeft, image); });
    const std::lock_guard<std::mutex> lock(mutex_);
    subscribers_ = subscribers;
  }

  void guardSubscriptions(const std::function<void()>& work) {
    health_->guard("subscriptions", work, Health::Severity::kBroken);
  }

  void sleep() {
    if (!loop_) return;
    Subscribers subscribers;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::swap(subscribers, subscribers_);
    }
    // Without the lock: shutdown() waits for callbacks, and these take the lock.
    subscribers.left.shutdown();
    subscribers.columns.shutdown();
    for (ros::Subscriber& subscriber : subscribers.others) subscriber.shutdown();
    odometry_->stop();
    loop_->setAwake(false);
    columns_.clear();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (matcher_) matcher_->clear();
  }

  template <class Message>
  void add(Slot slot, const boost::shared_ptr<const Message>& message) {
    const ros::Time stamp = message->header.stamp;
    const std::lock_guard<std::mutex> lock(mutex_);
    last_received_[slot] = std::chrono::steady_clock::now();
    if (slot == kLeft) {
      if (stamp < last_left_) {
        tf_->goBackTo(stamp);
        odometry_->goBackTo(stamp);
        columns_.goBackTo(stamp);
      }
      last_left_ = stamp;
    }
    for (const StampMatcher::Set& set :
         matcher_->add(slot, stamp, message, slot == kLeftInfo && stamp.isZero())) {
      using boost::static_pointer_cast;
      MovingObjectsInput input;
      input.left = static_pointer_cast<const sensor_msgs::Image>(set[kLeft]);
      input.left_info = static_pointer_cast<const sensor_msgs::CameraInfo>(set[kLeftInfo]);
      input.measured_disparity =
          static_pointer_cast<const stereo_msgs::DisparityImage>(set[kMeasured]);
      input.predicted_disparity =
          static_pointer_cast<const stereo_msgs::DisparityImage>(set[kPredicted]);
      input.measured_variance =
          static_pointer_cast<const sensor_msgs::Image>(set[kMeasuredVariance]);
      input.predicted_variance =
          static_pointer_cast<const sensor_msgs::Image>(set[kPredictedVariance]);
      const ros::Time of_set = input.left->header.stamp;
      const RowAlignmentConstPtr columns = columns_.at(of_set);
      if (columns && columns->header.stamp == of_set) input.row_alignment = columns;
      loop_->push(input);
    }
  }

  std::string describeMissingInput() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!subscribers_.left) return "";
    if (const std::string error = subscribers_.left.error(); !error.empty())
      return subscribers_.left.getTopic() + ": " + error;
    std::vector<TopicState> topics;
    for (size_t slot = 0; slot < kTopics; ++slot)
      topics.push_back(
          {slot == kLeft ? subscribers_.left.getTopic() : subscribers_.others[slot].getTopic(),
           slot == kLeft ? subscribers_.left.getNumPublishers()
                         : subscribers_.others[slot].getNumPublishers(),
           last_received_[slot]});
    const std::string unpublished = unpublishedOf(topics), silent = silentOf(topics);
    if (!unpublished.empty())
      return "nobody publishes " + unpublished +
             ": run the Disparity nodelet in the same namespace (launch argument "
             "camera:=<namespace>), or remap";
    // Without images there are no disparities either, so this is the cause.
    if (topics[kLeft].isSilent())
      return "no messages arrive on " + topics[kLeft].name +
             " although it is advertised: is the camera running, or is the bag paused?";
    if (!silent.empty())
      return "no messages arrive on " + silent +
             " although it is advertised: see the diagnostics of the Disparity nodelet";
    return matcher_->describeMismatch();
  }

  size_t unmatched() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return matcher_->unmatched();
  }

  void process(const Loop::Job& job) {
    const std_msgs::Header& header = job.frame.left->header;
    Stopwatch watch;
    StageTimes times;
    const std::optional<CameraPose> pose = cameraPoseOf(header);
    watch.lap("waiting for the pose", times);
    const MovingObjectsProcessor::Output output = processor_->process(job.frame, pose);
    watch.lap("detection", times);
    if (output.sequence.startsAnew()) health_->event(output.sequence.reason);
    if (!output.messages) return;
    objects_.publish(output.messages->objects);
#ifdef PREDICTIVE_STEREO_HAS_VISION_MSGS
    if (detections_.getNumSubscribers() > 0)
      detections_.publish(detections3d<vision_msgs::Detection3DArray>(*output.messages->objects));
#endif
    mask_.publish(output.messages->mask);
    passive_mask_.publish(output.messages->mask);
    if (residual_.getNumSubscribers() > 0)
      residual_.publish(residualImage(*job.frame.measured_disparity, *job.frame.measured_variance,
                                      *job.frame.predicted_disparity,
                                      *job.frame.predicted_variance));
    if (markers_.getNumSubscribers() > 0)
      markers_.publish(markers(*output.messages->objects, pose));
    if (image_.getNumSubscribers() > 0)
      image_.publish(overlay(*job.frame.left, *output.messages->objects, *output.messages->mask));

    health_->figure("objects", static_cast<double>(output.messages->objects->objects.size()),
                    "%.0f");
    health_->figure("dropped frames", static_cast<double>(loop_->dropped()), "%.0f");
    health_->figure("unmatched frames", static_cast<double>(unmatched()), "%.0f");
    health_->frame(header.stamp, job.ageMs(), times);
  }

  std::optional<CameraPose> cameraPoseOf(const std_msgs::Header& now) {
    const PoseAnswer answer =
        odometry_->waitFor(params_.transform_timeout, [&](const OdometryHistory* odometry) {
          return cameraPose(tf_->buffer, odometry, now.frame_id, processor_->lastWithPose(),
                            now.stamp, params_.odom_frame);
        });
    if (!answer.pose) {
      health_->problem("pose", Health::Severity::kDegraded, describeMissingPose(now, answer));
      return std::nullopt;
    }
    health_->solved("pose");
    health_->figure("sigma of the motion", describeSigma(answer.pose->motion_covariance));
    return answer.pose;
  }

  std::string describeMissingPose(const std_msgs::Header& now, const PoseAnswer& answer) const {
    if (now.frame_id.empty()) return std::string(kNoFrame) + ": no velocities";
    if (answer.complete) return answer.reason + ": no velocities";
    return "tf has no pose of '" + now.frame_id + "' in odom_frame '" + params_.odom_frame +
           "' at the image's stamp: no velocities. Run the EgoMotion nodelet with publish_tf, or "
           "set odom_frame to the fixed frame of your odometry";
  }

  struct Subscribers {
    std::array<ros::Subscriber, kTopics> others;
    ros::Subscriber columns;
    ImageSubscriber left;
  };

  MovingObjectsNodeletParams params_;
  Demand demand_{{[this] { return outputs_.wanted(); },
                  [this] { wake(); },
                  [this] { sleep(); },
                  {},
                  [this](const auto& work) { guardSubscriptions(work); }}};
  std::unique_ptr<Health> health_;
  Arrivals arrivals_;
  std::unique_ptr<TfInput> tf_;
  std::unique_ptr<OdometryInput> odometry_;
  std::unique_ptr<MovingObjectsProcessor> processor_;
  Outputs outputs_{[this] { demand_.update(); }};
  ros::Publisher objects_, detections_, residual_, markers_, passive_mask_;
  image_transport::Publisher mask_, image_;

  mutable std::mutex mutex_;
  std::array<const char*, kTopics> names_{};
  std::unique_ptr<StampMatcher> matcher_;
  std::array<std::chrono::steady_clock::time_point, kTopics> last_received_{};
  ros::Time last_left_;
  MessageHistory<RowAlignment> columns_;

  std::unique_ptr<Loop> loop_;
  Subscribers subscribers_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::MovingObjectsNodelet, nodelet::Nodelet)
