#include "imaging/image_pyramid.h"

#include <opencv2/imgproc.hpp>

namespace predictive_stereo {

void ImagePyramid::build(const cv::Mat1b& image, int levels) {
  levels_.resize(levels);
  image.copyTo(levels_[0]);
  buildUpper();
}

void ImagePyramid::buildOn(const cv::Mat1b& image, int levels) {
  levels_.resize(levels);
  levels_[0] = image;
  buildUpper();
}

void ImagePyramid::buildUpper() {
  for (int k = 1; k < levels(); ++k) cv::pyrDown(levels_[k - 1], levels_[k]);
}

}  // namespace predictive_stereo
