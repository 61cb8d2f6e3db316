/// Enlarges small images and their maps for the default detection scheme.
///
/// The scheme's numbers in pixels (patches, cells, errors of disparities and flow) were set on
/// images of up to 1242x375. In a smaller image of the same view, objects have fewer pixels, and
/// errors are fewer pixels, too: those of the calibration are angles, those of the lens and of the
/// matcher's windows are blur. So a small image is enlarged to that size.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// From the camera's images to the scheme's.
class Enlargement {
 public:
  Enlargement() = default;
  /// None for an empty size.
  explicit Enlargement(cv::Size size);

  bool isNone() const { return size_ == enlarged_size_; }
  /// The rig of the enlarged images.
  StereoRig of(const StereoRig& rig) const;
  /// Replaces images, maps and rig. The predicted maps, which the scheme does not need, get empty.
  /// @param enlarged  its memory is used again.
  void enlarge(const DetectionInput& input, const DisparityRange& range,
               DetectionInput& enlarged) const;
  /// Boxes and the mask in the camera's images.
  void reduce(Detections& detections) const;

 private:
  double scaleX() const { return double(enlarged_size_.width) / size_.width; }
  double scaleY() const { return double(enlarged_size_.height) / size_.height; }

  cv::Size size_, enlarged_size_;
};

}  // namespace predictive_stereo
