#include "predictive_stereo/correction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "every_target.h"

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

TEST(Correction, WhatOneFrameAloneHasSeenIsNotKept) {
  CorrectionParams params;
  const auto isKept = [&](float predicted_px, float variance_px2) {
    params.max_missed_frames = 3;
    Pixel pixel;
    if (predicted_px > 0) pixel.predict(predicted_px, variance_px2);
    pixel.measured_px = 20.0f;
    pixel.correctBy(params);
    pixel.predict(20.0f, kNoise, pixel.missed());
    pixel.measured_px = kRange.invalid();
    params.max_missed_frames = 10;  // set between the frames
    pixel.correctBy(params);
    return pixel.disparity() == 20.0f;
  };
  EXPECT_FALSE(isKept(-1.0f, 0.0f));               // no prediction
  EXPECT_FALSE(isKept(40.0f, 0.6f));               // a different prediction
  EXPECT_FALSE(isKept(40.0f, 128.0f * 128 / 12));  // ... near a discontinuity
  EXPECT_TRUE(isKept(20.5f, 0.6f));                // two frames agree
  EXPECT_TRUE(isKept(20.5f, 128.0f * 128 / 12));
}

TEST(Correction, ResetVarianceMeansThatTheMeasurementIsTaken) {
  Pixel pixel;
  pixel.predict(20.0f, 128.0f * 128 / 12);
  pixel.measured_px = 70.0f;
  pixel.correctBy(CorrectionParams());
  EXPECT_NEAR(pixel.disparity(), 70.0f, 0.02);
  EXPECT_NEAR(pixel.variance(), kNoise, 0.001);
}

TEST(Correction, WhatMovesByItselfIsNeitherFilteredNorKept) {
  CorrectionParams params;
  params.max_missed_frames = 16;
  Pixel pixel;
  pixel.predict(20.0f, 0.6f, kMovesByItself);
  pixel.measured_px = 20.5f;
  pixel.correctBy(params);
  EXPECT_FLOAT_EQ(pixel.disparity(), 20.5f);
  EXPECT_FLOAT_EQ(pixel.variance(), kNoise);
  EXPECT_EQ(pixel.missed(), kSeenOnce);
  pixel.measured_px = kRange.invalid();
  pixel.correctBy(params);
  EXPECT_EQ(pixel.disparity(), kRange.invalid());
  EXPECT_EQ(pixel.variance(), 0);
  EXPECT_EQ(pixel.missed(), 0);
}

TEST(Correction, NothingKnownStaysUnknown) {
  Pixel pixel;
  pixel.correctBy(CorrectionParams());
  EXPECT_EQ(pixel.disparity(), kRange.invalid());
  EXPECT_EQ(pixel.variance(), 0.0f);
}

// A row with a background at 10 px, and a hole in the measurement.
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
    return cv::countNonZero(state.disparity_px.colRange(columns) >= 0.0f);
  }
};

TEST(Correction, WhatTheRightCameraSeesThroughIsDropped) {
  // A surface at 20 px in columns 40..45 would occlude columns 20..25 of the right image, to which
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
  // The matched surface is not farther by more than the step.
  EXPECT_EQ(KeptRow(hole, 13.0f).keptWithin(hole), 6);
  // No match on its line of sight.
  KeptRow unseen(hole, 20.0f);
  unseen.measured_px.colRange(28, 38).setTo(kRange.invalid());
  EXPECT_EQ(unseen.keptWithin(hole), 6);
  // Behind the matched surface: occluded.
  EXPECT_EQ(KeptRow(hole, 4.0f).keptWithin(hole), 6);
  // The match beside its line of sight is outside the right image, one column to the left.
  KeptRow beside({21, 22}, 20.0f);
  beside.measured_px.colRange(10, 13).setTo(kRange.invalid());
  EXPECT_EQ(beside.keptWithin({21, 22}), 1);
  // Outside the right image.
  EXPECT_EQ(KeptRow({4, 10}, 20.0f).keptWithin({4, 10}), 6);
}

// Surfaces at several depths, with holes.
cv::Mat1f surfaces(cv::Size size, cv::RNG& rng) {
  cv::Mat1f disparity_px(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0, end = 0, d = 0; x < size.width; ++x) {
      if (x == end) end += rng.uniform(1, 25), d = rng.uniform(kRange.min_disparity, 60);
      const bool hole = rng.uniform(0, 8) == 0;
      disparity_px(y, x) =
          hole ? kRange.invalid() : static_cast<float>(d) + rng.uniform(0, 16) / 16.0f;
    }
  return disparity_px;
}

