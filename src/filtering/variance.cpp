#include "predictive_stereo/variance.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "filtering/variance_rows.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

DisagreementRows rowsAround(const cv::Mat1f& disparity_px, int y) {
  DisagreementRows rows;
  rows.centre = disparity_px[y];
  for (int ring = 0; ring < kDisagreementRings; ++ring) {
    rows.above[ring] = disparity_px[std::max(y - kDisagreementReachPx[ring], 0)];
    rows.below[ring] =
        disparity_px[std::min(y + kDisagreementReachPx[ring], disparity_px.rows - 1)];
  }
  return rows;
}

}  // namespace

void measurementVariance(const cv::Mat1f& measured_disparity_px, const cv::Mat1b& ambiguity,
                         const DisparityRange& range, const VarianceParams& params,
                         cv::Mat1f& variance_px2) {
  MeasurementTerms terms;
  for (int i = 0; i < 256; ++i) {
    const double t =
        std::max(0.0, (i / 255.0 - params.ambiguity_onset) / (1.0 - params.ambiguity_onset));
    const double sigma_px = params.sigma_floor_px + params.sigma_ambiguous_px * t * t;
    terms.variance_by_ambiguity_px2[i] = static_cast<float>(sigma_px * sigma_px);
  }
  terms.smallest_valid = static_cast<float>(range.min_disparity);
  variance_px2.create(measured_disparity_px.size());
  parallelFor(cv::Range(0, variance_px2.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      measurementVarianceRow(measured_disparity_px[y], ambiguity[y], variance_px2.cols, terms,
                             variance_px2[y]);
  });
}

void measureDisagreement(const cv::Mat1f& disparity_px, const DisparityRange& range,
                         cv::Mat1f& disagreement) {
  disagreement.create(disparity_px.size());
  parallelFor(cv::Range(0, disagreement.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      measureDisagreementOfRow(rowsAround(disparity_px, y), disagreement.cols,
                               static_cast<float>(range.min_disparity), disagreement[y]);
  });
}

double rectificationShare(double row_offset_px) {
  if (row_offset_px == 0) return 1;
  const double squared = row_offset_px * row_offset_px;
  return squared / (squared + kHalfShareRowOffsetPx * kHalfShareRowOffsetPx);
}

void publish(const cv::Mat1f& disparity_px, const DisparityState& state,
             const Prediction& prediction, const cv::Mat1f& measured_disparity_px,
             const cv::Mat1f& measured_variance_px2, const cv::Mat1b& ambiguity,
             double row_offset_px, const DisparityRange& range, const VarianceParams& params,
             cv::Mat1f& published_px, cv::Mat1f& variance_px2) {
  published_px.create(disparity_px.size());
  variance_px2.create(disparity_px.size());
  if (published_px.datastart < disparity_px.dataend &&
      disparity_px.datastart < published_px.dataend)
    throw std::invalid_argument(
        "publish: input and output share memory; give another cv::Mat as output");
  const auto squared = [](double value) { return static_cast<float>(value * value); };
  const double share = rectificationShare(row_offset_px);
  PublishedTerms terms;
  terms.smallest_valid = static_cast<float>(range.min_disparity);
  terms.invalid = range.invalid();
  terms.unpredicted_px2 = squared(params.sigma_unpredicted_px * share);
  terms.kept_px2 = squared(params.sigma_kept_px);
  terms.filled_px2 = squared(params.sigma_filled_px);
  terms.disagreement_px = static_cast<float>(params.sigma_disagreement_px);
  terms.ambiguity_weight = static_cast<float>(params.ambiguity_weight);
  terms.unpredicted_weight = static_cast<float>(params.unpredicted_weight);
  terms.largest_innovation_px = static_cast<float>(params.max_innovation_px);
  terms.innovation_weight = static_cast<float>(params.innovation_weight);
  terms.far_px = static_cast<float>(params.sigma_far_px * share);
  terms.per_far_disparity = 1.0f / kFarDisparityPx;
  terms.per_squared_disparity = squared(params.sigma_per_row_offset * row_offset_px);
  terms.largest_variance_px2 = params.max_sigma_px > 0 ? squared(params.max_sigma_px)
                                                       : std::numeric_limits<float>::infinity();
  parallelFor(cv::Range(0, variance_px2.rows), [&](const cv::Range& part) {
    for (int y = part.start; y < part.end; ++y)
      publishRow({rowsAround(disparity_px, y), state.disparity_px[y], prediction.disparity_px[y],
                  measured_disparity_px[y], measured_variance_px2[y], ambiguity[y], published_px[y],
                  variance_px2[y]},
                 variance_px2.cols, terms);
  });
}

}  // namespace predictive_stereo
