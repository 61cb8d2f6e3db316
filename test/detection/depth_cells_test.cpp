/// Against naive loops over the pixels.
#include "detection/depth_cells.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace predictive_stereo {
namespace {

// Random disparities [px]; unknown with this probability.
cv::Mat1f randomMap(cv::RNG& random, cv::Size size, const DisparityRange& range,
                    double unknown_share) {
  cv::Mat1f map(size);
  for (float& d : map)
    d = random.uniform(0.0, 1.0) < unknown_share
            ? range.invalid()
            : random.uniform(static_cast<float>(range.min_disparity), 60.0f);
  return map;
}

bool isKnown(const DisparityRange& range, float disparity_px) {
  return disparity_px >= static_cast<float>(range.min_disparity) && disparity_px > 0;
}

void expectNaive(const DepthCells& cells, const DisparityRange& range, const cv::Mat1f& disparity,
                 const cv::Mat1f& variance) {
  ASSERT_EQ(cells.disparity_px.size(), cv::Size(disparity.cols / 4, disparity.rows / 4));
  ASSERT_EQ(cells.variance_px2.size(), cells.disparity_px.size());
  for (int v = 0; v < disparity.rows / 4; ++v)
    for (int u = 0; u < disparity.cols / 4; ++u) {
      float d = 0, var = 0;
      for (const cv::Point place :
           {cv::Point(0, 0), {2, 0}, {0, 2}, {2, 2}}) {  // the last one wins
        const cv::Point pixel = cv::Point(4 * u, 4 * v) + place;
        if (isKnown(range, disparity(pixel))) d = disparity(pixel), var = variance(pixel);
      }
      ASSERT_EQ(cells.disparity_px(v, u), d) << u << ", " << v;
      ASSERT_EQ(cells.variance_px2(v, u), var) << u << ", " << v;
    }
  const cv::Size lattice((disparity.cols + 1) / 2, (disparity.rows + 1) / 2);
  ASSERT_EQ(cells.nearest_px.size(), lattice);
  ASSERT_EQ(cells.farthest_px.size(), lattice);
  for (int v = 0; v < lattice.height; ++v)
    for (int u = 0; u < lattice.width; ++u) {
      float largest = 0, smallest = 0;
      for (int y = 2 * v - 2; y <= 2 * v + 2; y += 2)
        for (int x = 2 * u - 2; x <= 2 * u + 2; x += 2) {
          if (x < 0 || y < 0 || x >= disparity.cols || y >= disparity.rows) continue;
          const float d = disparity(y, x);
          if (!isKnown(range, d)) continue;
          largest = std::max(largest, d);
          smallest = smallest > 0 ? std::min(smallest, d) : d;
        }
      ASSERT_EQ(cells.nearest_px(v, u), largest) << u << ", " << v;
      ASSERT_EQ(cells.farthest_px(v, u), smallest) << u << ", " << v;
    }
}

TEST(DepthCells, AreMeasuredAtTheCentreOrElsewhereInTheCell) {
  const DisparityRange range;
  cv::Mat1f disparity(8, 8, range.invalid()), variance(8, 8, 9.0f);
  const auto set = [&](int x, int y, float d, float var) {
    disparity(y, x) = d;
    variance(y, x) = var;
  };
  set(2, 2, 10, 0.1f);  // the centre of the first cell, and a corner
  set(0, 0, 20, 0.2f);
  set(6, 0, 30, 0.3f);  // only the upper edge of the second one
  set(0, 6, 40, 0.4f);  // the left edge of the third one, before its corner
  set(0, 4, 50, 0.5f);
  set(7, 7, 60, 0.6f);  // no lattice point of the fourth one
  DepthCells cells;
  cells.setFrame(range, disparity, variance);
  const cv::Mat1f expected_px = (cv::Mat1f(2, 2) << 10, 30, 40, 0);
  const cv::Mat1f expected_px2 = (cv::Mat1f(2, 2) << 0.1f, 0.3f, 0.4f, 0);
  EXPECT_EQ(cv::norm(cells.disparity_px, expected_px, cv::NORM_INF), 0) << cells.disparity_px;
  EXPECT_EQ(cv::norm(cells.variance_px2, expected_px2, cv::NORM_INF), 0) << cells.variance_px2;
}

TEST(DepthCells, AreThoseOfANaiveLoop) {
  cv::RNG random(3);
  DepthCells cells;  // its buffers are used again
  for (const cv::Size size : {cv::Size(40, 24), {37, 23}, {38, 25}, {39, 22}, {5, 5}, {4, 7}})
    for (const int min_disparity : {0, 7, -16})
      for (const double unknown_share : {0.0, 0.5, 0.9, 1.0}) {
        SCOPED_TRACE(testing::Message() << size << ", from " << min_disparity << " px, "
                                        << unknown_share << " unknown");
        const DisparityRange range{min_disparity, 128};
        const cv::Mat1f disparity = randomMap(random, size, range, unknown_share);
        cv::Mat1f variance(size);
        random.fill(variance, cv::RNG::UNIFORM, 0.01, 4);
        cells.setFrame(range, disparity, variance);
        expectNaive(cells, range, disparity, variance);
      }
}

TEST(DepthCells, KnowNothingBelowTheRangeAndAtInfinity) {
  const cv::Mat1f variance(8, 8, 0.1f);
  DepthCells cells;
  for (const auto& [min_disparity, d] : {std::pair(7, 6.0f), {7, 6.9f}, {0, 0.0f}, {-8, -3.0f}}) {
    SCOPED_TRACE(d);
    cells.setFrame({min_disparity, 64}, cv::Mat1f(8, 8, d), variance);
    for (const cv::Mat1f& map :
         {cells.disparity_px, cells.variance_px2, cells.nearest_px, cells.farthest_px})
      EXPECT_EQ(cv::countNonZero(map), 0);
  }
  cells.setFrame({7, 64}, cv::Mat1f(8, 8, 7.0f), variance);
  EXPECT_EQ(cv::countNonZero(cells.disparity_px == 7), 4);
}

}  // namespace
}  // namespace predictive_stereo
