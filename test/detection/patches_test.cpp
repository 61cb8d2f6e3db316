/// Differences of patches are those of the formula.
#include "detection/patches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

using Brightness = GreyPatch::Brightness;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

cv::Mat1b texture(uint64_t seed, cv::Size size = {40, 30}) {
  cv::Mat1b image(size);
  cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {5, 5}, 1);
  return image;
}

double greyAt(const cv::Mat1b& image, double x, double y) {
  const int u = int(std::floor(x)), v = int(std::floor(y));
  double grey = 0;
  for (int t = 0; t < 2; ++t)
    for (int s = 0; s < 2; ++s)
      grey += (1 - std::abs(x - u - s)) * (1 - std::abs(y - v - t)) * image(v + t, u + s);
  return grey;
}

// Mean of (difference - mean difference)^2 / (8 + |gradient|^2 / 2).
double naiveDifference(const cv::Mat1b& image, int u, int v, const cv::Mat1b& other, double x,
                       double y, double scale, Brightness brightness) {
  double mean = 0, sum = 0;
  for (int t = -2; t <= 2; ++t)
    for (int s = -2; s <= 2; ++s)
      mean += (image(v + t, u + s) - greyAt(other, x + scale * s, y + scale * t)) / 25;
  if (brightness == Brightness::kSame) mean = 0;
  for (int t = -2; t <= 2; ++t)
    for (int s = -2; s <= 2; ++s) {
      const double in_x = (image(v + t, u + s + 1) - image(v + t, u + s - 1)) / 2.0;
      const double in_y = (image(v + t + 1, u + s) - image(v + t - 1, u + s)) / 2.0;
      const double difference =
          image(v + t, u + s) - greyAt(other, x + scale * s, y + scale * t) - mean;
      sum += difference * difference / (8 + (in_x * in_x + in_y * in_y) / 2);
    }
  return sum / 25;
}

TEST(PatchDifference, IsNoneBetweenEqualPatches) {
  const cv::Mat1b image = texture(1);
  EXPECT_EQ(GreyPatch(image, 17, 12).differenceFrom(image, 17, 12, 1), 0);
  cv::Mat1b shifted(image.size(), uchar(0));
  image(cv::Rect(0, 0, 33, 25)).copyTo(shifted(cv::Rect(7, 5, 33, 25)));
  EXPECT_EQ(GreyPatch(image, 17, 12).differenceFrom(shifted, 24, 17, 1), 0);
  EXPECT_GT(GreyPatch(image, 17, 12).differenceFrom(shifted, 17, 12, 1), 1);
  // Each second pixel of a patch that is twice as large.
  cv::Mat1b twice;
  cv::resize(image, twice, {}, 2, 2, cv::INTER_NEAREST);
  EXPECT_EQ(GreyPatch(image, 17, 12).differenceFrom(twice, 34, 24, 2), 0);
}

TEST(PatchDifference, IsThatOfTheFormula) {
  const cv::Mat1b image = texture(1), other = texture(2);
  cv::RNG random(3);
  for (int k = 0; k < 200; ++k) {
    const float centre_x = random.uniform(3.0f, 36.0f), centre_y = random.uniform(3.0f, 26.0f);
    const float scale = random.uniform(0.3f, 2.0f);
    const float x = random.uniform(2 * scale, 38.9f - 2 * scale);
    const float y = random.uniform(2 * scale, 28.9f - 2 * scale);
    for (const auto brightness : {Brightness::kSame, Brightness::kMayDiffer}) {
      const double expected = naiveDifference(image, cvRound(centre_x), cvRound(centre_y), other, x,
                                              y, scale, brightness);
      EXPECT_NEAR(
          GreyPatch(image, centre_x, centre_y).differenceFrom(other, x, y, scale, brightness),
          expected, 1e-4 * expected + 1e-5);
    }
  }
}

// Noise of 2 grey levels in each image. It also makes gradients, which count as texture.
TEST(PatchDifference, OfNoiseIsAboutOne) {
  cv::RNG random(4);
  cv::Mat1b image(200, 200), other(200, 200);
  for (cv::Mat1b* noisy : {&image, &other})
    for (uchar& grey : *noisy) grey = cv::saturate_cast<uchar>(100 + random.gaussian(2));
  double sum = 0;
  for (int k = 0; k < 1000; ++k) {
    const auto x = float(5 + 6 * (k % 32)), y = float(5 + 6 * (k / 32));
    sum += GreyPatch(image, x, y).differenceFrom(other, x, y, 1);
  }
  EXPECT_NEAR(sum / 1000, 0.85, 0.05);
}

TEST(PatchDifference, IsInfiniteWhereAPatchLeavesItsImage) {
  const cv::Mat1b image = texture(1);  // 40 x 30
  // The patch and its gradients.
  for (const cv::Point2f inside : {cv::Point2f(3, 3), {36, 3}, {3, 26}, {36, 26}})
    EXPECT_LT(GreyPatch(image, inside.x, inside.y).differenceFrom(image, 20, 15, 1), kInfinity);
  for (const cv::Point2f outside : {cv::Point2f(2, 15), {37, 15}, {20, 2}, {20, 27}, {-50, 15}})
    EXPECT_EQ(GreyPatch(image, outside.x, outside.y).differenceFrom(image, 20, 15, 1), kInfinity);
  // The compared patch.
  const GreyPatch patch(image, 20, 15);
  for (const cv::Point2f inside : {cv::Point2f(2, 2), {36.9f, 2}, {2, 26.9f}, {36.9f, 26.9f}})
    EXPECT_LT(patch.differenceFrom(image, inside.x, inside.y, 1), kInfinity) << inside;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const cv::Point2f outside :
       {cv::Point2f(1.9f, 15), {37, 15}, {20, 1.9f}, {20, 27}, {nan, 15}, {1e9f, 15}})
    EXPECT_EQ(patch.differenceFrom(image, outside.x, outside.y, 1), kInfinity) << outside;
  EXPECT_LT(patch.differenceFrom(image, 4, 15, 2), kInfinity);
  EXPECT_EQ(patch.differenceFrom(image, 3.9f, 15, 2), kInfinity) << "a larger one";
}

}  // namespace
}  // namespace predictive_stereo
