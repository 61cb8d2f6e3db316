#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

/// Memory for maps of changing size; it only grows.
template <class T>
class Scratch {
 public:
  /// A continuous map with undefined contents. It replaces the map of the previous call.
  cv::Mat_<T> map(cv::Size size) {
    const auto needed = static_cast<size_t>(size.area());
    if (memory_.size() < needed) memory_.resize(needed);
    return cv::Mat_<T>(size.height, size.width, memory_.data());
  }

 private:
  std::vector<T> memory_;
};

}  // namespace predictive_stereo
