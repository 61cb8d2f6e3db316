/// Maps of every width beside a guard page (guarded_memory.h), on every SIMD target: the filters
/// read and write nothing outside of them.
#include <gtest/gtest.h>

#include "guarded_memory.h"
#include "predictive_stereo/correction.h"
#include "predictive_stereo/photometric_residual.h"
#include "predictive_stereo/post_filter.h"
#include "predictive_stereo/region_filter.h"
#include "predictive_stereo/search_ranges.h"
#include "predictive_stereo/variance.h"

namespace predictive_stereo {
namespace {

using testing::Guard;

const DisparityRange kRange;

// Calls body(size) for every width, with one to three rows; all new maps are beside a guard page.
template <class Body>
void forEverySize(const Body& body) {
  testing::forEveryGuardAndTarget([&](Guard guard) {
    const testing::GuardEveryMat guards(guard);
    for (int width = 1; width <= testing::kMostGuarded; ++width)
      body(cv::Size(width, width % 3 + 1));
  });
}

template <class T>
cv::Mat_<T> noise(cv::Size size, double low, double high) {
  cv::Mat_<T> map(size);
  if (!map.empty()) cv::theRNG().fill(map, cv::RNG::UNIFORM, low, high);
  return map;
}
// Some of them invalid.
cv::Mat1f disparities(cv::Size size) { return noise<float>(size, -1, 6); }

DisparityState state(cv::Size size) {
  DisparityState state;
  state.disparity_px = disparities(size);
  state.variance_px2 = noise<float>(size, 0, 4);
  state.missed_frames = noise<uchar>(size, 0, 4);
  return state;
}

// Of a camera that moves ahead and to the side.
Prediction prediction(cv::Size size) {
  StereoRig rig;
  rig.size = size;
  rig.fx_px = rig.fy_px = 100;
  rig.baseline_m = 0.5;
  CameraMotion motion;
  motion.T_cam_prev.translation() << 0.2, 0, -1;
  Prediction prediction;
  Predictor(kRange, PredictionParams()).predict(state(size), rig, motion, prediction);
  return prediction;
}

TEST(BorderReads, OfPredictionAndCorrection) {
  forEverySize([](cv::Size size) {
    DisparityState corrected;
    correct(prediction(size), disparities(size), kRange, CorrectionParams(), corrected);
  });
}

TEST(BorderReads, OfSearchRanges) {
  forEverySize([](cv::Size size) {
    SearchRanges ranges;
    cv::Mat1w widths;
    SearchRangeBuilder(kRange, SearchRangeParams())
        .build(prediction(size), disparities(size / 2), ranges);
    searchWidths(ranges, widths);
  });
}

TEST(BorderReads, OfVariance) {
  forEverySize([](cv::Size size) {
    const cv::Mat1b ambiguity = noise<uchar>(size, 0, 256);
    const cv::Mat1f measured = disparities(size);
    cv::Mat1f variance, published, published_variance;
    measurementVariance(measured, ambiguity, kRange, VarianceParams(), variance);
    cv::Mat1f residual_share;
    PhotometricResidual().measure(noise<uchar>(size, 0, 256), noise<uchar>(size, 0, 256), measured,
                                  kRange, 0, residual_share);
    publish(
        disparities(size),
        {disparities(size), disparities(size), measured, variance, ambiguity, residual_share, 0.5},
        kRange, VarianceParams(), published, published_variance);
  });
}

TEST(BorderReads, OfPostFilters) {
  forEverySize([](cv::Size size) {
    cv::Mat1f filtered;
    filterBySupport(kRange, 5, disparities(size), filtered);
    median3x3(kRange, 3, disparities(size), filtered);
    leaveOutAmbiguous(kRange, disparities(size), noise<uchar>(size, 0, 256), 0.5, disparities(size),
                      filtered);
    fillHoles(kRange, 9, 3, disparities(size), filtered);
    RegionFilter().filter(kRange, 5, filtered);
  });
}

}  // namespace
}  // namespace predictive_stereo
