#pragma once

#include <opencv2/core/types.hpp>
#include <stdexcept>
#include <string>

namespace predictive_stereo {

/// @throws std::invalid_argument if `size` is not `expected`: "NAME is 4x3 REFERENCE 5x3".
inline void requireSize(const std::string& name, cv::Size size, cv::Size expected,
                        const std::string& reference = "but the calibration is for") {
  if (size == expected) return;
  const auto text = [](cv::Size s) {
    return std::to_string(s.width) + "x" + std::to_string(s.height);
  };
  throw std::invalid_argument(name + " is " + text(size) + " " + reference + " " + text(expected));
}

}  // namespace predictive_stereo
