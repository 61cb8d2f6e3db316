/// Ground truth of moving objects: from label files, or the synthetic street.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/simulation/street.h"

namespace predictive_stereo {

/// A labelled object in one frame; CSV with the columns
/// frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard. Nothing here needs
/// truncated and occluded.
struct ObjectLabel {
  int frame = 0;  ///< number of the image file
  int track = 0;  ///< the same for one object in all frames
  /// Kind of a moving object; "static": parked; "ignore": not known.
  std::string type;
  cv::Rect2d box_px;
  std::optional<double> distance_m;  ///< depth of its nearest part
  std::string motion;                ///< toward, away, crossing, static, unknown
  bool hard = false;                 ///< moving, but too hard to be demanded
  std::optional<double> speed_mps;   ///< over ground; not in files

  bool isStatic() const { return type == "static"; }
  bool isIgnored() const { return type == "ignore"; }
  /// Whether a detector must find it. Objects that are neither demanded nor static are tolerated.
  bool isDemanded() const { return !hard && !isStatic() && !isIgnored(); }
};

/// @throws std::runtime_error with the file, if it cannot be read, and the line that is malformed.
std::vector<ObjectLabel> readObjectLabels(const std::string& path);

/// The labels of one frame.
std::vector<ObjectLabel> labelsOf(const std::vector<ObjectLabel>& labels, int frame);

/// A moving object of the synthetic street. It is demanded (not hard) if it is nearer than 35 m,
/// faster than 2 m/s over ground (or, nearer than 10 m, than a fifth of its distance each second),
/// at least half visible, and its box has 400 px^2 or more.
/// @param velocity_cam_mps  over ground, in the camera's axes.
/// @param visible  share of its outline that is inside the image and not occluded.
ObjectLabel trueObject(int frame, int id, const std::string& type, const cv::Rect2d& box_px,
                       double distance_m, const Eigen::Vector3d& centre_m,
                       const Eigen::Vector3d& velocity_cam_mps, double visible);
std::vector<ObjectLabel> labelsOf(const StreetFrame& frame);

/// Direction of a velocity relative to the line of sight: "toward" or "away" within 45 degrees of
/// it, else "crossing".
std::string directionOf(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& velocity_cam_mps);

/// 255 on the boxes of one frame except static ones, widened by `margin_px`.
cv::Mat1b movingMask(const std::vector<ObjectLabel>& labels, int frame, cv::Size size,
                     int margin_px);

}  // namespace predictive_stereo
