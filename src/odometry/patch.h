/// Sub-pixel alignment of small patches: inverse-compositional Lucas-Kanade with a gain and an
/// offset of brightness.
#pragma once

#include <opencv2/core.hpp>

#include "odometry/patch_kernel.h"

namespace predictive_stereo {

/// A square patch of an image, ready to be found again in another one.
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

  /// Asks for the memory around `centre` ahead of time.
  static void prefetch(const cv::Mat1b& image, cv::Point2f centre);

  /// Samples the patch around `centre`; the patch then covers kSize * `scale` pixels of `image`, so
  /// that it looks like the same surface in an image where it appears 1 / scale times as large.
  /// False where it leaves the image or has no texture in some direction.
  bool sample(const cv::Mat1b& image, cv::Point2f centre, float scale = 1);

  /// Finds the patch near `start`. Has converged with a step below `stop_px`, after which the error
  /// is far smaller.
  Match align(const cv::Mat1b& image, cv::Point2f start, int max_iterations,
              float stop_px = 0.015f) const;

  /// Given that the true row differs from the one found by `row_error_px` (found - true): what has
  /// to be subtracted from the column found. On oblique edges the two errors go together.
  float columnErrorFromRowError(float row_error_px) const;

  /// Variance of a found column where the row is known, for image noise of one grey value [px^2].
  float columnVariance() const { return 1 / moments_.xx; }

  /// Inverse of the summed products of gradients, per squared grey value, [px^2]: the covariance of
  /// a found position for image noise of one grey value.
  const cv::Matx22f& covariance() const { return inverse_; }

 private:
  const PatchKernel* kernel_;
  PatchImages images_;
  PatchMoments moments_;
  float texture_norm_;
  cv::Matx22f inverse_;
};

}  // namespace predictive_stereo
