#pragma once

#include <opencv2/imgproc.hpp>
#include <vector>

namespace predictive_stereo {

/// An image pyramid: pixel (x, y) of level k + 1 is at (2 x, 2 y) of level k.
class ImagePyramid {
 public:
  /// Copies `image`; buffers are reused while the size stays.
  void build(const cv::Mat1b& image, int levels) {
    levels_.resize(levels);
    image.copyTo(levels_[0]);
    buildUpper();
  }
  /// Does not copy `image`: it must stay unchanged while the pyramid is in use.
  void buildOn(const cv::Mat1b& image, int levels) {
    levels_.resize(levels);
    levels_[0] = image;
    buildUpper();
  }

  int levels() const { return static_cast<int>(levels_.size()); }
  const cv::Mat1b& level(int k) const { return levels_[k]; }
  bool empty() const { return levels_.empty(); }

 private:
  void buildUpper() {
    for (int k = 1; k < levels(); ++k) cv::pyrDown(levels_[k - 1], levels_[k]);
  }

  std::vector<cv::Mat1b> levels_;
};

}  // namespace predictive_stereo
