/// Image pairs with known disparities for the tests of matching.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {

struct TestPair {
  cv::Mat1b left, right;
  cv::Mat1i
      disparity_px;  ///< of the left image, including pixels that are occluded in the right one
};

/// Smoothed noise on slanted and fronto-parallel surfaces between disparities `lowest` and
/// `highest`. The left image is sampled from the right one, so every left pixel has a corresponding
/// point, or this is outside the image.
inline TestPair makeTestPair(cv::Size size, int lowest, int highest, unsigned seed) {
  cv::RNG random(seed);
  cv::Mat1b texture(size.height, size.width + 600);
  random.fill(texture, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(texture, texture, cv::Size(3, 3), 0.7);
  TestPair pair{cv::Mat1b(size), texture(cv::Rect(300, 0, size.width, size.height)).clone(),
                cv::Mat1i(size)};
  const int span = highest - lowest;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      int disparity = lowest + span * y / (2 * size.height);
      if (x % 90 < 45 && y % 60 >= 24)
        disparity = lowest + span / 2 + (x / 90 * 7) % (span / 2 + 1);
      pair.disparity_px(y, x) = disparity;
      pair.left(y, x) = texture(y, 300 + x - disparity);
    }
  cv::Mat1b noise(size);
  random.fill(noise, cv::RNG::UNIFORM, 0, 6);
  pair.left += noise;
  return pair;
}

}  // namespace predictive_stereo
