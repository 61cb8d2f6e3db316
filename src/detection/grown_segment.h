#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/scratch.h"

namespace predictive_stereo {

struct GrowingWork {
  Scratch<uchar> open, grown;
  Scratch<int> labels;
  std::vector<int> common;
};

/// Lets a segment grow over the part of the layer that it lies in, as far as depth edges and what
/// the static world explains better: motion shows where there is texture, disparity shows where
/// the surface ends. Unless the part holds more that contradicts than a moving surface has, as then
/// it goes on as something that stands still.
/// @param layer  255 in the object's disparity layer.
/// @param support  how much better than the static world the object's motion explains each cell.
/// @param smooth  its mean over 5x5 cells.
/// @param least_smooth  cells with less are refuted.
/// @param decisive  of `support`, to count.
/// @param[in,out] mask  255 in the segment, 0 elsewhere; of the layer's size.
/// @return whether it has grown.
bool growOverLayer(const cv::Mat1b& layer, const cv::Mat1f& support, const cv::Mat1f& smooth,
                   float least_smooth, float decisive, cv::Mat1b& mask, GrowingWork& work);

}  // namespace predictive_stereo
