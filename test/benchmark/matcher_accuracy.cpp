#include "benchmark/matcher_accuracy.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <opencv2/calib3d.hpp>

#include "evaluation/disparity_evaluation.h"
#include "evaluation/disparity_metrics.h"
#include "predictive_stereo/post_filter.h"

namespace predictive_stereo {
namespace {

constexpr float kHoleTolerancePx = 3;  // as in DisparityLoop

struct Result {
  cv::Mat1f disparity_px;
  double mean_width_px;
};
using Method = std::function<Result(const MatchingJob&)>;

/// @param baseline  reference of the ratios; set by the first row.
void printRow(const char* name, const std::vector<MatchingJob>& jobs, const DisparityRange& range,
              const Method& method, MeanDisparityScore& baseline) {
  MeanDisparityScore mean;
  double width = 0;
  for (const MatchingJob& job : jobs) {
    if (job.truth_px.empty()) continue;
    const Result result = method(job);
    mean.add(scoreDisparity(result.disparity_px, range, job.truth_px));
    width += result.mean_width_px;
  }
  if (baseline.frames == 0) baseline = mean;
  std::printf("| %-35s | %5.1f | %5.2f | %5.2f | %5.2f | %5.2f | %5.1f |\n", name,
              mean.density_percent, mean.d1_percent, mean.d1_percent / baseline.d1_percent,
              mean.d1_filled_percent, mean.d1_filled_percent / baseline.d1_filled_percent,
              width / mean.frames);
}

}  // namespace

void printMatcherAccuracy(const std::vector<MatchingJob>& jobs, const DisparityParams& params) {
  const auto has_truth = [](const MatchingJob& job) { return !job.truth_px.empty(); };
  if (std::none_of(jobs.begin(), jobs.end(), has_truth)) return;
  const DisparityRange& range = params.matcher.range;

  const auto opencv = [&](int mode, bool aligned) -> Method {
    return [=](const MatchingJob& job) {
      Result result{{}, static_cast<double>(range.count)};
      opencvDisparity(job.left, aligned ? job.aligned_right : job.right, range, mode,
                      result.disparity_px);
      return result;
    };
  };
  const auto ours = [&](PathSet paths, bool aligned, bool full) -> Method {
    return [=](const MatchingJob& job) {
      MatcherParams matcher_params = params.matcher;
      matcher_params.paths = paths;
      StereoMatcher matcher(matcher_params);
      const cv::Mat1b& right = aligned ? job.aligned_right : job.right;
      Match match;
      if (full)
        matcher.match(job.left, right, match);
      else
        matcher.match(job.left, right, job.ranges, match);
      Result result{{}, cv::mean(match.search_width)[0]};
      cv::Mat1f supported_px, filled_px;
      filterBySupport(range, params.min_support, match.disparity_px, supported_px);
      fillHoles(range, params.max_hole_px, kHoleTolerancePx, supported_px, filled_px);
      median3x3(range, 3, filled_px, result.disparity_px);
      return result;
    };
  };

  std::printf(
      "\n| %% of the pixels with truth | density | outliers (D1) | x HH | with invalid (D1f) | x "
      "HH "
      "| mean width |\n|---|---:|---:|---:|---:|---:|---:|\n");
  MeanDisparityScore baseline;
  const auto row = [&](const char* name, const Method& method) {
    printRow(name, jobs, range, method, baseline);
  };
  constexpr PathSet kFour = PathSet::kStraight4, kEight = PathSet::kAll8;
  row("OpenCV MODE_HH", opencv(cv::StereoSGBM::MODE_HH, false));
  row("OpenCV MODE_HH, rows aligned", opencv(cv::StereoSGBM::MODE_HH, true));
  row("OpenCV MODE_SGBM_3WAY", opencv(cv::StereoSGBM::MODE_SGBM_3WAY, false));
  row("full search, 4 paths, rows as given", ours(kFour, false, true));
  row("full search, 4 paths", ours(kFour, true, true));
  row("full search, 8 paths", ours(kEight, true, true));
  row("reduced search, 4 paths", ours(kFour, true, false));
  row("reduced search, 8 paths", ours(kEight, true, false));
}

}  // namespace predictive_stereo
