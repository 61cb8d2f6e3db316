/// What is known about the pose of a frame.
#pragma once

namespace predictive_stereo {

/// From the ego-motion to the detection, odometry messages and diagnostics.
enum class PoseState {
  kKnown,  ///< the motion to this frame was seen, or the path starts here
  kHeld,   ///< it was not seen; later frames are still compared with one from before
  kLost,   ///< it was not seen, and no later frame will be compared with one from before
};

/// "known", "held" or "lost".
constexpr const char* nameOf(PoseState state) {
  constexpr const char* kNames[] = {"known", "held", "lost"};
  return kNames[static_cast<int>(state)];
}

}  // namespace predictive_stereo
