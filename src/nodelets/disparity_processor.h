#pragma once

#include <predictive_stereo/RowAlignment.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>

#include <optional>

#include "nodelets/message_pool.h"
#include "nodelets/sequence_guard.h"
#include "nodelets/stereo_messages.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

struct DisparityProcessorParams {
  double max_gap = 1.0;  ///< [s] frames further apart do not belong together
  DisparityParams disparity;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_gap", max_gap, 0.01, 3600.0);
    disparity.visit(v);
  }
};

struct DisparityMessages {
  stereo_msgs::DisparityImagePtr disparity, measured_disparity, predicted_disparity;
  sensor_msgs::ImagePtr disparity_variance, measured_variance, predicted_variance;
  sensor_msgs::ImagePtr search_range;
  RowAlignment::Ptr row_alignment;

  bool predicted = false;           ///< whether the past was used
  double mean_search_width_px = 0;  ///< over all pixels
  double searched_fraction = 0;     ///< share of all (pixel, disparity) pairs that was searched
};

/// Disparity messages from pairs; what the Disparity nodelet and `replay` run. The core writes
/// straight into the messages' memory.
class DisparityProcessor {
 public:
  explicit DisparityProcessor(const DisparityProcessorParams& params);

  /// Step 1.
  /// @returns kDuplicate where the pair is to be ignored.
  /// @throws std::invalid_argument for a pair that cannot be used; the state stays as it was.
  SequenceGuard::Result begin(const StereoPair& pair);
  /// Step 2, which needs no ego-motion: may run beside predict().
  void matchCoarsely() { estimator_.matchCoarsely(); }

  /// Stamp of the frame from which predict() needs the camera's motion; none: it needs no motion.
  std::optional<ros::Time> previousStamp() const { return previous_stamp_; }

  /// Step 3, see DisparityEstimator::predict().
  void predict(const std::optional<CameraMotion>& motion);

  /// Step 4: all messages, of which `disparity` and `disparity_variance` have no values before
  /// finish().
  DisparityMessages estimate();

  /// Step 5: may run beside the detection of moving objects and markMoving().
  void finish();

  /// See DisparityEstimator::markMoving: of the frame that was estimated last.
  /// @throws std::invalid_argument for a mask of another encoding or size.
  void markMoving(const sensor_msgs::Image& mask);

  /// See DisparityEstimator::setParams.
  void setParams(const DisparityParams& params);

  void reset();

  const std::string& simdTarget() const { return estimator_.simdTarget(); }
  const StageTimes& times() const { return estimator_.times(); }

 private:
  sensor_msgs::ImagePtr image(const std::string& encoding);
  stereo_msgs::DisparityImagePtr disparityImage();

  DisparityProcessorParams params_;
  DisparityEstimator estimator_;
  SequenceGuard guard_;
  cv::Mat1b left_buffer_, right_buffer_;
  MessagePool<sensor_msgs::Image> images_;
  MessagePool<stereo_msgs::DisparityImage> disparities_;

  // In work.
  StereoPair pair_;
  DisparityMessages messages_;
  DisparityOutput output_;
  StereoRig rig_;
  std::optional<ros::Time> previous_stamp_;
};

}  // namespace predictive_stereo
