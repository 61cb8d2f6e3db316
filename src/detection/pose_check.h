#pragma once

#include <optional>

namespace predictive_stereo {

/// Detects wrong poses: with a wrong pose nearly the whole image contradicts a static world. A pose
/// counts as wrong if the contradicting share is very large or grows suddenly, for at most two
/// frames in a row; a large share that lasts longer is accepted.
class PoseCheck {
 public:
  /// Whether the image agrees with the camera's motion since the previous frame as well as usual.
  /// @param contradicting  share of the image that a static world does not explain.
  bool agreesWithMotion(double contradicting);
  /// Whether it is so large that no object in view explains it.
  static bool contradictsMost(double contradicting);
  void reset() { *this = PoseCheck(); }

 private:
  std::optional<double> usual_;
  int odd_frames_ = 0;  ///< in a row
};

}  // namespace predictive_stereo
