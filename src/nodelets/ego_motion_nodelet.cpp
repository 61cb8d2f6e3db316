#include <nodelet/nodelet.h>
#include <sensor_msgs/Image.h>
#include <std_srvs/Empty.h>
#include <tf2_msgs/TFMessage.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>

#include "nodelets/ego_motion_processor.h"
#include "nodelets/health.h"
#include "nodelets/latest_worker.h"
#include "nodelets/live_params.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/ros_params.h"
#include "nodelets/stereo_input.h"
#include "nodelets/tf_input.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

/// Odometry of a stereo camera.
///
/// Subscribes: left/image_rect, left/camera_info, right/image_rect, right/camera_info;
///   moving_objects/mask where ~use_moving_mask is set.
/// Publishes: odometry, odometry/pose, /tf (odom_frame -> base_frame), /diagnostics.
/// Services: ~reset: the next frame is the origin; those of dynamic_reconfigure.
/// Parameters: EgoMotionNodeletParams.
class EgoMotionNodelet : public nodelet::Nodelet {
 public:
  ~EgoMotionNodelet() override {
    if (health_) health_->stop();
  }

 private:
  struct Job {
    StereoPair pair;
    std::chrono::steady_clock::time_point arrival;
  };

  void onInit() override {
    ros::NodeHandle& node = getNodeHandle();
    ros::NodeHandle& private_node = getPrivateNodeHandle();
    health_ = std::make_unique<Health>(node, private_node, getName(), "EgoMotion",
                                       [this] { return silence(); });
    try {
      ParamTable table(params_, rosParamPrefix(private_node));
      for (const std::string& warning : setFromRosParams(private_node, table))
        health_->event(warning);
      processor_ = std::make_unique<EgoMotionProcessor>(params_.processor);
    } catch (const std::exception& e) {
      health_->problem("parameters", Health::Severity::kBroken, e.what());
      return;
    }
    live_params_ = std::make_unique<LiveParams<EgoMotionParams>>(
        private_node, params_.processor.ego_motion,
        [](const EgoMotionParams& params) { EgoMotion{params}; });
    tf_ = std::make_unique<TfInput>(node);
    odometry_publisher_ = node.advertise<nav_msgs::Odometry>("odometry", 10);
    pose_publisher_ = node.advertise<geometry_msgs::PoseWithCovarianceStamped>("odometry/pose", 10);
    if (params_.publish_tf) tf_publisher_ = node.advertise<tf2_msgs::TFMessage>("/tf", 100);
    reset_service_ = private_node.advertiseService<std_srvs::EmptyRequest, std_srvs::EmptyResponse>(
        "reset", [this](std_srvs::EmptyRequest&, std_srvs::EmptyResponse&) {
          reset_requested_ = true;
          return true;
        });
    worker_ = std::make_unique<LatestWorker<Job>>([this](Job& job) { work(job); });
    if (params_.use_moving_mask)
      mask_subscriber_ = node.subscribe<sensor_msgs::Image>(
          "moving_objects/mask", 2, [this](const sensor_msgs::ImageConstPtr& mask) {
            const std::lock_guard<std::mutex> lock(mask_mutex_);
            mask_ = mask;
          });
    input_ = std::make_unique<StereoInput>(
        node, private_node, params_.sync,
        [this](const StereoPair& pair) {
          worker_->push({pair, std::chrono::steady_clock::now()});
        },
        [this](ros::Time stamp) { tf_->goBackTo(stamp); });
  }

  std::string silence() const { return input_ ? input_->silence() : ""; }

  void work(Job& job) {
    try {
      process(job);
      health_->solved("input");
    } catch (const std::exception& e) {
      health_->problem("input", Health::Severity::kBroken, e.what());
    }
  }

