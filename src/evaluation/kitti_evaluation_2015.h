/// Evaluation of methods on the pairs of KITTI 2015, with the devkit's D1.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/disparity_report.h"
#include "evaluation/kitti_scenes.h"
#include "evaluation/sparsification.h"

namespace predictive_stereo {

/// Fills pixels without a disparity as the devkit does: along their row with the smaller of the two
/// nearest valid disparities; at the row's ends with the nearest one. A row without any disparity
/// is a copy of the nearest row with some (the upper one of two). A map without any is unchanged.
void interpolateAsKitti(const DisparityRange& range, cv::Mat1f& disparity_px);

/// Counts over pixels with truth. They are pooled over scenes, as in the benchmark's tables.
struct KittiCounts {
  DisparityScore found, interpolated;  ///< before and after interpolation

  double d1_percent() const { return interpolated.d1_filled_percent(); }  ///< the benchmark's D1
  double d1_valid_percent() const { return found.d1_percent(); }  ///< of pixels with a disparity
  double density_percent() const { return found.density_percent(); }
  KittiCounts& operator+=(const KittiCounts& other);
};

struct KittiScore {
  KittiCounts background, vehicles;

  KittiCounts all() const;
  KittiScore& operator+=(const KittiScore& other);
};

/// @param truth_px  see kNoTruth.
/// @param vehicles  not 0: "vehicles", 0: "background".
/// @throws std::invalid_argument for maps of different sizes.
KittiScore scoreAsKitti(const cv::Mat1f& disparity_px, const DisparityRange& range,
                        const cv::Mat1f& truth_px, const cv::Mat1b& vehicles);

struct KittiMethodResult2015 {
  KittiScore score;      ///< against all truth, occluded pixels included
  KittiScore score_noc;  ///< without occluded pixels; empty if this truth is missing
  VarianceCalibration background_variance, vehicle_variance;  ///< of ours only
  Sparsification sparsification;                              ///< every second row and column
  double ms = 0;
};

struct KittiSceneResult2015 {
  std::string scene;
  std::vector<KittiMethodResult2015> methods;  ///< in the order of the methods given
};

/// Runs methods on one scene.
/// @param running  new instances for each scene: its pair is the first frame of a sequence. Or the
///   same instances for all scenes: their pairs are the frames of one sequence.
/// @param input  the pair in that sequence.
/// @param outputs  of each method.
KittiSceneResult2015 evaluateKittiScene2015(
    const KittiScene2015& scene, const MethodInput& input,
    const std::vector<std::unique_ptr<DisparityMethod>>& running, const DisparityRange& range,
    std::vector<MethodOutput>& outputs);
/// A scene's pair as frame `index` of a sequence.
MethodInput inputOf(const KittiScene2015& scene, int index = 0);

/// Results of all scenes.
struct KittiEvaluation2015 {
  std::vector<std::string> methods;
  std::vector<KittiSceneResult2015> scenes;

  /// D1 of background, vehicles and all pixels, with and without interpolation, pooled over scenes.
  Table table() const;
  /// The following two are of `ours`, or else of the first method.
  /// The ten scenes with the most wrong pixels, and their figures.
  Table worstTable() const;
  /// Shares of errors within 1, 2, 3 sigma: background, vehicles, all. No rows without variances.
  Table calibrationTable() const;
  /// Sparsification error of each method, pooled over scenes.
  Table certaintyTable() const;
  /// Indices of the scenes of worstTable.
  std::vector<size_t> worst() const;
  /// All counts, one line per scene and method, with a header.
  std::string csv() const;

 private:
  size_t shown() const;
  template <class Value>
  Value total(size_t method, Value KittiMethodResult2015::*member) const;
};

}  // namespace predictive_stereo
