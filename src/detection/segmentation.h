#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_view.h"
#include "detection/ground.h"
#include "detection/grown_segment.h"
#include "detection/hypothesis.h"
#include "detection/scratch.h"
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
  Scratch<uchar> layer, core, member, mask;
  Scratch<float> heights, support, smooth;
  Scratch<int> labels;
  GrowingWork growing;
};

/// The connected part of the hypothesis' disparity layer around its seeds that the object's motion
/// explains better than a static world does, with close cells that do not contradict; or a larger
/// part, see growOverLayer. None if there is no such part.
std::optional<Segment> segment(const PastView& view, const SegmentationMaps& maps,
                               const Hypothesis& hypothesis, SegmentationWork& work);

}  // namespace predictive_stereo
