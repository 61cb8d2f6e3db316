/// D1 as in the devkit of KITTI 2015.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Fills pixels without a disparity as the devkit does: along their row with the smaller of the two
/// nearest valid disparities; at the row's ends with the nearest one. A row without any disparity
/// is a copy of the nearest row with some (the upper one of two). A map without any is unchanged.
void interpolateAsKitti(const DisparityRange& range, cv::Mat1f& disparity_px);

/// Counts over pixels with truth. They are pooled over scenes, as in the benchmark's tables.
struct KittiCounts {
  int64_t pixels = 0;
  int64_t valid = 0;                  ///< with a disparity before interpolation
  int64_t outliers = 0;               ///< of the valid ones
  int64_t interpolated_outliers = 0;  ///< of all after interpolation

  double d1_percent() const;        ///< after interpolation: the benchmark's D1
  double d1_valid_percent() const;  ///< of valid pixels
  double density_percent() const;
  KittiCounts& operator+=(const KittiCounts& other);
};

struct KittiScore {
  KittiCounts background, vehicles;

  KittiCounts all() const;
  KittiScore& operator+=(const KittiScore& other);
};

/// @param disparity_px, interpolated_px  before and after interpolateAsKitti.
/// @param truth_px  see kNoTruth.
/// @param vehicles  not 0: "vehicles", 0: "background".
/// @throws std::invalid_argument for maps of different sizes.
KittiScore scoreAsKitti(const cv::Mat1f& disparity_px, const cv::Mat1f& interpolated_px,
                        const DisparityRange& range, const cv::Mat1f& truth_px,
                        const cv::Mat1b& vehicles);

}  // namespace predictive_stereo
