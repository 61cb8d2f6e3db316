#pragma once

#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/Image.h>
#include <tf2_eigen/tf2_eigen.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "nodelets/message_checks.h"
#include "nodelets/message_pool.h"
#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "predictive_stereo/disparity_loop.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/stereo_frame.h"

namespace predictive_stereo {

/// Moving objects from disparity messages; used by the MovingObjects nodelet and by `replay`.
class MovingObjectsProcessor {
 public:
  struct Output {
    SequenceGuard::Result sequence;
    // nullptr for a frame that is ignored.
    MovingObjectArrayPtr objects;
    sensor_msgs::ImagePtr mask;  ///< mono8, 255 on moving objects
    // What they were made from.
    MovingObjectsInput input;
    std::optional<CameraPose> pose;
  };

  explicit MovingObjectsProcessor(const MovingObjectsNodeletParams& params)
      : params_(params), guard_(params.max_gap), detector_(params.detection) {
    validate(params);
  }

  /// @param pose  none: unknown in this frame.
  /// @throws std::invalid_argument for messages that cannot be used; the state stays as it was.
  Output process(const MovingObjectsInput& input, const std::optional<CameraPose>& pose) {
    const StereoFrame frame = makeFrame(input);
    const DisparityRange range = rangeOf(*input.measured_disparity);
    // Before the frame begins, because the detector may refuse the range.
    if (range != params_.detection.range) setParams(params_.detection, range);
    Output output;
    output.input = input;
    output.pose = pose;
    output.sequence = begin(frame);
    if (output.sequence.isIgnored()) return output;

    output.mask = images_.take();
    const std_msgs::Header& header = input.left->header;
    detections_.mask = allocateImage<uint8_t>(header, frame.left.size(), *output.mask);
    if (input.row_alignment) column_offset_ = columnOffset(*input.row_alignment);
    detect(frame, pose);
    last_ = input;
    if (pose) last_with_pose_ = input.left->header.stamp;

    output.objects = boost::make_shared<MovingObjectArray>();
    output.objects->header = header;
    for (const DetectedObject& object : detections_.objects)
      output.objects->objects.push_back(message(object));
    return output;
  }
  /// The last frame with a pose; none after a reset.
  std::optional<ros::Time> lastWithPose() const { return last_with_pose_; }

  /// See MovingObjectDetector::setParams. The disparity range is always that of the messages.
  void setParams(const DetectionParams& params) { setParams(params, params_.detection.range); }

  void reset() {
    detector_.reset();
    column_offset_ = ColumnOffset();
    guard_.forget();
    last_with_pose_.reset();
  }

 private:
  void setParams(DetectionParams params, const DisparityRange& range) {
    params.range = range;
    detector_.setParams(params);
    params_.detection = params;
  }

  // A frame and its maps as views of the messages' memory.
  StereoFrame makeFrame(const MovingObjectsInput& input) {
    StereoFrame frame;
    requireStamp(input.left->header.stamp, ZeroStamp::kLegal);
    frame.stamp = stampOf(input.left->header.stamp);
    frame.left = greyImage(*input.left, "left");
    const cv::Size size = frame.left.size();
    frame.rig = rigOf(*input.left_info, *input.measured_disparity, size);
    const auto view = [&](const sensor_msgs::Image& message, const char* name) {
      requireOneCamera(name, sizeOf(message), "left/image_rect", size);
      return floatView(message, name);
    };
    maps_ = DisparityOutput();
    maps_.measured_disparity_px = view(input.measured_disparity->image, "measured_disparity");
    maps_.measured_variance_px2 = view(*input.measured_variance, "measured_variance");
    if (!input.predicted_disparity) return frame;
    maps_.predicted_disparity_px = view(input.predicted_disparity->image, "predicted_disparity");
    maps_.predicted_variance_px2 = view(*input.predicted_variance, "predicted_variance");
    if (rangeOf(*input.measured_disparity) != rangeOf(*input.predicted_disparity))
      throw std::invalid_argument(
          "measured_disparity and predicted_disparity have different disparity ranges; do the "
          "topics come from one Disparity nodelet?");
    return frame;
  }

  SequenceGuard::Result begin(const StereoFrame& frame) {
    const SequenceGuard::Result sequence = guard_.next(frame.stamp, frame.rig);
    using Verdict = SequenceGuard::Verdict;
    if (sequence.isIgnored()) return sequence;
    if (sequence.verdict == Verdict::kBackward || frame.rig != rig_)
      column_offset_ = ColumnOffset();
    if (sequence.verdict != Verdict::kContinues) detector_.reset();
    rig_ = frame.rig;
    return sequence;
  }

  void detect(const StereoFrame& frame, const std::optional<CameraPose>& pose) {
    const DetectionInput input{toSeconds(frame.stamp),
                               corrected(frame.rig, column_offset_),
                               frame.left,
                               maps_.measured_disparity_px,
                               maps_.measured_variance_px2,
                               maps_.predicted_disparity_px,
                               maps_.predicted_variance_px2,
                               pose ? PoseState::kKnown : PoseState::kLost,
                               pose ? pose->T_odom_cam : Eigen::Isometry3d::Identity(),
                               pose ? pose->motion_covariance : Matrix6d::Zero()};
    detector_.detect(input, detections_);
  }

  // The left camera with the baseline of the disparity image.
  static StereoRig rigOf(const sensor_msgs::CameraInfo& left_info,
                         const stereo_msgs::DisparityImage& disparity, cv::Size size) {
    const Matrix34d P = projectionMatrix(left_info);
    if (std::abs(P(0, 0) - disparity.f) > 1e-3 * std::abs(disparity.f))
      throw std::invalid_argument("left/camera_info has a focal length of " +
                                  std::to_string(P(0, 0)) + " px but measured_disparity one of " +
                                  std::to_string(disparity.f) +
                                  " px; do the topics belong to one camera?");
    Matrix34d P_right = P;
    P_right(0, 3) = P(0, 3) - P(0, 0) * disparity.T;
    return StereoRig::fromProjections(P, P_right, size);
  }

  static MovingObject message(const DetectedObject& object) {
    MovingObject result;
    result.id = static_cast<uint32_t>(object.id);
    result.bbox.center.x = object.box_px.x + object.box_px.width / 2;
    result.bbox.center.y = object.box_px.y + object.box_px.height / 2;
    result.bbox.size_x = object.box_px.width;
    result.bbox.size_y = object.box_px.height;
    result.pose.position = tf2::toMsg(object.centre_m);
    result.pose.orientation.w = 1;
    tf2::toMsg(object.size_m, result.size);
    tf2::toMsg(object.velocity_mps, result.velocity);
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(result.velocity_covariance.data()) =
        object.velocity_covariance;
    // -1 means "no estimate", as in sensor_msgs/Imu.
    if (object.velocity_covariance.isZero()) result.velocity_covariance[0] = -1;
    result.score = object.score;
    result.age = static_cast<uint32_t>(object.age);
    result.distance = object.distance_m;
    return result;
  }

  MovingObjectsNodeletParams params_;
  SequenceGuard guard_;
  MovingObjectDetector detector_;
  StereoRig rig_;               // of the last frame, as calibrated
  ColumnOffset column_offset_;  // of its disparities
  DisparityOutput maps_;        // views of messages
  Detections detections_;
  MessagePool<sensor_msgs::Image> images_;
  std::optional<ros::Time> last_with_pose_;
  MovingObjectsInput last_;  // keeps the memory that the detector may still read
};

}  // namespace predictive_stereo
