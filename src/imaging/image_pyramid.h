#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace predictive_stereo {

/// An image pyramid: pixel (x, y) of level k + 1 is at (2 x, 2 y) of level k.
class ImagePyramid {
 public:
  /// Copies `image`; buffers are reused while the size stays.
  void build(const cv::Mat1b& image, int levels);
  /// Does not copy `image`: it must stay unchanged while the pyramid is in use.
  void buildOn(const cv::Mat1b& image, int levels);

  int levels() const { return static_cast<int>(levels_.size()); }
  const cv::Mat1b& level(int k) const { return levels_[k]; }
  bool empty() const { return levels_.empty(); }

 private:
  void buildUpper();

  std::vector<cv::Mat1b> levels_;
};

}  // namespace predictive_stereo