// Whether all surfaces matched on the right camera's line of sight are farther.
bool seesThrough(const float* measured_px, int width, int x, float kept_px, float offset_px) {
  const auto columnOf = [&](int column, float disparity_px) {
    return static_cast<int>(std::floor(column - offset_px - disparity_px + 0.5f));
  };
  const int column = columnOf(x, kept_px);
  if (column < 1 || column >= width - 1) return false;
  float nearest = kRange.invalid();
  for (int other = 0; other < width; ++other) {
    const float d = measured_px[other];
    const int seen = columnOf(other, d);
    if (kRange.isValid(d) && std::abs(seen - column) <= 1) nearest = std::max(nearest, d);
  }
  return kRange.isValid(nearest) && nearest < kept_px - 3;
}

TEST(Correction, IsTheNaiveOneOnEveryTarget) {
  CorrectionParams params;
  for (const int width : {1, 2, 3, 15, 64, 301}) {
    cv::RNG rng(width);
    const cv::Size size(width, 90);
    const cv::Mat1f measured_px = surfaces(size, rng);
    Prediction prediction;
    Predictor(kRange, PredictionParams()).predictNothing(size, prediction);
    prediction.disparity_px = surfaces(size, rng);
    // Some pixels agree well, some less, some not at all.
    for (int i = 0; i < size.area(); i += 3)
      prediction.disparity_px(i / width, i % width) =
          std::max(measured_px(i / width, i % width) + rng.uniform(-4.0f, 4.0f), 0.0f);
    rng.fill(prediction.variance_px2, cv::RNG::UNIFORM, 0.1f, 2.0f);
    prediction.variance_px2.setTo(0, prediction.disparity_px < 0);
    rng.fill(prediction.missed_frames, cv::RNG::UNIFORM, 0, 5);
    prediction.missed_frames.setTo(kMovesByItself, prediction.missed_frames == 4);
    forEveryTarget([&] {
      for (const float offset_px : {0.0f, -30.0f, 12.25f}) {
        DisparityState state;
        correct(prediction, measured_px, kRange, params, state, offset_px);
        int dropped = 0, fused = 0;
        for (int y = 0; y < size.height; ++y)
          for (int x = 0; x < width; ++x) {
            const float predicted = prediction.disparity_px(y, x);
            const float p = prediction.variance_px2(y, x);
            const int missed = prediction.missed_frames(y, x);
            if (kRange.isValid(measured_px(y, x))) {
              const float innovation = measured_px(y, x) - predicted;
              const bool agree = kRange.isValid(predicted) && missed != kMovesByItself &&
                                 innovation * innovation <= 9.0f * (p + kNoise);
              const float gain = p / (p + kNoise), rest = 1 - gain;
              ASSERT_EQ(state.disparity_px(y, x),
                        agree ? predicted + gain * innovation : measured_px(y, x));
              ASSERT_EQ(state.variance_px2(y, x),
                        agree ? rest * rest * p + gain * gain * kNoise : kNoise);
              const bool confirmed =
                  agree && innovation * innovation <= 9.0f * (std::min(p, kNoise) + kNoise);
              ASSERT_EQ(state.missed_frames(y, x), confirmed ? 0 : kSeenOnce);
              fused += agree;
              continue;
            }
            const bool alive = kRange.isValid(predicted) && missed < params.max_missed_frames;
            const bool refuted =
                alive && seesThrough(measured_px[y], width, x, predicted, offset_px);
            const bool kept = alive && !refuted;
            dropped += refuted;
            ASSERT_EQ(state.disparity_px(y, x), kept ? predicted : kRange.invalid()) << width << x;
            ASSERT_EQ(state.variance_px2(y, x), kept ? p : 0.0f);
            ASSERT_EQ(state.missed_frames(y, x), kept ? missed + 1 : 0);
          }
        if (width > 60) {
          EXPECT_GT(dropped, 10);
          EXPECT_GT(fused, 100);
        }
      }
    });
  }
}

}  // namespace
}  // namespace predictive_stereo
