#include "benchmark/matcher_growth.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "benchmark/timing.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

/// Fills the holes of a map: invalid pixels get the last valid value of their row.
cv::Mat1f dense(const cv::Mat1f& disparity_px, const DisparityRange& range) {
  cv::Mat1f filled = disparity_px.clone();
  for (int y = 0; y < filled.rows; ++y) {
    auto last = static_cast<float>(range.min_disparity);
    for (int x = 0; x < filled.cols; ++x)
      last = filled(y, x) = range.isValid(filled(y, x)) ? filled(y, x) : last;
  }
  return filled;
}

/// Ranges of one width around a map without holes.
SearchRanges rangesAround(const cv::Mat1f& disparity_px, const DisparityRange& range, int width) {
  SearchRanges ranges{cv::Mat1s(disparity_px.size()), cv::Mat1s(disparity_px.size())};
  for (int y = 0; y < disparity_px.rows; ++y)
    for (int x = 0; x < disparity_px.cols; ++x) {
      const int first = std::clamp(cvRound(disparity_px(y, x)) - width / 2, range.min_disparity,
                                   range.max_disparity() - width + 1);
      ranges.first(y, x) = static_cast<short>(first);
      ranges.last(y, x) = static_cast<short>(first + width - 1);
    }
  return ranges;
}

/// A full search, and a reduced one of `width` disparities around its result.
class Searches {
 public:
  Searches(cv::Mat1b left, cv::Mat1b right, const MatcherParams& params, int width)
      : left_(std::move(left)), right_(std::move(right)), matcher_(params) {
    full();
    ranges_ = rangesAround(dense(match_.disparity_px, params.range), params.range, width);
  }
  void full() { matcher_.match(left_, right_, match_); }
  void reduced() { matcher_.match(left_, right_, ranges_, match_); }
  double reducedWidth() {
    reduced();
    return cv::mean(match_.search_width)[0];
  }

 private:
  cv::Mat1b left_, right_;
  StereoMatcher matcher_;
  Match match_;
  SearchRanges ranges_;
};

constexpr int kNarrow = 8;

/// Median times of all full searches, then of all reduced ones.
std::vector<double> times(const std::vector<std::unique_ptr<Searches>>& searches, int rounds) {
  std::vector<std::function<void()>> works;
  for (const auto& each : searches) works.emplace_back([&each] { each->full(); });
  for (const auto& each : searches) works.emplace_back([&each] { each->reduced(); });
  return mediansInTurn(works, rounds);
}

void printTable(const char* title, const std::vector<std::string>& labels,
                const std::vector<double>& times) {
  std::printf("\n| %s | full | reduced |\n|---|---:|---:|\n", title);
  for (size_t i = 0; i < labels.size(); ++i)
    std::printf("| %s | %7.2f | %7.2f |\n", labels[i].c_str(), times[i], times[i + labels.size()]);
}

void printByArea(const MatchingJob& job, const MatcherParams& params, int rounds) {
  std::vector<std::unique_ptr<Searches>> searches;
  std::vector<std::string> labels;
  for (const double area : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    const double side = std::sqrt(area);
    const int how = area < 1 ? cv::INTER_AREA : cv::INTER_LINEAR;
    cv::Mat1b left, right;
    cv::resize(job.left, left, {}, side, side, how);
    cv::resize(job.aligned_right, right, {}, side, side, how);
    labels.push_back(std::to_string(left.cols) + "x" + std::to_string(left.rows));
    searches.push_back(std::make_unique<Searches>(left, right, params, kNarrow));
  }
  printTable("image", labels, times(searches, rounds));
}

void printByCount(const MatchingJob& job, MatcherParams params, int rounds) {
  std::vector<std::unique_ptr<Searches>> searches;
  std::vector<std::string> labels;
  for (params.range.count = 16; params.range.count <= 256; params.range.count += 16) {
    labels.push_back(std::to_string(params.range.count));
    searches.push_back(std::make_unique<Searches>(job.left, job.aligned_right, params, kNarrow));
  }
  printTable("disparities", labels, times(searches, rounds));
}

void printByWidth(const MatchingJob& job, const MatcherParams& params, int rounds) {
  std::vector<std::unique_ptr<Searches>> searches;
  std::vector<int> widths;
  std::vector<std::function<void()>> works;
  for (const int width : {4, 8, 16, 24, 32, 48, 64, 96, 128}) {
    if (width > params.range.count) break;
    widths.push_back(width);
    searches.push_back(std::make_unique<Searches>(job.left, job.aligned_right, params, width));
    works.emplace_back([each = searches.back().get()] { each->reduced(); });
  }
  const std::vector<double> ms = mediansInTurn(works, rounds);
  std::printf("\n| width asked for | mean width searched | reduced |\n|---|---:|---:|\n");
  for (size_t i = 0; i < widths.size(); ++i)
    std::printf("| %d | %6.1f | %7.2f |\n", widths[i], searches[i]->reducedWidth(), ms[i]);
}

void printByThreads(const MatchingJob& job, const MatcherParams& params, int rounds) {
  std::printf("\n| threads | full | reduced |\n|---|---:|---:|\n");
  Searches searches(job.left, job.aligned_right, params, kNarrow);
  for (int threads = 1; threads <= std::max(2, cv::getNumberOfCPUs()); ++threads) {
    cv::setNumThreads(threads);
    const auto ms = mediansInTurn({[&] { searches.full(); }, [&] { searches.reduced(); }}, rounds);
    std::printf("| %d | %7.2f | %7.2f |\n", threads, ms[0], ms[1]);
  }
}

void printBySimdTarget(const MatchingJob& job, MatcherParams params, int rounds) {
  std::vector<std::unique_ptr<Searches>> searches;
  std::vector<std::string> names = availableSimdTargets();
  names.pop_back();  // the plain reference takes seconds
  for (const std::string& name : names) {
    params.simd_target = name;
    searches.push_back(std::make_unique<Searches>(job.left, job.aligned_right, params, kNarrow));
  }
  if (!names.empty()) printTable("SIMD target", names, times(searches, rounds));
}

}  // namespace

void printMatcherGrowth(const MatchingJob& job, const MatcherParams& params, int rounds) {
  cv::setNumThreads(1);
  std::printf(
      "\n1 thread, 4 paths, medians of %d, ms. Reduced: %d disparities around each pixel's.\n",
      rounds, kNarrow);
  printByArea(job, params, rounds);
  printByCount(job, params, rounds);
  printByWidth(job, params, rounds);
  printBySimdTarget(job, params, rounds);
  printByThreads(job, params, rounds);
}

}  // namespace predictive_stereo
