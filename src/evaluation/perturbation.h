/// Perturbed versions of a sequence: the score of a detector must not depend on chance.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/object_labels.h"
#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {

/// One change of the images, of the set of frames, or of the search ranges.
struct Perturbation {
  std::string name;
  double margin_px = 0;         ///< SearchRangeParams::margin_px; 0: unchanged
  double noise_sigma = 0;       ///< of grey levels, Gaussian, in both images
  double gain = 1, offset = 0;  ///< of grey levels of both images
  double right_gain = 1;        ///< of grey levels of the right image, in addition
  double column_offset_px = 0;  ///< largest error of the right image's columns, quadratic
  double column_bow_px = 0;     ///< their error at both borders, a parabola over the columns
  double column_jump_px = 0;    ///< their error from the middle of the sequence on, constant
  bool mirrored = false;        ///< flipped; the right image becomes the left one
  int every = 1, first = 0;     ///< only frames `first`, `first + every`, ...
  int drop_every = 0;           ///< frames 5, 5 + drop_every, ... are missing; 0: none

  PipelineParams applyTo(PipelineParams params) const;
};

/// The perturbations of evaluate_detection --perturb; the first one changes nothing.
const std::vector<Perturbation>& perturbations();

/// A copy of a sequence in memory, with its moving objects, for repeated runs.
/// @param max_frames  0: all.
std::unique_ptr<Sequence> loadIntoMemory(const Sequence& sequence, int max_frames);

/// A label for the mirrored sequence, whose left camera is the right one. It is tolerated if its
/// distance is not known, or if the right image shows less than half of it.
ObjectLabel mirrored(const ObjectLabel& label, const StereoRig& rig);

/// The sequence, perturbed, without true poses.
std::unique_ptr<Sequence> perturbed(std::shared_ptr<const Sequence> sequence,
                                    const Perturbation& perturbation);

}  // namespace predictive_stereo
