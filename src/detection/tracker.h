/// Objects from frame to frame.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "detection/observation.h"

namespace predictive_stereo {

/// An object tracked over frames.
struct ObjectTrack {
  int id = 0;
  int age = 0;            ///< frames since the first observation
  unsigned history = 0;   ///< bit k: observed k frames ago, of the frames in which it was sought
  int unseen_frames = 0;  ///< since the last observation, sought or not ...
  double seen_s = 0;      ///< ... and its stamp
  int observations = 0;
  double evidence =
      0;  ///< that it is right: natural logarithm of the odds, summed over observations
  bool confirmed = false;
  int observation = -1;  ///< index in the current frame; -1: not observed
  Observation last;      ///< the last one; its box, not its mask, is predicted if not observed
  cv::Rect seen_box_px;  ///< of the last observation, not predicted
  bool located = false;  ///< whether it was observed in a frame with a pose
  Eigen::Matrix<double, 6, 1> state;  ///< position [m], velocity [m/s] in the odom frame
  Eigen::Matrix<double, 6, 6> covariance;
};

/// Gives observations identity and velocity, by one constant-velocity Kalman filter per object in
/// the odom frame.
class ObjectTracker {
 public:
  /// @param largest_speed_mps  3 sigma of a new object's speed.
  ObjectTracker(const TrackingParams& params, double largest_speed_mps)
      : params_(params), largest_speed_mps_(largest_speed_mps) {}
  /// Keeps the tracks.
  void setParams(const TrackingParams& params, double largest_speed_mps) {
    params_ = params;
    largest_speed_mps_ = largest_speed_mps;
  }

  /// Predicts all tracks to this frame.
  /// @param T_odom_cam  none: not known. Boxes and positions in the odom frame then stay as they
  ///   are until the next pose, and nothing is measured in the odom frame.
  void predict(double stamp_s, const StereoRig& rig,
               const std::optional<Eigen::Isometry3d>& T_odom_cam);
  /// Assigns each observation to a track, or starts a new one.
  /// @param sought  whether known objects were sought in this frame. If not, those without
  ///   observation are not missed; they wait for up to kLongestGap_s since the last one.
  void update(const std::vector<Observation>& observations, bool sought = true);

  const std::vector<ObjectTrack>& tracks() const { return tracks_; }
  DetectedObject describe(const ObjectTrack& track) const;
  /// Forgets the tracks. Their ids are not given again.
  void reset();
  /// Gives none of the other's ids.
  void continueIds(const ObjectTracker& other) { next_id_ = other.next_id_; }

 private:
  bool goesOn(ObjectTrack& track, bool sought) const;
  void correct(const Observation& observation, ObjectTrack& track) const;
  void correctVelocity(const Observation& observation, ObjectTrack& track) const;
  void locate(const Observation& observation, ObjectTrack& track) const;
  ObjectTrack start(const Observation& observation);

  TrackingParams params_;
  double largest_speed_mps_;
  std::vector<ObjectTrack> tracks_;
  int next_id_ = 1;
  double now_s_ = 0;
  std::optional<double> located_s_;  // the last stamp with a pose ...
  double interval_s_ = 0;            // ... and the time from the one before
  StereoRig rig_;
  std::optional<Eigen::Isometry3d> T_odom_cam_;
};

/// Whether an object without observation in this frame is still there: most pixels in its predicted
/// box have its disparity.
/// @param moved_along  the object, predicted to this frame.
/// @param margin_m  before its nearest and behind its farthest part.
/// @param[out] mask  255 on these pixels; of the size of the box within the image.
bool isStillThere(const DetectionInput& input, const DisparityRange& range,
                  const Observation& moved_along, double margin_m, cv::Mat1b& mask);

}  // namespace predictive_stereo
