/// Sub-pixel alignment of small patches: inverse-compositional Lucas-Kanade with a gain and an
/// offset of brightness.
#pragma once

#include <opencv2/core.hpp>

#include "imaging/patch_kernel.h"

namespace predictive_stereo {

/// A square patch of an image, prepared to be found in another one.
class Patch {
 public:
  static constexpr int kSize = kPatchSize;  ///< side [px]

  explicit Patch(const PatchKernel& kernel = patchKernelInUse()) : kernel_(&kernel) {}

  /// Where a patch was found.
  struct Match {
    cv::Point2f position;   ///< of its centre [px]
    float correlation = 0;  ///< zero-mean normalised correlation there, -1..1
    bool converged = false;
  };

  /// Prefetches the memory around `centre`.
  static void prefetch(const cv::Mat1b& image, cv::Point2f centre);

  /// Samples the patch around `centre`. It covers kSize * `scale` pixels of `image`: it then
  /// matches an image in which the same surface appears 1 / scale times as large.
  /// @returns false if the patch leaves the image, or has no texture in some direction.
  bool sample(const cv::Mat1b& image, cv::Point2f centre, float scale = 1);

  /// Finds the patch near `start`. It has converged if a step is below `stop_px`; the remaining
  /// error is then far smaller.
  Match align(const cv::Mat1b& image, cv::Point2f start, int max_iterations,
              float stop_px = 0.015f) const;

  /// Error of the found column (found - true) that a row error of `row_error_px` (found - true)
  /// causes. On oblique edges the two errors are correlated.
  float columnErrorFromRowError(float row_error_px) const;

  /// Variance [px^2] of the found column for a known row and image noise of one grey level.
  float columnVariance() const { return 1 / moments_.xx; }

  /// Covariance [px^2] of the found position for image noise of one grey level: the inverse of the
  /// summed products of gradients.
  const cv::Matx22f& covariance() const { return inverse_; }

 private:
  const PatchKernel* kernel_;
  PatchImages images_;
  PatchMoments moments_;
  float texture_norm_;
  cv::Matx22f inverse_;
};

}  // namespace predictive_stereo
