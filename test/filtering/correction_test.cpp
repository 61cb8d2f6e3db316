#include "predictive_stereo/correction.h"

#include <gtest/gtest.h>

namespace predictive_stereo {
namespace {

const DisparityRange kRange{0, 128};
const float kNoise = static_cast<float>(CorrectionParams().measurement_noise_px2);

struct Pixel {
  Prediction prediction;
  cv::Mat1f measured_px = cv::Mat1f(1, 1, kRange.invalid());
  DisparityState state;

  Pixel() { Predictor(kRange, PredictionParams()).predictNothing({1, 1}, prediction); }
  void predict(float disparity_px, float variance_px2, int missed_frames = 0) {
    prediction.disparity_px = disparity_px;
    prediction.variance_px2 = variance_px2;
    prediction.missed_frames = static_cast<uchar>(missed_frames);
  }
  void correctBy(const CorrectionParams& params) {
    correct(prediction, measured_px, kRange, params, state);
  }
  float disparity() const { return state.disparity_px(0); }
  float variance() const { return state.variance_px2(0); }
  int missed() const { return state.missed_frames(0); }
};

TEST(Correction, FusesByEquations5And6) {
  CorrectionParams params;
  Pixel pixel;
  pixel.predict(20.0f, 0.6f, 2);
  pixel.measured_px = 20.5f;
  pixel.correctBy(params);
  const double gain = 0.6 / (0.6 + params.measurement_noise_px2);
  EXPECT_NEAR(pixel.disparity(), 20.0 + gain * 0.5, 1e-5);
  EXPECT_NEAR(pixel.variance(),
              (1 - gain) * (1 - gain) * 0.6 + gain * gain * params.measurement_noise_px2, 1e-6);
  EXPECT_EQ(pixel.missed(), 0);
}

TEST(Correction, InnovationBeyondTheGateStartsAnew) {
  CorrectionParams params;
  const float gate = 3.0f * std::sqrt(0.6f + static_cast<float>(params.measurement_noise_px2));
  for (const float factor : {0.99f, 1.01f}) {
    Pixel pixel;
    pixel.predict(20.0f, 0.6f);
    pixel.measured_px = 20.0f + factor * gate;
    pixel.correctBy(params);
    const bool reset = factor > 1;
    EXPECT_EQ(pixel.disparity() == pixel.measured_px(0), reset);
    if (reset) {
      EXPECT_FLOAT_EQ(pixel.variance(), kNoise);
    }
  }
}

TEST(Correction, GateZeroNeverResets) {
  CorrectionParams params;
  params.gate_sigma = 0;
  Pixel pixel;
  pixel.predict(20.0f, kNoise);
  pixel.measured_px = 100.0f;
  pixel.correctBy(params);
  EXPECT_FLOAT_EQ(pixel.disparity(), 60.0f);
}

TEST(Correction, MeasurementAloneStartsTheFilter) {
  Pixel pixel;
  pixel.measured_px = 33.25f;
  pixel.correctBy(CorrectionParams());
  EXPECT_EQ(pixel.disparity(), 33.25f);
  EXPECT_FLOAT_EQ(pixel.variance(), kNoise);
}

TEST(Correction, PredictionLivesOnForSomeFramesOnly) {
  CorrectionParams params;
  for (int missed = 0; missed < 5; ++missed) {
    Pixel pixel;
    pixel.predict(20.0f, 0.6f, missed);
    pixel.correctBy(params);
    const bool alive = missed < params.max_missed_frames;
    EXPECT_EQ(pixel.disparity(), alive ? 20.0f : kRange.invalid());
    EXPECT_EQ(pixel.variance(), alive ? 0.6f : 0.0f);
    EXPECT_EQ(pixel.missed(), alive ? missed + 1 : 0);
  }
}

TEST(Correction, ResetVarianceMeansThatTheMeasurementIsTaken) {
  Pixel pixel;
  pixel.predict(20.0f, 128.0f * 128 / 12);
  pixel.measured_px = 70.0f;
  pixel.correctBy(CorrectionParams());
  EXPECT_NEAR(pixel.disparity(), 70.0f, 0.02);
  EXPECT_NEAR(pixel.variance(), kNoise, 0.001);
}

TEST(Correction, NothingKnownStaysUnknown) {
  Pixel pixel;
  pixel.correctBy(CorrectionParams());
  EXPECT_EQ(pixel.disparity(), kRange.invalid());
  EXPECT_EQ(pixel.variance(), 0.0f);
}

// A row whose background is measured at 10 px, except for the columns of a hole.
struct KeptRow {
  static constexpr int kWidth = 60;
  cv::Mat1f measured_px = cv::Mat1f(1, kWidth, 10.0f);
  Prediction prediction;
  DisparityState state;

  KeptRow(cv::Range hole, float predicted_px) {
    Predictor(kRange, PredictionParams()).predictNothing({kWidth, 1}, prediction);
    measured_px.colRange(hole).setTo(kRange.invalid());
    prediction.disparity_px.colRange(hole).setTo(predicted_px);
    prediction.variance_px2.colRange(hole).setTo(0.5f);
  }
  int keptWithin(cv::Range columns) {
    correct(prediction, measured_px, kRange, CorrectionParams(), state);
    dropRefuted(measured_px, kRange, state);
    return cv::countNonZero(state.disparity_px.colRange(columns) >= 0.0f);
  }
};

TEST(Correction, WhatTheRightCameraSeesThroughIsDropped) {
  // A surface at 20 px in columns 40..45 would cover the right image's columns 20..25, where
  // columns 30..35 of the left image are matched at 10 px.
  const cv::Range hole(40, 46);
  KeptRow refuted(hole, 20.0f);
  EXPECT_EQ(refuted.keptWithin(hole), 0);
  EXPECT_EQ(cv::countNonZero(refuted.state.variance_px2.colRange(hole)), 0);
  EXPECT_EQ(cv::countNonZero(refuted.state.missed_frames.colRange(hole)), 0);
  EXPECT_EQ(cv::countNonZero(refuted.state.disparity_px == 10.0f), KeptRow::kWidth - 6);
}

TEST(Correction, WhatTheRightCameraDoesNotRefuteIsKept) {
  const cv::Range hole(40, 46);
  // Not farther by more than the step.
  EXPECT_EQ(KeptRow(hole, 13.0f).keptWithin(hole), 6);
  // Nothing is matched on its line of sight.
  KeptRow unseen(hole, 20.0f);
  unseen.measured_px.colRange(28, 38).setTo(kRange.invalid());
  EXPECT_EQ(unseen.keptWithin(hole), 6);
  // Farther than what is matched there: hidden.
  EXPECT_EQ(KeptRow(hole, 4.0f).keptWithin(hole), 6);
  // Outside of the right image.
  EXPECT_EQ(KeptRow({4, 10}, 20.0f).keptWithin({4, 10}), 6);
}

}  // namespace
}  // namespace predictive_stereo
