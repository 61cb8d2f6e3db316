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

}  // namespace
}  // namespace predictive_stereo
