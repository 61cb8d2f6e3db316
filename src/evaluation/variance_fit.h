/// Parameters of the published variance, from disparities with truth.
#pragma once

#include <vector>

#include "predictive_stereo/variance.h"

namespace predictive_stereo {

/// One published disparity with truth, and its observables.
struct VarianceSample {
  float error_px;
  float disparity_px;
  float ambiguity;      ///< 0..1; only where measured
  float innovation_px;  ///< |measured - predicted|; only where both exist
  float disagreement;   ///< see measureDisagreement
  float row_offset_px;  ///< of the frame, see RowOffsetModel::rms_offset_px
  bool measured, predicted;
};

/// Fits the parameters of the published variance by quantile regression: sigma and 2 sigma are as
/// close as possible to the 68.3 and 95.4 % quantiles of the absolute error. First for measured
/// disparities, with and without a prediction, then for kept predictions and for filled holes. Each
/// set of samples (a drive, a scene) has the same weight. Kinds with fewer than 200 samples, and
/// parameters that no sample depends on, keep the values of `start`.
VarianceParams fitVariance(const std::vector<std::vector<VarianceSample>>& sets,
                           const VarianceParams& start);

}  // namespace predictive_stereo
