#pragma once

#include <string>
#include <vector>

#include "evaluation/sequence.h"
#include "predictive_stereo/ego_motion.h"

namespace predictive_stereo {

/// Frames of a sequence that the ego-motion cannot use.
struct Loss {
  enum class Kind {
    kBlack,    ///< both images are black
    kSwapped,  ///< left and right image are exchanged
    kMissing,  ///< the frames do not arrive
  };
  struct Span {
    int first, frames;
  };
  std::string name;
  Kind kind = Kind::kBlack;
  std::vector<Span> spans;

  bool contains(int index) const;
};

/// The losses that fit into a sequence: 1 to 25 frames and two seconds in its middle, and several
/// one after the other.
std::vector<Loss> usualLosses(int frames, double seconds_per_frame);

/// Error of the pose, and its standard deviation in the direction of this error.
struct PoseCheckpoint {
  double error_m = 0, sigma_m = 0, error_rad = 0, sigma_rad = 0;

  double translationRatio() const { return sigma_m > 0 ? error_m / sigma_m : 0; }
  double rotationRatio() const { return sigma_rad > 0 ? error_rad / sigma_rad : 0; }
};

struct LossResult {
  std::string name;
  double unseen_m = 0, unseen_rad = 0;  ///< of the true path, between the frames around the losses
  PoseCheckpoint end;                   ///< in the last frame that is lost; of missing ones: zeros
  PoseCheckpoint after;                 ///< in the first known frame after all losses
  double worst_translation_ratio = 0, worst_rotation_ratio = 0;  ///< from the first loss on
};

/// Runs the ego-motion on a sequence with each loss.
/// @returns first the result without a loss, then one for each loss. Without exact
///   true poses, those that were estimated without a loss take their place: the error is then what
///   the loss adds.
std::vector<LossResult> evaluateLosses(const Sequence& sequence, const EgoMotionParams& params,
                                       const std::vector<Loss>& losses, int frames);

}  // namespace predictive_stereo
