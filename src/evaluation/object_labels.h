#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace predictive_stereo {

/// A labelled object in one frame; CSV with the columns
/// frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard.
struct ObjectLabel {
  int frame = 0;  ///< number of the image file
  int track = 0;  ///< the same for one object in all frames
  /// Kind of a mover; "static": parked; "ignore": cannot be told.
  std::string type;
  cv::Rect box_px;
  double distance_m = 0;  ///< NaN where unknown
  bool truncated = false;
  int occluded = 0;
  std::string motion;  ///< toward, away, crossing, static, unknown
  bool hard = false;   ///< a mover that cannot be demanded

  bool isStatic() const { return type == "static"; }
  bool isIgnored() const { return type == "ignore"; }
};

/// @throws std::runtime_error that names the file, and the line that is malformed.
std::vector<ObjectLabel> readObjectLabels(const std::string& path);

/// 255 on boxes of one frame that move or may move, widened by `margin_px`.
cv::Mat1b movingMask(const std::vector<ObjectLabel>& labels, int frame, cv::Size size,
                     int margin_px);

}  // namespace predictive_stereo
