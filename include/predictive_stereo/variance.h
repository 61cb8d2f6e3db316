/// How far a disparity can be trusted.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

/// Standard deviations of disparities [px], by how they came about. The defaults are what
/// estimate_noise found on KITTI and the synthetic street (config/noise_kitti.yaml).
///
/// A match has sigma_match = sigma_floor + sigma_ambiguous t^2, where t grows from 0 to 1 as its
/// ambiguity (lowest over second lowest aggregated cost) goes from `ambiguity_onset` to 1. What is
/// published has a variance of its own. The filter's p is not used for it: p counts the errors of
/// successive matches as independent, which they are not. What does tell is the innovation; whether
/// the surroundings continue the surface, see countDisagreements; how far it is: of far surfaces
/// one census window holds several, in every frame; and how badly the pair is rectified: row
/// offsets are measured and undone, but where rows are off columns are off as well, which changes
/// disparities and which nothing undoes.
struct VarianceParams {
  double sigma_floor_px = 0.15;
  double sigma_ambiguous_px = 0.84;
  double ambiguity_onset = 0.49;
  double innovation_weight = 0.2;  ///< share of the squared innovation that adds to the variance
  double max_innovation_px = 4.0;  ///< a larger innovation counts as this one
  double sigma_unpredicted_px = 0.64;   ///< adds to a match that nothing was predicted for
  double sigma_kept_px = 0.91;          ///< of a prediction that was not measured
  double sigma_filled_px = 1.5;         ///< of filled holes
  double sigma_disagreement_px = 1.5;   ///< adds for each disagreement around
  double sigma_far_px = 0.68;           ///< adds at disparity 0, half of it at 10 px, a third at 20
  double sigma_per_row_offset = 0.013;  ///< adds this times the row offset [px] times the disparity
  double max_sigma_px = 0.0;  ///< disparities less certain than this are not published; 0: all are

  template <class Visitor>
  void visit(Visitor&& v) {
    v("sigma_floor_px", sigma_floor_px, 0.01, 10.0);
    v("sigma_ambiguous_px", sigma_ambiguous_px, 0.0, 100.0);
    v("ambiguity_onset", ambiguity_onset, 0.0, 0.99);
    v("innovation_weight", innovation_weight, 0.0, 1.0);
    v("max_innovation_px", max_innovation_px, 0.0, 256.0);
    v("sigma_unpredicted_px", sigma_unpredicted_px, 0.0, 100.0);
    v("sigma_kept_px", sigma_kept_px, 0.01, 100.0);
    v("sigma_filled_px", sigma_filled_px, 0.01, 100.0);
    v("sigma_disagreement_px", sigma_disagreement_px, 0.0, 100.0);
    v("sigma_far_px", sigma_far_px, 0.0, 100.0);
    v("sigma_per_row_offset", sigma_per_row_offset, 0.0, 1.0);
    v("max_sigma_px", max_sigma_px, 0.0, 1000.0);
  }
};

/// Variance [px^2] of each measured disparity from the shape of its aggregated cost; 0 where
/// nothing was measured. What frames have in common is not in it: distance and rectification.
void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2);

/// The disparity at which VarianceParams::sigma_far_px has fallen to half: at d it adds
/// sigma_far_px / (1 + d / kFarDisparityPx), and all of it where d is negative.
constexpr float kFarDisparityPx = 10.0f;

/// How many of the eight pixels around each one, 4 rows or columns or both away (at the border:
/// nearer), do not continue its surface: 0..8. Those do that differ by at most 2.5 px, or that lie
/// on one plane with the pixel and their opposite within 1 px. Unknown pixels do not. Of no meaning
/// where the pixel itself is invalid.
void countDisagreements(const cv::Mat1f& disparity_px, const DisparityRange& range,
                        cv::Mat1b& count);

/// The disparities that are certain enough to be published (params.max_sigma_px) and their variance
/// [px^2], 0 where unknown.
/// @param row_offset_px  root mean square over the image, see RowOffsetModel.
/// @throws std::invalid_argument where disparity_px and published_px are the same memory.
void publish(const cv::Mat1f& disparity_px, const DisparityState& state,
             const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const cv::Mat1f& measured_variance_px2, double row_offset_px,
             const DisparityRange& range, const VarianceParams& params, cv::Mat1f& published_px,
             cv::Mat1f& variance_px2);

}  // namespace predictive_stereo
