#include <Eigen/Cholesky>
#include <boost/pointer_cast.hpp>
#include <cmath>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <string>
#include <vector>

#include "nodelets/frame_nodelet.h"
#include "nodelets/odometry_input.h"
#include "nodelets/output_topics.h"
#include "nodelets/transforms.h"

namespace predictive_stereo {
namespace {

// The largest standard deviation of the camera's motion since the previous frame. What is not
// positive definite, as of an odometry in the plane, the detector takes for not told.
std::string describeSigma(const Matrix6d& covariance) {
  if (Eigen::LLT<Matrix6d>(covariance).info() != Eigen::Success)
    return "odometry does not tell it: 15 mm are taken";
  return cv::format("%.1f mm", 1e3 * std::sqrt(covariance.diagonal().head<3>().maxCoeff()));
}

// Outputs of the Disparity nodelet, and the left image. The first topic has the messages that need
// partners. Left images do not, because not every one has a disparity. The predicted maps come
// last: they are not always needed.
struct DisparityInput {
  using Frame = MovingObjectsInput;
  static constexpr size_t kWithoutPredicted = 4;

  static std::vector<SyncedTopics::Topic> topics() {
    using Type = SyncedTopics::Type;
    // Every input has the left image's stamp, but for the calibration: its stamp may differ as far
    // as the other nodelets allow (sync_tolerance).
    return {{"measured_disparity", Type::kDisparity},  {"measured_variance", Type::kImage},
            {"left/image_rect", Type::kCameraImage},   {"left/camera_info", Type::kFixedInfo},
            {"predicted_disparity", Type::kDisparity}, {"predicted_variance", Type::kImage}};
  }
  static SyncedTopics::Cures cures() {
    return {
        "run the camera driver and the Disparity nodelet in this namespace (launch argument "
        "camera:=<namespace>), or remap",
        "see the diagnostics of the Disparity nodelet",
        "no disparity has the stamp of a left image that is still there: raise queue_size, or do "
        "the topics belong to two cameras?"};
  }
  static MovingObjectsInput frame(const SyncedTopics::Set& set) {
    using boost::static_pointer_cast;
    using sensor_msgs::Image;
    using stereo_msgs::DisparityImage;
    MovingObjectsInput input;
    input.measured_disparity = static_pointer_cast<const DisparityImage>(set[0]);
    input.measured_variance = static_pointer_cast<const Image>(set[1]);
    input.left = static_pointer_cast<const Image>(set[2]);
    input.left_info = static_pointer_cast<const sensor_msgs::CameraInfo>(set[3]);
    if (set.size() == kWithoutPredicted) return input;
    input.predicted_disparity = static_pointer_cast<const DisparityImage>(set[4]);
    input.predicted_variance = static_pointer_cast<const Image>(set[5]);
    return input;
  }
};

/// Moving objects from images, disparities and their variance. Topics, services and parameters:
/// docs/nodes.md.
class MovingObjectsNodelet
    : public FrameNodelet<MovingObjectsNodeletParams, DisparityInput, MovingObjectsProcessor,
                          MovingObjectDetector, DetectionParams> {
 public:
  MovingObjectsNodelet()
      : FrameNodelet("MovingObjects", "moving_objects", &MovingObjectsNodeletParams::detection,
                     {"scheme"}) {}
  ~MovingObjectsNodelet() override { shutDown(); }

 private:
  void connect(ros::NodeHandle& node) override {
    odometry_.emplace(node, *health_, arrivals_, *tf_, params_, "row_alignment");
    makeInput(node, SyncParams::exact(params_.queue_size, params_.image_transport));
    visitMovingObjectsOutputs(*outputs_);
    passive_mask_ = node.advertise<sensor_msgs::Image>(kPassiveMaskTopic, 5);
  }

  void subscribeInputs() override { odometry_->start(); }
  void unsubscribeInputs() override {
    if (odometry_) odometry_->stop();
  }
  size_t neededTopics() const override {
    const bool by_paper = params_.detection.scheme == DetectionScheme::kPaper;
    return by_paper || outputs_->wanted("moving_objects/residual")
               ? DisparityInput::topics().size()
               : DisparityInput::kWithoutPredicted;
  }
  void goBackTo(ros::Time stamp) override { odometry_->goBackTo(stamp); }

  void process(const Job& job) override {
    const std_msgs::Header& header = job.frame.left->header;
    Stopwatch watch;
    StageTimes times;
    const std::optional<CameraPose> pose = odometry_->pose(processor_->lastWithPose(), header);
    if (pose) health_->figure("sigma of the motion", describeSigma(pose->motion_covariance));
    watch.lap("waiting for the pose", times);
    MovingObjectsInput input = job.frame;
    input.row_alignment = odometry_->columns().of(header.stamp);
    const MovingObjectsProcessor::Output output = processor_->process(input, pose);
    watch.lap("detection", times);
    if (!tell(output.sequence)) return;
    passive_mask_.publish(output.mask);  // first: other nodelets wait for it
    outputs_->publish(output);
    health_->figure("objects", static_cast<double>(output.objects->objects.size()), "%.0f");
    finish(job, times, "frames", "frames");
  }

  ros::Publisher passive_mask_;
  std::optional<OdometryInput> odometry_;
};

}  // namespace
}  // namespace predictive_stereo

PLUGINLIB_EXPORT_CLASS(predictive_stereo::MovingObjectsNodelet, nodelet::Nodelet)
