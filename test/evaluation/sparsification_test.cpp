#include "evaluation/sparsification.h"

#include <gtest/gtest.h>

#include <vector>

namespace predictive_stereo {
namespace {

Sparsification sparsificationOf(const std::vector<double>& errors_px,
                                const std::vector<double>& doubts) {
  Sparsification pixels;
  for (size_t i = 0; i < errors_px.size(); ++i) pixels.add(errors_px[i], doubts[i]);
  return pixels;
}

TEST(Sparsification, RightOrderIsTheOracles) {
  const Sparsification pixels = sparsificationOf({3, -1, 0, 8}, {0.3, 0.2, 0.1, 9});
  EXPECT_DOUBLE_EQ(pixels.meanError_px(), 3);
  EXPECT_NEAR(pixels.ause_px(), 0, 1e-12);
}

// Means of the first ones: oracle 0, 2; the other way round 4, 2.
TEST(Sparsification, IsTheAreaBetweenTheCurves) {
  EXPECT_NEAR(sparsificationOf({4, 0}, {1, 2}).ause_px(), 2, 1e-12);
  EXPECT_NEAR(sparsificationOf({4, 0}, {1, 1}).ause_px(), 1, 1e-12);
  EXPECT_NEAR(sparsificationOf({4, 0}, {1, 2}).auseOfNothing_px(), 1, 1e-12);
}

TEST(Sparsification, PoolsPixelsAndHasNoneAtFirst) {
  Sparsification all = sparsificationOf({4}, {1});
  all += sparsificationOf({0}, {2});
  EXPECT_NEAR(all.ause_px(), 2, 1e-12);
  EXPECT_TRUE(Sparsification().empty());
  EXPECT_EQ(Sparsification().ause_px(), 0);
  EXPECT_EQ(Sparsification().auseOfNothing_px(), 0);
}

}  // namespace
}  // namespace predictive_stereo
