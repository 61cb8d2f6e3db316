/// Methods on the single pairs of KITTI 2015: no past, D1 of the devkit.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/disparity_report.h"
#include "evaluation/kitti_scene_2015.h"
#include "evaluation/kitti_score_2015.h"

namespace predictive_stereo {

struct KittiMethodResult2015 {
  KittiScore score;      ///< against all truth, occluded pixels included
  KittiScore score_noc;  ///< against truth without them; no pixels where it is missing
  VarianceCalibration background_variance, vehicle_variance;  ///< of ours only
  double ms = 0;
};

struct KittiSceneResult2015 {
  std::string scene;
  std::vector<KittiMethodResult2015> methods;  ///< in the order of the methods given
};

/// Runs every method on one scene, each as if the pair were the first of a sequence.
/// @param outputs  of each method; disparities as published.
KittiSceneResult2015 evaluateKittiScene2015(const KittiScene2015& scene,
                                            const std::vector<NamedMethod>& methods,
                                            const DisparityRange& range,
                                            std::vector<MethodOutput>& outputs);

/// D1 of background, vehicles and all, with and without interpolation; pooled over scenes.
Table kittiTable2015(const std::vector<std::string>& methods,
                     const std::vector<KittiSceneResult2015>& scenes);
/// The scenes in which `method` has the most wrong pixels, with its figures; at most `count`.
Table worstScenes2015(const std::vector<std::string>& methods,
                      const std::vector<KittiSceneResult2015>& scenes, size_t method, int count);
/// Indices of those scenes, the worst first.
std::vector<size_t> worstSceneIndices2015(const std::vector<KittiSceneResult2015>& scenes,
                                          size_t method, int count);
/// Shares of errors within 1, 2, 3 sigma: background, vehicles, all. No rows without variances.
Table kittiCalibrationTable2015(const std::vector<KittiSceneResult2015>& scenes, size_t method);
/// All counts, one line a scene and method, with a header.
std::string kittiCsv2015(const std::vector<std::string>& methods,
                         const std::vector<KittiSceneResult2015>& scenes);

}  // namespace predictive_stereo
