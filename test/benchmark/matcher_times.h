/// Times of OpenCV's matchers and ours on the same frames, measured alternately.
#pragma once

#include <functional>
#include <map>
#include <opencv2/calib3d.hpp>
#include <string>
#include <vector>

#include "benchmark/matching_jobs.h"

namespace predictive_stereo {

class MatcherTimes {
 public:
  MatcherTimes(const StereoRig& rig, const DisparityParams& params);

  /// Times every method on every frame, once per round and number of threads.
  void measure(const std::vector<MatchingJob>& jobs, int rounds, const std::vector<int>& threads);
  /// Prints a table of medians and ratios.
  void print(const std::vector<int>& threads) const;

 private:
  struct Method {
    std::string name;
    std::function<void(const MatchingJob&)> run;
    std::map<int, std::vector<double>> ms;  ///< by number of threads
  };

  const StereoRig rig_;
  const DisparityParams params_;
  const cv::Ptr<cv::StereoSGBM> hh_, three_way_;
  StereoMatcher four_, eight_;
  CoarseMatcher coarse_matcher_;
  RowAligner aligner_;
  Predictor predictor_;
  SearchRangeBuilder builder_;
  std::vector<Method> methods_;

  cv::Mat1s opencv_disparity_16_;
  cv::Mat1b aligned_;
  cv::Mat1f coarse_px_, supported_px_, filtered_px_;
  Prediction prediction_;
  SearchRanges ranges_;
  Match match_;
};

}  // namespace predictive_stereo
