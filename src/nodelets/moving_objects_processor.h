#pragma once

#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/Image.h>

#include <optional>

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

  explicit MovingObjectsProcessor(const MovingObjectsNodeletParams& params);

  /// @param pose  none: unknown in this frame.
  /// @throws std::invalid_argument for messages that cannot be used; the state stays as it was.
  Output process(const MovingObjectsInput& input, const std::optional<CameraPose>& pose);
  /// The last frame with a pose; none after a reset.
  std::optional<ros::Time> lastWithPose() const { return last_with_pose_; }

  /// See MovingObjectDetector::setParams. The disparity range is always that of the messages.
  void setParams(const DetectionParams& params) { setParams(params, params_.detection.range); }

  void reset();

 private:
  void setParams(DetectionParams params, const DisparityRange& range);
  StereoFrame makeFrame(const MovingObjectsInput& input);
  SequenceGuard::Result begin(const StereoFrame& frame);
  void detect(const StereoFrame& frame, const std::optional<CameraPose>& pose);

  MovingObjectsNodeletParams params_;
  SequenceGuard guard_;
  MovingObjectDetector detector_;
  StereoRig rig_;               // of the last frame, as calibrated
  ColumnOffset column_offset_;  // of its disparities
  DisparityOutput maps_;        // views of messages
  Detections detections_;
  cv::Mat1b left_buffer_;
  MessagePool<sensor_msgs::Image> images_;
  std::optional<ros::Time> last_with_pose_;
  MovingObjectsInput last_;  // keeps the memory that the detector may still read
};

}  // namespace predictive_stereo
