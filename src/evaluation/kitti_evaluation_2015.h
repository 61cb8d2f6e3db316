/// Evaluation of methods on the pairs of KITTI 2015, with the devkit's D1.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/disparity_report.h"

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
};

struct KittiScore {
  KittiCounts all, background, vehicles;

  KittiScore& operator+=(const KittiScore& other);
};

/// @param truth_px  see kNoTruth.
/// @param vehicles  not 0: "vehicles", 0: "background".
/// @throws std::invalid_argument for maps of different sizes.
KittiScore scoreAsKitti(const cv::Mat1f& disparity_px, const DisparityRange& range,
                        const cv::Mat1f& truth_px, const cv::Mat1b& vehicles);

/// Results of methods on pairs, pooled over these.
class KittiEvaluation2015 {
 public:
  explicit KittiEvaluation2015(const std::vector<NamedMethod>& methods);

  /// Runs the methods on a pair.
  /// @param frame  the pair, with truth and vehicles.
  /// @param input  the pair in a sequence, of which it may be the only one.
  /// @param running  the methods, with the past of that sequence.
  void add(const std::string& scene, const SequenceFrame& frame, const MethodInput& input,
           const std::vector<DisparityMethod>& running, const DisparityRange& range);

  /// D1 of background, vehicles and all pixels, with and without interpolation.
  Table table() const;
  /// Sparsification error of each method, of every second row and column.
  Table certaintyTable() const;
  /// The following are of `ours`, or else of the first method.
  /// The ten scenes with the most wrong pixels, and their figures.
  Table worstTable() const;
  std::vector<std::pair<std::string, KittiScore>> worst() const;
  /// See calibrationTable: background, vehicles, all. No rows without variances.
  Table variances() const;

 private:
  struct Method {
    std::string name;
    KittiScore score;  ///< against all truth, occluded pixels included
    VarianceCalibration variance, background_variance, vehicle_variance;
    Sparsification sparsification;
    double ms = 0;  ///< of all pairs
  };
  std::vector<Method> methods_;
  size_t shown_;
  std::vector<std::pair<std::string, KittiScore>> scenes_;  ///< of methods_[shown_]
};

}  // namespace predictive_stereo
