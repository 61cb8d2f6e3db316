/// The variance of measured and published disparities.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"
#include "predictive_stereo/prediction.h"

namespace predictive_stereo {

/// Standard deviations of disparities [px] by their origin. The defaults were estimated by
/// estimate_noise on KITTI and the synthetic street (config/noise_kitti.yaml).
///
/// A match has sigma_match = sigma_floor + sigma_ambiguous t^2, where t grows from 0 to 1 as its
/// ambiguity (lowest over second lowest aggregated cost) grows from `ambiguity_onset` to 1.
///
/// A published disparity has a variance of its own, not the filter's p: p treats the errors of
/// successive matches as independent, which they are not. The published variance grows with
/// - the innovation,
/// - the number of neighbours that do not continue the surface, see countDisagreements,
/// - the distance: a census window covers several far surfaces, in every frame,
/// - the row offset of the pair: row alignment removes it, but a pair with row offsets has column
///   offsets too. These change disparities and are not removed.
struct VarianceParams {
  double sigma_floor_px = 0.15;
  double sigma_ambiguous_px = 0.84;
  double ambiguity_onset = 0.49;
  double innovation_weight = 0.2;  ///< share of the squared innovation that adds to the variance
  double max_innovation_px = 4.0;  ///< a larger innovation counts as this one
  double sigma_unpredicted_px = 0.64;  ///< added to a match without prediction
  double sigma_kept_px = 0.91;         ///< of a prediction without a measurement
  double sigma_filled_px = 1.5;        ///< of filled holes
  double sigma_disagreement_px = 1.5;  ///< added for each disagreement around the pixel
  double sigma_far_px = 0.68;          ///< added at disparity 0, half of it at 10 px, a third at 20
  double sigma_per_row_offset = 0.013;  ///< times row offset [px] times disparity [px] is added
  double max_sigma_px = 0.0;            ///< less certain disparities are not published; 0: all are

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

/// Variance [px^2] of each measured disparity from its ambiguity; 0 where nothing was measured. It
/// does not contain errors that are the same in all frames: those of distance and rectification.
/// @param ambiguity  of that match, see Match; of the disparity map's size, which is not checked.
/// @param variance_px2  output of the disparity map's size.
void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2);

/// The disparity at which the effect of VarianceParams::sigma_far_px is half: at disparity d,
/// sigma_far_px / (1 + d / kFarDisparityPx) is added, or sigma_far_px if d is negative.
constexpr float kFarDisparityPx = 10.0f;

/// For each pixel, how many of eight pixels around it do not continue its surface: 0..8. These
/// eight are 4 rows, columns, or both away (less at the image's border). A pixel continues the
/// surface if its disparity differs by at most 2.5 px, or if the pixel, its opposite and the centre
/// are on one plane within 1 px. Unknown pixels do not. The count has no meaning where the centre
/// is unknown.
/// @param count  output of the disparity map's size.
void countDisagreements(const cv::Mat1f& disparity_px, const DisparityRange& range,
                        cv::Mat1b& count);

/// Selects the disparities that are certain enough to be published (params.max_sigma_px), and gives
/// them a variance. All maps must have one size; this is not checked.
/// @param disparity_px  the filters' disparities, with holes filled and median.
/// @param state  the filters, see correct().
/// @param row_offset_px  root mean square over the image, see RowOffsetModel.
/// @param published_px, variance_px2  output; range.invalid() and 0 where nothing is published.
/// @throws std::invalid_argument if disparity_px and published_px share memory.
void publish(const cv::Mat1f& disparity_px, const DisparityState& state,
             const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const cv::Mat1f& measured_variance_px2, double row_offset_px,
             const DisparityRange& range, const VarianceParams& params, cv::Mat1f& published_px,
             cv::Mat1f& variance_px2);

}  // namespace predictive_stereo
