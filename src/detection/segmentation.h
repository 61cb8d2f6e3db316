#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_history.h"
#include "detection/hypothesis.h"
#include "detection/level_ground.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// The part of the image that a hypothesis explains.
struct Segment {
  cv::Rect area;   ///< lattice
  cv::Mat1b mask;  ///< 255 in the segment; of the area's size
  int cells = 0;
  double explained = 0;  ///< share of decisive cells that the hypothesis explains better
  int decisive = 0;      ///< cells that one explanation fits clearly better than the other
  double dense = 0;      ///< share of cells with a dense residual of the majority's sign
};

/// What the segmentation needs besides the frames.
struct SegmentationMaps {
  /// Of the whole lattice; none: segment() compares what it needs.
  const Comparison* static_world;
  const cv::Mat1f& residual_px;  ///< see longResidual
  const LevelGround& ground;
};

/// Buffers that are reused for the next hypothesis.
struct SegmentationWork {
  Comparison by_object, by_static;
  Scratch<uchar> layer, core, member, mask, open, grown;
  Scratch<float> heights, support, smooth;
  Scratch<int> labels;
  std::vector<int> common;
};

/// The connected part of the hypothesis' disparity layer around its seeds that the object's motion
/// explains better than a static world does, with close cells that do not contradict; or a larger
/// part, see growOverLayer. None if there is no such part.
std::optional<Segment> segment(const PastView& view, const SegmentationMaps& maps,
                               const Hypothesis& hypothesis, SegmentationWork& work);

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
                   float least_smooth, float decisive, cv::Mat1b& mask, SegmentationWork& work);

/// 255 on points whose disparity is within the layer and that are not ground.
/// @param disparity_px  of every pixel from the first point on: point u is pixel 2u.
/// @param farthest_px, nearest_px  both included.
/// @param below_m, lowest_m  see LevelGround: points at least `lowest_m` below the camera are
///   ground.
void layerRow(const float* disparity_px, const float* below_m, int width, float farthest_px,
              float nearest_px, float lowest_m, uint8_t* layer);

/// How much better an object's motion explains the images than a static world does: the difference
/// of mismatches, clamped to +-`most`; 0 if one of them is negative (unknown).
void supportRow(const float* by_static, const float* by_object, int width, float most,
                float* support);

}  // namespace predictive_stereo
