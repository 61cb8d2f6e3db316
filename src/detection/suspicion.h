/// Points that a static world does not explain.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detection/frame_history.h"
#include "detection/level_ground.h"

namespace predictive_stereo {

/// 25 |grey - mean grey over 5x5 points| of each lattice point, where texture comes from. Not
/// computed for the first and last two rows.
void greyDeviation(const cv::Mat1b& grey, cv::Mat1w& deviation);

/// Finds points whose image a static world does not explain: the mismatch of frames is large
/// relative to the texture around, which is the mean of |grey - mean grey| over 5x5 lattice points.
/// Without texture a wrong motion is not visible.
class Suspicion {
 public:
  /// Texture below this is noise.
  static constexpr float kGreyNoise = 3.0f;

  /// @param deviation  see greyDeviation; of the current image on the lattice.
  /// @param mismatch  of the whole lattice, see Comparison.
  /// @param disparity_px  of the current frame: points at its edges are left out, as they cannot be
  ///   tracked well.
  /// @param ground  of the current frame: its points are left out, as shadows are no objects.
  /// @returns pixels, at most one per cell of 4x4 lattice points, row by row. Valid until the next
  ///   call.
  const std::vector<cv::Point>& find(const cv::Mat1w& deviation, const cv::Mat1f& mismatch,
                                     const cv::Mat1f& disparity_px, const DisparityRange& range,
                                     const LevelGround& ground,
                                     const MotionDetectionParams& params);

  /// Share of the image's cells that were suspicious in the last call, including those whose points
  /// were left out.
  double share() const { return share_; }

 private:
  double share_ = 0;
  std::vector<int> cells_of_row_;  // number of suspicious cells
  std::vector<std::vector<cv::Point>> suspects_of_row_;
  std::vector<cv::Point> suspects_px_;
};

/// Points at least this far from the border of the lattice are compared.
constexpr int kPatchReach = 2;
constexpr size_t kMostSuspects = 3000;

/// Drops points that a static world explains after all, with a slightly larger or smaller disparity
/// or with that of a neighbour: disparities of foliage, fences and edges are often wrong by this.
/// Also drops points that were occluded in the previous frame.
/// @param points_px  on the lattice, at least kPatchReach lattice points from the border.
/// @param kept  the other points, in their order. If there are more than kMostSuspects points, as
///   when ego-motion fails, only an even sample of them is used.
void unexplainedPoints(const PastView& view, const std::vector<cv::Point>& points_px,
                       std::vector<cv::Point>& kept);

}  // namespace predictive_stereo
