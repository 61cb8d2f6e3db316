#pragma once

#include <optional>

namespace predictive_stereo {

/// Finds poses that jump: a wrong pose moves everything at once. Motion that
/// covers the image suddenly, or
/// nearly all of it, is taken for that, in so many frames in a row; half of a view that moves for
/// longer is believed.
class PoseCheck {
 public:
  /// Whether the image agrees with the motion since the frame before, as far as it usually does.
  /// @param contradicting  share of the image that the static world does not explain.
  bool agreesWithMotion(double contradicting);
  void reset() { *this = PoseCheck(); }

 private:
  std::optional<double> usual_;
  int odd_frames_ = 0;  ///< in a row
};

}  // namespace predictive_stereo
