/// Metrics of disparities as in KITTI: an outlier has an error of more than 3 px and 5 %.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "evaluation/statistics.h"
#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Value of pixels without truth in truth maps. Other negative values mean the same.
constexpr float kNoTruth = -1.0f;

inline bool hasTruth(float truth_px) { return truth_px >= 0.0f; }

/// Whether the error is more than 3 px and more than 5 % of the truth.
bool isOutlier(float disparity_px, float truth_px);

/// Counts over the pixels of one frame that have truth.
struct DisparityScore {
  int64_t truth_pixels = 0;
  int64_t valid_pixels = 0;
  int64_t outliers = 0;  ///< among valid pixels
  double sum_squared_inlier_error_px2 = 0;

  /// Outliers and pixels without a disparity.
  int64_t wrong() const { return outliers + truth_pixels - valid_pixels; }
  double density_percent() const;
  /// Outliers among valid pixels.
  double d1_percent() const;
  /// Outliers among all pixels, where those without a disparity count as outliers.
  double d1_filled_percent() const;
  /// Root mean square error of inliers.
  double rms_px() const;

  DisparityScore& operator+=(const DisparityScore& other);
};

/// @param truth_px  of the size of `disparity_px`; see kNoTruth.
/// @param mask  empty, or 0 on pixels that are left out.
/// @throws std::invalid_argument for maps of different sizes.
DisparityScore scoreDisparity(const cv::Mat1f& disparity_px, const DisparityRange& range,
                              const cv::Mat1f& truth_px, const cv::Mat1b& mask = {});

/// Calls `use(x, y, error_px)` for the pixels with truth and a disparity in every `step`-th row and
/// column.
template <class Use>
void forEachError(const cv::Mat1f& disparity_px, const DisparityRange& range,
                  const cv::Mat1f& truth_px, const Use& use, int step = 1) {
  for (int y = 0; y < truth_px.rows; y += step)
    for (int x = 0; x < truth_px.cols; x += step)
      if (hasTruth(truth_px(y, x)) && range.isValid(disparity_px(y, x)))
        use(x, y, static_cast<double>(disparity_px(y, x)) - truth_px(y, x));
}

/// Means over frames of each frame's figures: in KITTI frames have equal weight, not pixels.
struct MeanDisparityScore {
  int frames = 0;
  double density_percent = 0;
  double d1_percent = 0;
  double d1_filled_percent = 0;
  double rms_px = 0;

  /// Frames without truth, or without valid pixels, are left out of the means that need these.
  void add(const DisparityScore& score);

 private:
  int frames_with_valid_ = 0;
};

/// Consistency of published variances: shares of errors within multiples of their standard
/// deviation. A normal distribution has 68.3, 95.4 and 99.7 % within 1, 2 and 3.
class VarianceCalibration {
 public:
  static constexpr double kBinWidth = 0.05;
  static constexpr int kBins = 200;  ///< the last one holds all larger values

  /// @throws std::invalid_argument if the variance is not positive.
  void add(double error_px, double variance_px2);

  int64_t count() const { return sigmas_px_.count(); }
  /// Share of errors within `sigmas` standard deviations (rounded up to kBinWidth).
  double shareWithin(double sigmas) const;
  /// Mean negative log-likelihood of the normal density [nats]: smaller is better. It also rewards
  /// small variances.
  double negativeLogLikelihood() const { return ratio(sum_nll_, count()); }
  double meanSigma_px() const { return sigmas_px_.mean(); }

 private:
  Moments sigmas_px_;
  double sum_nll_ = 0;
  std::array<int64_t, kBins> histogram_{};
};

/// Which disparities a method knows to be wrong. Pixels are left out in the order of their doubt,
/// the most doubtful first. The mean error of the rest falls as fast as that of an oracle, which
/// knows the errors, if the doubt is right. The area between both curves, over the share that is
/// left out, is the sparsification error (AUSE; Ilg et al., "Uncertainty estimates and
/// multi-hypotheses networks for optical flow", ECCV 2018). Without a limit of errors, large ones
/// decide.
class Sparsification {
 public:
  /// @param doubt  of any scale; the larger, the less certain.
  void add(double error_px, double doubt);

  bool empty() const { return pixels_.empty(); }
  /// Of the absolute errors. 0 without pixels, and so are the following.
  double meanError_px() const;
  /// Area between the curves of doubt and oracle. Pixels of equal doubt have their mean error.
  double ause_px() const;
  /// The same for a doubt that knows nothing.
  double auseOfNothing_px() const;

 private:
  struct Pixel {
    float doubt, error_px;
  };
  std::vector<Pixel> pixels_;
};

}  // namespace predictive_stereo
