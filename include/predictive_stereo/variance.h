/// The variance of measured and published disparities.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"

namespace predictive_stereo {

/// Standard deviations of disparities [px] by their origin, fitted to rooms, KITTI and streets
/// (docs/design_notes.md, "Prediction and variance").
///
/// A match has sigma_match = sigma_floor + sigma_ambiguous t^2, where t grows from 0 to 1 as its
/// ambiguity (lowest over second lowest aggregated cost) grows from `ambiguity_onset` to 1.
///
/// A published disparity has a variance of its own, not the filter's p: p treats the errors of
/// successive matches as independent, which they are not. The published variance grows with
/// - how much the surroundings do not continue the surface: 0..8, the sum over eight pairs of
///   opposite pixels, 4 and 9 rows, columns, or both away (near the image's border both only as far
///   as the border), of how far the pixel is from the middle of the pair: 1 if twice this distance
///   is 4 px or more, or if the pair is not known. This disagreement counts times 1 +
///   ambiguity_weight * ambiguity^2 (+ unpredicted_weight for a match without prediction), times 1
///   + residual_weight * the photometric residual's share of the contrast: where the match is
///   ambiguous as well, no past confirms it, or the images differ, it may be wrong by any amount,
/// - the row offset of the pair: row alignment removes it, but a pair with row offsets has column
///   offsets too, and lenses that are not modelled exactly. These change disparities and are not
///   removed. A missing prediction counts only as far as rectificationShare says.
/// It falls with the slope of the surface: where disparities grow downwards, as on the ground,
/// errors are smaller than on what stands upright, everywhere that we could measure.
struct VarianceParams {
  double sigma_floor_px = 0.15;
  double sigma_ambiguous_px = 0.84;
  double ambiguity_onset = 0.49;
  double sigma_unpredicted_px = 0.65;   ///< added to a match without prediction
  double sigma_filled_px = 7.6;         ///< of filled holes
  double sigma_disagreement_px = 0.16;  ///< added, times disagreement around the pixel
  double ambiguity_weight = 1.92;       ///< of the ambiguity in the effect of disagreement
  double unpredicted_weight = 0.3;      ///< of a missing prediction in the effect of disagreement
  double residual_weight = 10.9;  ///< of the photometric residual in the effect of disagreement
  double sigma_per_row_offset = 0.0195;  ///< times row offset [px] times disparity [px] is added
  /// Sigma is divided by 1 + this * (growth of disparity downwards [px per row]), if it grows.
  double slope_weight = 1.72;
  double max_sigma_px = 0.0;  ///< less certain disparities are not published; 0: all are

  template <class Visitor>
  void visit(Visitor&& v) {
    v("sigma_floor_px", sigma_floor_px, 0.01, 10.0);
    v("sigma_ambiguous_px", sigma_ambiguous_px, 0.0, 100.0);
    v("ambiguity_onset", ambiguity_onset, 0.0, 0.99);
    v("sigma_unpredicted_px", sigma_unpredicted_px, 0.0, 100.0);
    v("sigma_filled_px", sigma_filled_px, 0.01, 100.0);
    v("sigma_disagreement_px", sigma_disagreement_px, 0.0, 100.0);
    v("ambiguity_weight", ambiguity_weight, 0.0, 100.0);
    v("unpredicted_weight", unpredicted_weight, 0.0, 100.0);
    v("residual_weight", residual_weight, 0.0, 100.0);
    v("sigma_per_row_offset", sigma_per_row_offset, 0.0, 1.0);
    v("slope_weight", slope_weight, 0.0, 100.0);
    v("max_sigma_px", max_sigma_px, 0.0, 1000.0);
  }
};

/// Variance [px^2] of each measured disparity from its ambiguity; 0 where nothing was measured. It
/// does not contain errors that are the same in all frames: those of rectification.
/// @param ambiguity  of that match, see Match; of the disparity map's size, which is not checked.
/// @param variance_px2  output of the disparity map's size.
void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2);

/// Half of the errors of an imperfect rectification are counted at this row offset.
constexpr double kHalfShareRowOffsetPx = 0.15;
/// How far errors of rectification count: 0 for a perfect pair, towards 1 with its row offset; 1 at
/// an offset of 0, which means that it was not measured.
double rectificationShare(double row_offset_px);

/// What the variance of published disparities depends on.
struct DisparityEvidence {
  cv::Mat1f unfilled_px;  ///< the disparities before holes were filled
  cv::Mat1f predicted_px, measured_px, measured_variance_px2;
  cv::Mat1b ambiguity;       ///< of the match, see Match
  cv::Mat1f residual_share;  ///< see PhotometricResidual
  double row_offset_px = 0;  ///< root mean square over the image, see RowOffsetModel
};

/// Selects the disparities that are certain enough to be published (params.max_sigma_px), and gives
/// them a variance. All maps but residual_share must have one size; this is not checked.
/// @param disparity_px  the filters' disparities, with holes filled and median.
/// @param published_px, variance_px2  output; range.invalid() and 0 where nothing is published.
/// @throws std::invalid_argument if disparity_px and published_px share memory.
void publish(const cv::Mat1f& disparity_px, const DisparityEvidence& evidence,
             const DisparityRange& range, const VarianceParams& params, cv::Mat1f& published_px,
             cv::Mat1f& variance_px2);

}  // namespace predictive_stereo
