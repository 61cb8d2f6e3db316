#include <nodelet/nodelet.h>
#include <ros/master.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "nodelets/ego_motion_processor.h"
#include "nodelets/frame_loop.h"
#include "nodelets/health.h"
#include "nodelets/imu_rotation.h"
#include "nodelets/mask_input.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/outputs.h"
#include "nodelets/ros_params.h"
#include "nodelets/stereo_input.h"
#include "nodelets/tf_input.h"
#include "nodelets/tf_rivals.h"
#include "nodelets/thread_limit.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {

/// Odometry of a stereo camera.
///
/// Subscribes: left/image_rect, left/camera_info, right/image_rect, right/camera_info; imu if
///   ~use_imu is set; moving_objects/mask if ~use_moving_mask is set (moving_objects/passive_mask
///   if this nodelet can sleep).
/// Publishes: odometry, odometry/pose, odometry/row_alignment, /tf (odom_frame -> base_frame),
///   /diagnostics. If ~publish_tf is false or ~lazy is true, it subscribes only to /tf while the
///   first three have no subscribers. It does not publish tf if another node already publishes
///   base_frame there.
/// Services: ~reset (the next frame is the origin), and those of dynamic_reconfigure.
/// Parameters: EgoMotionNodeletParams.
class EgoMotionNodelet : public nodelet::Nodelet {
 public:
  ~EgoMotionNodelet() override {
    arrivals_.stop();
    if (health_) health_->stop();
    demand_.stop();
    sleep();
    if (loop_) loop_->stop();
  }

 private:
  using Loop = FrameLoop<StereoPair, EgoMotionProcessor, EgoMotionParams>;

  void onInit() override {
    health_ = std::make_unique<Health>(getNodeHandle(), getPrivateNodeHandle(), getName(),
                                       "EgoMotion", [this] { return describeMissingInput(); });
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
    processor_ = std::make_unique<EgoMotionProcessor>(params_.processor);
    tf_ = std::make_unique<TfInput>(
        node, *health_, arrivals_,
        [this](const geometry_msgs::TransformStamped& transform, const std::string& publisher,
               bool is_static) { rivals_.addTransform(transform, publisher, is_static); });
    listening_since_ = std::chrono::steady_clock::now();
    if (params_.publish_tf) tf_publisher_ = node.advertise<tf2_msgs::TFMessage>("/tf", 100);
    loop_ =
        std::make_unique<Loop>(private_node, *health_, *processor_, params_.processor.ego_motion,
                               Loop::Hooks{[this](const Loop::Job& job) { process(job); },
                                           [](const EgoMotionParams& params) { EgoMotion{params}; },
                                           "ego_motion",
                                           {}});
    masks_ = std::make_unique<MaskInput>(node, *health_, arrivals_);
    input_ = std::make_unique<StereoInput>(
        node, *health_, params_.sync, [this](const StereoPair& pair) { loop_->push(pair); },
        [this](ros::Time stamp) { tf_->goBackTo(stamp); });
    odometry_publisher_ = outputs_.advertise<nav_msgs::Odometry>(node, "odometry", 10);
    alignment_publisher_ = outputs_.advertise<RowAlignment>(node, "odometry/row_alignment", 10);
    pose_publisher_ =
        outputs_.advertise<geometry_msgs::PoseWithCovarianceStamped>(node, "odometry/pose", 10);
    demand_.start();
  }

  // It is unknown whether a node needs its transforms.
  bool mustNotSleep() const { return params_.publish_tf && !params_.lazy; }

  void wake() {
    loop_->setAwake(true);
    // MovingObjects needs this nodelet. If each kept the other one awake, neither would ever sleep.
    if (params_.use_moving_mask)
      masks_->listenTo(mustNotSleep() ? MaskInput::kTopic : MaskInput::kPassiveTopic);
    if (params_.use_imu)
      imu_subscription_.replace(subscribe<sensor_msgs::Imu>(
          getNodeHandle(), *health_, "imu", 500, [this](const sensor_msgs::ImuConstPtr& imu) {
            requireImu(*imu);
            imu_.add(imu);
            arrivals_.notify();
          }));
    input_->start();
  }

