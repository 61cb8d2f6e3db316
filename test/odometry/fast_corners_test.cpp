#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "every_target.h"
#include "odometry/features.h"

namespace predictive_stereo {
namespace {

using Corners = std::vector<std::tuple<int, int, int>>;  // y, x, score

Corners byOpenCv(const cv::Mat1b& image, const cv::Rect& area, int threshold) {
  std::vector<cv::KeyPoint> points;
  cv::FAST(image, points, threshold, true);
  Corners corners;
  for (const cv::KeyPoint& point : points)
    if (area.contains(point.pt))
      corners.emplace_back(cvRound(point.pt.y), cvRound(point.pt.x), cvRound(point.response));
  std::sort(corners.begin(), corners.end());
  return corners;
}

Corners byUs(const cv::Mat1b& image, const cv::Rect& area, int threshold) {
  FastCorners fast;
  std::vector<FastCorner> points;
  fast.find(image, area, threshold / 2);
  fast.append(threshold, points);
  Corners corners;
  for (const FastCorner& point : points)
    corners.emplace_back(point.position.y, point.position.x, point.score);
  return corners;
}

// Coarse and fine noise, with saturated pixels at both ends of the range.
cv::Mat1b texture(cv::Size size, double blur_px, cv::RNG& rng) {
  cv::Mat1b image(size);
  rng.fill(image, cv::RNG::UNIFORM, 0, 256);
  if (blur_px > 0) {
    cv::GaussianBlur(image, image, {}, blur_px);
    cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  }
  return image;
}

TEST(CornerKernel, FindsThoseOfOpenCvOnEveryTarget) {
  cv::RNG rng(11);
  size_t found = 0;
  forEveryTarget([&] {
    for (const cv::Size size : {cv::Size(7, 7), cv::Size(8, 30), cv::Size(38, 9), cv::Size(39, 12),
                                cv::Size(70, 40), cv::Size(333, 50)})
      for (const double blur_px : {0.0, 1.0, 2.5})
        for (const int threshold : {1, 7, 20, 100}) {
          const cv::Mat1b image = texture(size, blur_px, rng);
          const cv::Rect whole({0, 0}, size),
              part(size.width / 4, size.height / 3, size.width / 2, size.height / 2);
          for (const cv::Rect& area : {whole, part}) {
            const Corners expected = byOpenCv(image, area, threshold);
            ASSERT_EQ(byUs(image, area, threshold), expected)
                << size << " " << area << " blur " << blur_px << " threshold " << threshold;
            found += expected.size();
          }
        }
  });
  EXPECT_GT(found, 1000u);
}

TEST(CornerKernel, ReadsViewsOfLargerImages) {
  cv::RNG rng(12);
  const cv::Mat1b large = texture({90, 60}, 1.0, rng);
  const cv::Mat1b view = large(cv::Rect(10, 5, 61, 41));
  const cv::Rect all(0, 0, 61, 41);
  EXPECT_EQ(byUs(view, all, 7), byOpenCv(view.clone(), all, 7));
}

TEST(CornerKernel, FindsNoneInTinyOrPlainImages) {
  EXPECT_TRUE(byUs(cv::Mat1b(6, 40, uchar{9}), {0, 0, 40, 6}, 7).empty());
  EXPECT_TRUE(byUs(cv::Mat1b(40, 6, uchar{9}), {0, 0, 6, 40}, 7).empty());
  EXPECT_TRUE(byUs(cv::Mat1b(40, 40, uchar{9}), {0, 0, 40, 40}, 0).empty());
}

}  // namespace
}  // namespace predictive_stereo
