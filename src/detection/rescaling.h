/// Brings images and maps of all sizes to about one size for the default detection scheme.
///
/// The scheme's numbers in pixels (patches, cells, errors of disparities and flow) were set on
/// images of about 1242x375. In a smaller image of the same view, objects have fewer pixels, and
/// errors, too: those of the calibration are angles, those of the lens and of the matcher's windows
/// are blur. So small images are enlarged, unless they are a narrow part of a view. Large ones are
/// reduced, which also bounds the time.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/stereo_rig.h"

namespace predictive_stereo {

/// From the camera's images to the scheme's.
class Rescaling {
 public:
  /// None.
  Rescaling() = default;
  explicit Rescaling(const StereoRig& camera);

  /// Whether it is the one of this camera: it depends on the size and the focal length.
  bool isOf(const StereoRig& camera) const {
    return camera.size == size_ && camera.fx_px == focal_length_px_;
  }
  bool isNone() const { return size_ == rescaled_size_; }
  /// The side of a pixel of the camera.
  float cameraPixel_px() const { return isNone() ? 1 : static_cast<float>(scaleX()); }
  /// The rig of the rescaled images.
  StereoRig of(const StereoRig& rig) const;
  /// The range of their disparities.
  DisparityRange of(const DisparityRange& range) const;
  /// All but the predicted maps, which the scheme does not need.
  /// @param range  of the camera's images; unknown disparities get the rescaled range's value.
  /// @param rescaled  its memory is used again.
  void rescale(const DetectionInput& input, const DisparityRange& range, DetectionInput& rescaled);
  /// The detections in the camera's images.
  /// @param detections  a mask of the camera's size keeps its memory.
  void restore(const Detections& rescaled, Detections& detections) const;

 private:
  double scaleX() const { return double(rescaled_size_.width) / size_.width; }
  double scaleY() const { return double(rescaled_size_.height) / size_.height; }
  void rescaleImage(const cv::Mat1b& image, cv::Mat1b& rescaled);

  cv::Size size_, rescaled_size_;
  double focal_length_px_ = 0;
  std::vector<int> columns_, rows_;  // of the camera's images, for each one of the rescaled ones
  std::vector<cv::Mat1b> halves_;    // each one half of the one before it
};

}  // namespace predictive_stereo
