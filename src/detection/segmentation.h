#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detection/frame_comparison.h"
#include "detection/ground.h"
#include "detection/grown_segment.h"
#include "detection/hypothesis.h"
#include "detection/scratch.h"
#include "predictive_stereo/moving_objects.h"

namespace predictive_stereo {

/// The part of the image that a hypothesis explains.
struct Segment {
  cv::Rect area;   ///< lattice
  cv::Mat1b mask;  ///< 255 within; of the area's size
  int cells = 0;
  double explained = 0;  ///< share of decisive cells that the hypothesis explains better
  int decisive = 0;      ///< cells where the two explanations differ
  double dense = 0;      ///< share of cells with a dense residual of the majority's sign
};

/// What segmentation looks at.
struct SegmentationView {
  const StereoRig& rig;
  const DisparityRange& range;
  const ImagePyramid& current;
  const ImagePyramid& previous;
  const cv::Mat1f& disparity_px;
  const Eigen::Isometry3d& T_prev_cam;
  const Comparison& static_world;  ///< at least as far as reachOf the hypothesis
  const cv::Mat1f& residual_px;
  const LevelGround& ground;
};

/// Memory that is used again from hypothesis to hypothesis.
struct SegmentationWork {
  Comparison comparison;
  Scratch<uchar> layer, core, member, mask;
  Scratch<float> heights, support, smooth;
  Scratch<int> labels;
  GrowingWork growing;
};

/// The part of the lattice that segment() looks at: as far as the largest object may reach from
/// the seeds.
cv::Rect reachOf(const StereoRig& rig, const MotionDetectionParams& params,
                 const Hypothesis& hypothesis, cv::Size lattice);

/// The connected part of the hypothesis' disparity layer around its seeds which the object's motion
/// explains no worse than the static world: what it explains better and what lies near that, or
/// more, see growOverLayer. None where there is no such part.
std::optional<Segment> segment(const SegmentationView& view, const MotionDetectionParams& params,
                               const Hypothesis& hypothesis, SegmentationWork& work);

}  // namespace predictive_stereo
