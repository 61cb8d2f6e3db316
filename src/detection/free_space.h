/// Free space violated: surfaces that stand where the camera has looked through before.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "detection/depth_cells.h"
#include "detection/frame_comparison.h"
#include "detection/motion_noise.h"
#include "predictive_stereo/moving_objects.h"
#include "predictive_stereo/path_covariance.h"

namespace predictive_stereo {

/// A past frame as one row of cells sees it.
struct PastSight : PastMap {
  const float *nearest_px, *farthest_px;  ///< see DepthCells; of the whole frame
  DepthNoiseOfRow noise;
};

/// Cells of one row.
struct SightRow {
  const float *disparity_px, *variance_px2;
  const float* width_px;  ///< of their obstacles, see obstacleWidths
  int cells, y;           ///< y: of their centres [px]
  float cx_px, focal_px;  ///< direction of column x: (x - cx) / focal
  float disparity_times_depth;
};

/// Compares the cells with past frames; the same on every SIMD target, bit by bit.
/// @param past  `count` frames, the last one first.
/// @param through_by  1 + index of the first frame that looked through, where kFewestThrough and
///   more did than saw the surface at its place later on; 0 elsewhere.
/// @param fixed  255 where a frame saw the surface at its place; 0 elsewhere.
void sightsRow(const SightRow& row, const PastSight* past, int count, uint8_t* through_by,
               uint8_t* fixed);

/// Evidence of each cell, 255 or 0. Cells with neither were hidden, outside the image or unknown.
struct FreeSpaceEvidence {
  cv::Mat1b moved;  ///< past frames looked through the place of its surface
  cv::Mat1b fixed;  ///< a past frame saw its surface there
};

/// Remembers where the camera has looked through, for 13 frames that are at least 80 ms apart.
///
/// A point that is measured now with disparity d has the disparity d' in a past frame, if it is
/// static. If that frame measured clearly less there, it looked through: something stands now where
/// nothing was. If it measured more, the point was hidden. This needs neither tracks nor small
/// motion, and texture only to refute it: where the past image shows the surface itself, or the
/// background explains the current image, one of the two disparities is wrong.
class FreeSpace {
 public:
  /// Compares a frame with the remembered ones. A gap of more than 1 s ends them, and a motion that
  /// nobody saw.
  /// @param half_image  the left image on the lattice of DepthCells.
  /// @param width_px  of the obstacle that each cell belongs to, see obstacleWidths: a past frame
  ///   in which it was too thin for the matcher is no evidence.
  void compare(const DetectionInput& input, const DepthCells& cells, const cv::Mat1b& half_image,
               const cv::Mat1f& width_px);
  const FreeSpaceEvidence& evidence() const { return evidence_; }
  /// Remembers the frame. Its pose must be known.
  /// @param cells  nearest_px and farthest_px are taken over, and undefined afterwards.
  void remember(const DetectionInput& input, DepthCells& cells, const cv::Mat1b& half_image);
  /// Adds `step_px` to the disparities of the past, after a change of the column correction.
  void addToDisparities(float step_px);
  void reset() { count_ = 0; }

 private:
  static constexpr int kRemembered = 13;
  struct Remembered {
    double stamp_s = 0;
    Eigen::Isometry3d T_odom_cam = Eigen::Isometry3d::Identity();
    PathCovariance motion_since;        // of the camera, until the current frame
    cv::Mat1f nearest_px, farthest_px;  // see DepthCells
    cv::Mat1b half_image;
  };
  // A remembered frame that is compared with the current one.
  struct Lag {
    SourceOf into_past, into_now;
    PastDepthNoise noise;
    const Remembered& past;
  };

  void endPastBefore(double stamp_s);
  void continueMotions(const DetectionInput& input);
  std::vector<Lag> lagsOf(const DetectionInput& input) const;
  // The lag as the cells of one row of pixels see it.
  static PastSight sightOf(const StereoRig& rig, const Lag& lag, int y);
  // @param cell  (x, y, d) [px] of a current one.
  static bool isRefuted(const Lag& lag, const cv::Mat1b& half_image, const Eigen::Vector3f& cell);

  std::array<Remembered, kRemembered> frames_;                     // the last one first
  Eigen::Isometry3d T_odom_last_ = Eigen::Isometry3d::Identity();  // of the last compared frame
  int count_ = 0;
  FreeSpaceEvidence evidence_;
};

}  // namespace predictive_stereo