  void process(const Job& job) {
    if (const auto params = live_params_->takeChanged()) processor_->setParams(*params);
    if (reset_requested_.exchange(false)) {
      processor_->reset();
      health_->event("reset: the next frame is the origin");
    }
    const std::optional<Eigen::Isometry3d> T_base_cam = extrinsic(job.pair);
    if (!T_base_cam) return;

    StageTimes times;
    Stopwatch watch;
    sensor_msgs::ImageConstPtr mask_message;
    const EgoMotionProcessor::Output output =
        processor_->process(job.pair, *T_base_cam, takeMask(mask_message));
    watch.lap("ego-motion", times);
    if (output.sequence.verdict == SequenceGuard::Verdict::kBackward ||
        output.sequence.verdict == SequenceGuard::Verdict::kBroken)
      health_->event(output.sequence.reason);
    if (!output.messages) return;
    publish(*output.messages);
    report(job, output.estimate, times);
  }

  std::optional<Eigen::Isometry3d> extrinsic(const StereoPair& pair) {
    if (processor_->cameraIsBase(pair)) return Eigen::Isometry3d::Identity();
    const std::string base = processor_->baseFrame(pair);
    const std::string& camera = pair.left->header.frame_id;
    std::string error;
    const auto T_base_cam = waitFor(params_.transform_timeout, [&] {
      return lookUp(tf_->buffer, base, camera, pair.left->header.stamp, error);
    });
    if (T_base_cam)
      health_->solved("extrinsic");
    else
      health_->problem("extrinsic", Health::Severity::kBroken,
                       "no transform from base_frame '" + base + "' to the left camera '" + camera +
                           "': publish it (e.g. by tf2_ros static_transform_publisher), or set "
                           "base_frame to '" +
                           camera + "' to take the camera itself as the base");
    return T_base_cam;
  }

  cv::Mat1b takeMask(sensor_msgs::ImageConstPtr& message) {
    {
      const std::lock_guard<std::mutex> lock(mask_mutex_);
      message = mask_;
    }
    cv::Mat1b unused;
    if (!message || message->header.stamp != last_stamp_) return {};
    return greyImage(*message, "moving_objects/mask", unused);
  }

  void publish(const EgoMotionMessages& messages) {
    if (params_.publish_tf) {
      tf2_msgs::TFMessagePtr tf = boost::make_shared<tf2_msgs::TFMessage>();
      tf->transforms.push_back(messages.transform);
      tf_publisher_.publish(tf);
    }
    odometry_publisher_.publish(messages.odometry);
    pose_publisher_.publish(messages.pose);
  }

  void report(const Job& job, const EgoMotionEstimate& estimate, const StageTimes& times) {
    last_stamp_ = job.pair.left->header.stamp;
    if (estimate.status == EgoMotionStatus::kLost)
      health_->problem("tracking", Health::Severity::kDegraded,
                       "lost: too few features agree on a motion; the pose is held");
    else
      health_->solved("tracking");
    health_->figure("features", estimate.features, "%.0f");
    health_->figure("inliers", estimate.inliers, "%.0f");
    health_->figure("residual [px]", estimate.residual_px, "%.3f");
    health_->figure("largest row offset [px]", estimate.row_alignment.largest_offset_px, "%.2f");
    health_->figure("dropped pairs", static_cast<double>(worker_->dropped()), "%.0f");
    health_->figure("unmatched left images", static_cast<double>(input_->unmatched()), "%.0f");
    const std::chrono::duration<double, std::milli> latency =
        std::chrono::steady_clock::now() - job.arrival;
    health_->frame(job.pair.left->header.stamp, latency.count(), times);
  }

  EgoMotionNodeletParams params_;
  std::unique_ptr<Health> health_;
  std::unique_ptr<TfInput> tf_;
  std::unique_ptr<EgoMotionProcessor> processor_;
  ros::Publisher odometry_publisher_, pose_publisher_, tf_publisher_;
  ros::Subscriber mask_subscriber_;
  ros::ServiceServer reset_service_;
  std::atomic<bool> reset_requested_{false};
  std::unique_ptr<LiveParams<EgoMotionParams>> live_params_;
  std::mutex mask_mutex_;
  sensor_msgs::ImageConstPtr mask_;
  ros::Time last_stamp_;
  // Torn down first, in this order: no more pairs, then no more work.
  std::unique_ptr<LatestWorker<Job>> worker_;
  std::unique_ptr<StereoInput> input_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::EgoMotionNodelet, nodelet::Nodelet)
