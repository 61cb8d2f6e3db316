#include "benchmark/matcher_times.h"

#include <cstdio>

#include "benchmark/timing.h"
#include "predictive_stereo/post_filter.h"

namespace predictive_stereo {
namespace {

// Indices in the list of MatcherTimes of the methods with which the others are compared.
constexpr int kHh = 0, kThreeWay = 1, kFull = 2;

// Like opencvDisparity (evaluation/disparity_evaluation.h), but it reuses its buffers.
cv::Ptr<cv::StereoSGBM> opencvMatcher(const DisparityRange& range, int mode) {
  return cv::StereoSGBM::create(range.min_disparity, range.count, 3, 26, 470, 0, 0, 0, 0, 0, mode);
}

MatcherParams withPaths(MatcherParams params, PathSet paths) {
  params.paths = paths;
  return params;
}

}  // namespace

MatcherTimes::MatcherTimes(const StereoRig& rig, const DisparityParams& params)
    : rig_(rig),
      params_(params),
      hh_(opencvMatcher(params.matcher.range, cv::StereoSGBM::MODE_HH)),
      three_way_(opencvMatcher(params.matcher.range, cv::StereoSGBM::MODE_SGBM_3WAY)),
      four_(withPaths(params.matcher, PathSet::kStraight4)),
      eight_(withPaths(params.matcher, PathSet::kAll8)),
      coarse_matcher_(params.matcher),
      aligner_(params.row_alignment),
      predictor_(params.matcher.range, params.prediction),
      builder_(params.matcher.range, params.search) {
  const auto coarse = [this](const MatchingJob& job) {
    coarse_matcher_.match(job.left, job.right, coarse_px_);
  };
  const auto prediction = [this](const MatchingJob& job) {
    predictor_.predict(job.previous, rig_, job.motion, prediction_);
  };
  const auto ranges = [this](const MatchingJob&) {
    builder_.build(prediction_, coarse_px_, ranges_);
  };
  const auto reduced = [this](const MatchingJob& job) {
    four_.match(job.left, job.aligned_right, job.ranges, match_);
  };
  const auto add = [this](const char* name, std::function<void(const MatchingJob&)> run) {
    methods_.push_back({name, std::move(run), {}});
  };
  add("OpenCV MODE_HH (8 paths)",
      [this](const MatchingJob& job) { hh_->compute(job.left, job.right, opencv_disparity_16_); });
  add("OpenCV MODE_SGBM_3WAY", [this](const MatchingJob& job) {
    three_way_->compute(job.left, job.right, opencv_disparity_16_);
  });
  add("full search, 4 paths",
      [this](const MatchingJob& job) { four_.match(job.left, job.aligned_right, match_); });
  add("full search, 8 paths",
      [this](const MatchingJob& job) { eight_.match(job.left, job.aligned_right, match_); });
  add("reduced search: core", reduced);
  add("reduced search: half resolution", coarse);
  add("prediction", prediction);  // an input of ranges, filters and detector
  add("reduced search: ranges", ranges);
  add("reduced search: all three", [=](const MatchingJob& job) {
    coarse(job);
    ranges(job);
    reduced(job);
  });
  add("reduced search: with prediction", [=](const MatchingJob& job) {
    coarse(job);
    prediction(job);
    ranges(job);
    reduced(job);
  });
  add("row alignment: estimate and warp", [this](const MatchingJob& job) {
    const RowOffsetModel alignment =
        aligner_.estimate(job.left, job.right, coarse_px_, params_.matcher.range);
    alignRightImage(job.right, alignment, 0, aligned_);
  });
  add("support filter and median", [this](const MatchingJob&) {
    filterBySupport(params_.matcher.range, params_.min_support, match_.disparity_px, supported_px_);
    median3x3(params_.matcher.range, 5, supported_px_, filtered_px_);
  });
}

void MatcherTimes::measure(const std::vector<MatchingJob>& jobs, int rounds,
                           const std::vector<int>& threads) {
  for (const MatchingJob& job : jobs)
    for (int round = -1; round < rounds; ++round)  // the first one warms up
      for (int n : threads) {
        cv::setNumThreads(n);
        for (Method& method : methods_) {
          const double ms = timeOf([&] { method.run(job); });
          if (round >= 0) method.ms[n].push_back(ms);
        }
      }
}

void MatcherTimes::print(const std::vector<int>& threads) const {
  std::printf("\n| median ms");
  for (int n : threads)
    std::printf(" | %d thread%s | x HH | x 3WAY | x full", n, n == 1 ? "" : "s");
  std::printf(" |\n|---");
  for (size_t i = 0; i < threads.size(); ++i) std::printf("|---:|---:|---:|---:");
  std::printf("|\n");
  const auto ms = [this](const Method& method, int n) { return median(method.ms.at(n)); };
  for (const Method& method : methods_) {
    std::printf("| %-34s", method.name.c_str());
    for (int n : threads) {
      std::printf(" | %7.2f", ms(method, n));
      for (int other : {kHh, kThreeWay, kFull})
        std::printf(" | %5.1f", ms(methods_[static_cast<size_t>(other)], n) / ms(method, n));
    }
    std::printf(" |\n");
  }
}

}  // namespace predictive_stereo
