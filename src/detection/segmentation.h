#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "detection/frame_history.h"
#include "detection/point_tracks.h"

namespace predictive_stereo {

/// The part of the image that a hypothesis explains.
struct Segment {
  cv::Rect area;         ///< lattice
  cv::Mat1b mask;        ///< 255 in the segment; of the area's size
  double explained = 0;  ///< share of decisive cells that the hypothesis explains better
  int decisive = 0;      ///< cells that one explanation fits clearly better than the other
  double dense = 0;      ///< share of cells with a dense residual of the majority's sign
};

/// The connected part of the hypothesis' disparity layer around its seeds that the object's motion
/// explains better than a static world does, with close cells that do not contradict; or a larger
/// part, see growOverLayer. None if there is no such part.
/// @param static_world  mismatch of the whole lattice, see compareFrames; empty: segment() compares
///   what it needs.
/// @param residual_px  see longResidual.
std::optional<Segment> segment(const PastView& view, const cv::Mat1f& static_world,
                               const cv::Mat1f& residual_px, const Hypothesis& hypothesis);

/// Grows a segment over its connected part of the layer, up to depth edges and to cells that a
/// static world explains better. Motion is only visible in texture; the disparity shows where the
/// surface ends. The segment does not grow if too many cells there contradict the motion: the
/// surface then continues as a static one.
/// @param layer  not 0 in the object's disparity layer.
/// @param support  how much better the object's motion explains each cell than a static world does.
/// @param smooth  mean of `support` over 5x5 cells.
/// @param min_explained  see MotionDetectionParams; for the whole box.
/// @param[in,out] mask  255 in the segment, 0 elsewhere; of the layer's size.
void growOverLayer(const cv::Mat1b& layer, const cv::Mat1f& support, const cv::Mat1f& smooth,
                   double min_explained, cv::Mat1b& mask);

}  // namespace predictive_stereo