  void guardSubscriptions(const std::function<void()>& work) {
    health_->guard("subscriptions", work, Health::Severity::kBroken);
  }

  void sleep() {
    if (input_) input_->stop();
    if (masks_) masks_->stop();
    imu_subscription_.shutdown();
    if (loop_) loop_->setAwake(false);
  }

  std::string describeMissingInput() const { return input_ ? input_->describeMissingInput() : ""; }

  void process(const Loop::Job& job) {
    requireFrame(*job.frame.left);
    const std::optional<Eigen::Isometry3d> T_base_cam = extrinsic(job.frame);
    if (!T_base_cam) return;

    StageTimes times;
    Stopwatch watch;
    const std::optional<Eigen::Matrix3d> R_cam_prev = rotationPrior(job.frame.left->header);
    watch.lap("waiting for the rotation", times);
    const sensor_msgs::ImageConstPtr mask = masks_->at(last_stamp_);
    const EgoMotionProcessor::Output output = processor_->process(
        job.frame, *T_base_cam, masks_->usable(mask, *job.frame.left), R_cam_prev);
    watch.lap("ego-motion", times);
    if (params_.use_imu) learnGyroBias(job.frame.left->header.stamp, output);
    if (output.sequence.startsAnew()) health_->event(output.sequence.reason);
    if (!output.messages) return;
    publish(*output.messages);
    report(job, output, times);
  }

