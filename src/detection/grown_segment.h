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

/// Grows a segment over its connected part of the layer, up to depth edges and to cells that a
/// static world explains better. Motion is only visible in texture; the disparity shows where the
/// surface ends. The segment does not grow if too many cells there contradict the motion: the
/// surface then continues as a static one.
/// @param layer  255 in the object's disparity layer.
/// @param support  how much better the object's motion explains each cell than a static world does.
/// @param smooth  mean of `support` over 5x5 cells.
/// @param least_smooth  cells with less are refuted.
/// @param decisive  cells with a larger |support| count.
/// @param[in,out] mask  255 in the segment, 0 elsewhere; of the layer's size.
void growOverLayer(const cv::Mat1b& layer, const cv::Mat1f& support, const cv::Mat1f& smooth,
                   float least_smooth, float decisive, cv::Mat1b& mask, GrowingWork& work);

}  // namespace predictive_stereo
