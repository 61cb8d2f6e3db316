/// The disparity range, and the value of unknown disparities.
#pragma once

namespace predictive_stereo {

/// The disparities that are searched: min_disparity, ..., min_disparity + count - 1 [px].
///
/// Every disparity map of this package is 32-bit float, in pixels of the full-resolution left
/// image. Unknown pixels have the finite value `invalid()`, below every valid disparity (NaN would
/// break consumers such as cv::reprojectImageTo3D).
struct DisparityRange {
  int min_disparity = 0;  ///< smallest disparity [px]
  int count = 128;        ///< number of integer disparities, a multiple of 16, at most 256

  /// The value of unknown disparities [px].
  float invalid() const { return static_cast<float>(min_disparity - 1); }
  /// Whether a disparity is known. Values above max_disparity() count as known.
  bool isValid(float disparity_px) const {
    return disparity_px >= static_cast<float>(min_disparity);
  }
  /// Largest disparity that is searched [px].
  int max_disparity() const { return min_disparity + count - 1; }
  bool operator==(const DisparityRange& other) const {
    return min_disparity == other.min_disparity && count == other.count;
  }
  bool operator!=(const DisparityRange& other) const { return !(*this == other); }

  template <class Visitor>
  void visit(Visitor&& v) {
    v("min_disparity", min_disparity, -256, 256);
    v("count", count, 16, 256);
  }
};

/// Whether an offset of the principal points (cx_left - cx_right) leaves a left column a partner in
/// the right image. False if it is not finite. Without an offset always true: the range is then
/// what the user asked for.
inline bool leavesPartners(const DisparityRange& range, double offset_px, int image_width) {
  if (offset_px == 0) return true;
  return range.min_disparity + offset_px < image_width &&
         range.max_disparity() + offset_px > -image_width;
}

}  // namespace predictive_stereo