  std::optional<Eigen::Isometry3d> extrinsic(const StereoPair& pair) {
    if (processor_->cameraIsBase(pair)) return Eigen::Isometry3d::Identity();
    const std::string base = processor_->baseFrame(pair);
    const std::string& camera = pair.left->header.frame_id;
    std::string error;
    const auto T_base_cam = arrivals_.waitFor(params_.transform_timeout, [&] {
      return lookUpTransform(tf_->buffer, base, camera, pair.left->header.stamp, error);
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

  // Rotation prior: the camera's rotation since the previous frame from another sensor.
  std::optional<Eigen::Matrix3d> rotationPrior(const std_msgs::Header& now) {
    const double gap_s = (now.stamp - last_stamp_).toSec();
    if (last_stamp_.isZero() || gap_s <= 0 || gap_s > params_.processor.max_gap) return {};
    if (params_.use_imu) return rotationFromImu(now);
    if (!params_.guess_frame.empty()) return rotationFromTf(now);
    return {};
  }

  std::optional<Eigen::Matrix3d> rotationFromImu(const std_msgs::Header& now) {
    const std::string alone = "; ego-motion uses the images only";
    const auto fail = [&](const std::string& text) {
      health_->problem("imu", Health::Severity::kDegraded, text + alone);
      rotation_is_late_ = true;
      return std::nullopt;
    };
    const std::string topic = getNodeHandle().resolveName("imu"), frame = imu_.frame();
    if (frame.empty() && !imu_subscription_.isPublished())
      return fail("use_imu: nobody publishes " + topic + " (launch argument imu:=<topic>)");
    ImuRotation::Answer answer;
    arrivals_.waitFor(rotation_is_late_ ? 0 : kRotationWithin_s, [&] {
      answer = imu_.between(last_stamp_, now.stamp);
      return answer.complete;
    });
    if (!answer.R_now_previous) return fail("use_imu: " + topic + ": " + answer.reason);
    std::string error;
    const auto T_cam_imu =
        lookUpTransform(tf_->buffer, now.frame_id, imu_.frame(), now.stamp, error);
    if (!T_cam_imu)
      return fail("use_imu: no transform from the left camera '" + now.frame_id +
                  "' to the IMU's frame '" + imu_.frame() +
                  "': publish it (e.g. by tf2_ros static_transform_publisher)");
    rotation_is_late_ = false;
    health_->solved("imu");
    const Eigen::Matrix3d R_cam_imu = T_cam_imu->linear();
    return R_cam_imu * *answer.R_now_previous * R_cam_imu.transpose();
  }

  std::optional<Eigen::Matrix3d> rotationFromTf(const std_msgs::Header& now) {
    std::string error;
    const auto T_cam_prev = arrivals_.waitFor(rotation_is_late_ ? 0 : kRotationWithin_s, [&] {
      return lookUpCameraMotion(tf_->buffer, now.frame_id, last_stamp_, now.stamp,
                                params_.guess_frame, error);
    });
    rotation_is_late_ = !T_cam_prev;
    if (!T_cam_prev) {
      // Not the text of tf, which contains stamps: a text that changes is logged every time.
      health_->problem("guess_frame", Health::Severity::kDegraded,
                       "tf has no motion of '" + now.frame_id + "' relative to guess_frame '" +
                           params_.guess_frame +
                           "' at the image's stamp: set guess_frame to the fixed frame of another "
                           "odometry, or leave it empty; ego-motion uses the images only");
      return std::nullopt;
    }
    health_->solved("guess_frame");
    return Eigen::Matrix3d(T_cam_prev->linear());
  }

  // At rest a gyroscope measures its bias.
  void learnGyroBias(ros::Time stamp, const EgoMotionProcessor::Output& output) {
    const double dt_s = (stamp - last_stamp_).toSec();
    const EgoMotionEstimate& estimate = output.estimate;
    if (last_stamp_.isZero() || dt_s <= 0 || estimate.state != PoseState::kKnown ||
        estimate.frames != 1)
      return;
    const Eigen::Isometry3d& T = estimate.motion.T_cam_prev;
    if (T.translation().norm() > kRest_mps * dt_s ||
        Eigen::AngleAxisd(T.linear()).angle() > kRest_radps * dt_s)
      return;
    imu_.learnBias(last_stamp_, stamp);
    health_->figure("gyro bias [deg/s]", imu_.bias_radps().norm() * 180 / M_PI, "%.3f");
  }

  // The alignment is first: a node that waits for the motion then has it for its next frame.
  void publish(const EgoMotionMessages& messages) {
    alignment_publisher_.publish(messages.row_alignment);
    if (mayPublishTf(messages.transform.child_frame_id)) {
      rivals_.addOwnTransform(messages.transform);
      tf2_msgs::TFMessagePtr tf = boost::make_shared<tf2_msgs::TFMessage>();
      tf->transforms.push_back(messages.transform);
      tf_publisher_.publish(tf);
    }
    odometry_publisher_.publish(messages.odometry);
    pose_publisher_.publish(messages.pose);
  }

  // Two publishers of the same frame are worse than none: a node that finds a rival stops.
  bool mayPublishTf(const std::string& frame) {
    if (!params_.publish_tf || yielded_) return false;
    if (!std::exchange(asked_, true) && othersPublish(tf_publisher_.getTopic())) {
      const std::chrono::duration<double> listened =
          std::chrono::steady_clock::now() - listening_since_;
      arrivals_.waitFor(kFirstTfWithin_s - listened.count(),
                        [&] { return rivals_.rivalOf(frame).has_value(); });
    }
    const std::string objection = rivals_.reasonNotToMove(frame);
    if (objection.empty()) return true;
    yielded_ = true;
    health_->problem("tf", Health::Severity::kDegraded, objection);
    return false;
  }

  // Whether another node publishes on the topic.
  static bool othersPublish(const std::string& topic) {
    XmlRpc::XmlRpcValue request(ros::this_node::getName()), response, state;
    return ros::master::execute("getSystemState", request, response, state, false) &&
           hasOtherPublisher(state, topic, ros::this_node::getName());
  }

  void report(const Loop::Job& job, const EgoMotionProcessor::Output& output,
              const StageTimes& times) {
    const EgoMotionEstimate& estimate = output.estimate;
    last_stamp_ = job.frame.left->header.stamp;
    const std::string why = describeLoss(output);
    if (why.empty())
      health_->solved("tracking");
    else
      health_->problem("tracking", Health::Severity::kDegraded, "lost: " + why);
    health_->figure("pose", std::string(nameOf(output.pose_state)));
    health_->figure("features", estimate.features, "%.0f");
    health_->figure("inliers", estimate.inliers, "%.0f");
    health_->figure("residual [px]", estimate.residual_px, "%.3f");
    health_->figure("largest row offset [px]", estimate.row_alignment.largest_offset_px, "%.2f");
    reportColumns(estimate.column_offset);
    health_->figure("dropped pairs", static_cast<double>(loop_->dropped()), "%.0f");
    health_->figure("unmatched left images", static_cast<double>(input_->unmatched()), "%.0f");
    health_->frame(job.frame.left->header.stamp, job.ageMs(), times);
  }

  std::string describeLoss(const EgoMotionProcessor::Output& output) const {
    if (output.frozen) {
      std::ostringstream text;
      text << "both images have been the same for more than max_gap = " << params_.processor.max_gap
           << " s. Does the camera driver hang? (A simulator needs image noise.)";
      return text.str();
    }
    if (output.estimate.swapped)
      return "the left image shows what the right camera sees. Are the topics of left and right "
             "swapped? (The pose goes on with the last velocity.)";
    const bool goes_on = output.sequence.verdict == SequenceGuard::Verdict::kContinues;
    if (goes_on && output.pose_state != PoseState::kKnown)
      return "too few features agree on a motion; the pose goes on with the last velocity";
    return "";
  }

  void reportColumns(const ColumnOffset& columns) {
    if (!columns.known) return;
    health_->figure("column offset [px]", columns.offset_px, "%.2f");
    health_->figure("column offset sigma [px]", columns.sigma_px, "%.2f");
    if (std::abs(columns.offset_px) - 2 * columns.sigma_px <= kLargestColumnOffsetPx) {
      health_->solved("calibration");
      return;
    }
    char text[300];
    std::snprintf(
        text, sizeof text,
        "the right image is shifted by %.1f px (sigma %.1f) to the right of its calibration, and "
        "all disparities are too small by as much: calibrate the cameras again, or add %.1f to "
        "P[2] of right/camera_info",
        columns.offset_px, columns.sigma_px, columns.offset_px);
    health_->problem("calibration", Health::Severity::kDegraded, text);
  }

  static constexpr double kLargestColumnOffsetPx = 0.5;
  static constexpr double kRotationWithin_s = 0.05;
  static constexpr double kRest_mps = 0.02, kRest_radps = 0.005;
  static constexpr double kFirstTfWithin_s = 0.5;  // rivals are assumed to publish at 2 Hz or more

  EgoMotionNodeletParams params_;
  Demand demand_{{[this] { return mustNotSleep() || outputs_.wanted(); },
                  [this] { wake(); },
                  [this] { sleep(); },
                  {},
                  [this](const auto& work) { guardSubscriptions(work); }}};
  std::unique_ptr<Health> health_;
  Arrivals arrivals_;
  TfRivals rivals_;
  std::chrono::steady_clock::time_point listening_since_;
  bool asked_ = false;    // this nodelet has waited for transforms of rivals
  bool yielded_ = false;  // it does not publish tf because of a rival
  std::unique_ptr<TfInput> tf_;
  std::unique_ptr<EgoMotionProcessor> processor_;
  Outputs outputs_{[this] { demand_.update(); }};
  ros::Publisher odometry_publisher_, pose_publisher_, alignment_publisher_, tf_publisher_;
  std::unique_ptr<MaskInput> masks_;
  ImuRotation imu_;
  Subscription imu_subscription_;
  bool rotation_is_late_ = false;  // do not wait for it again until it has arrived
  ros::Time last_stamp_;
  std::unique_ptr<Loop> loop_;
  std::unique_ptr<StereoInput> input_;
};

}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::EgoMotionNodelet, nodelet::Nodelet)
