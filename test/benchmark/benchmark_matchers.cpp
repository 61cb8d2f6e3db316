/// Times OpenCV's matchers and ours on the same pairs, interleaved in one run, so that what else
/// the machine does hits all of them alike. The reduced search gets real ranges: predicted from the
/// frame before, united with the half-resolution match.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "benchmark/sequences.h"
#include "evaluation/disparity_metrics.h"
#include "predictive_stereo/ego_motion.h"
#include "predictive_stereo/pipeline.h"
#include "predictive_stereo/post_filter.h"

namespace predictive_stereo {
namespace {

const char kUsage[] =
    "Usage: benchmark_matchers [options]                  a built-in synthetic street\n"
    "       benchmark_matchers [options] LEFT RIGHT       two image files\n"
    "       benchmark_matchers [options] DATE_DIR DRIVE   a drive of KITTI's raw recordings\n"
    "       benchmark_matchers [options] TRAINING SCENE   a scene of KITTI 2012\n"
    "Options:\n"
    "  --frames N       measured frames, after two that only start the loop (default 4)\n"
    "  --rounds N       repetitions on each frame (default 5)\n"
    "  --size WxH       of the synthetic street (default 1242x375)\n"
    "  --disparities N  a multiple of 16, at most 256 (default 128)\n"
    "  --no-scaling     leave out how times grow with area, disparities and width\n"
    "  --help\n";

struct Options {
  std::vector<std::string> inputs;
  int frames = 4;
  int rounds = 5;
  cv::Size size{1242, 375};
  int disparities = 128;
  bool scaling = true;
};

constexpr int kFramesBefore = 2;

struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

Options parse(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&]() -> std::string {
      if (++i == argc) throw UsageError(word + " needs a value");
      return argv[i];
    };
    const auto number = [&] {
      const std::string text = value();
      try {
        size_t end = 0;
        const int n = std::stoi(text, &end);
        if (end == text.size() && n > 0) return n;
      } catch (const std::logic_error&) {
      }
      throw UsageError(word + " " + text + ": must be a positive number");
    };
    if (word == "--frames")
      options.frames = number();
    else if (word == "--rounds")
      options.rounds = number();
    else if (word == "--disparities")
      options.disparities = number();
    else if (word == "--no-scaling")
      options.scaling = false;
    else if (word == "--size") {
      const std::string text = value();
      if (std::sscanf(text.c_str(), "%dx%d", &options.size.width, &options.size.height) != 2)
        throw UsageError("--size " + text + ": must be like 1242x375");
    } else if (word.rfind("-", 0) == 0)
      throw UsageError("unknown option " + word);
    else
      options.inputs.push_back(word);
  }
  if (options.inputs.size() != 0 && options.inputs.size() != 2)
    throw UsageError("two image files, a folder and a drive, or nothing is expected");
  return options;
}

std::unique_ptr<Sequence> open(const Options& options) {
  const int frames = options.frames + kFramesBefore;
  return options.inputs.empty() ? misalignedStreet(frames, options.size)
                                : openSequence(options.inputs[0], options.inputs[1], frames);
}

double timeOf(const std::function<void()>& work) {
  const double before = static_cast<double>(cv::getTickCount());
  work();
  return (static_cast<double>(cv::getTickCount()) - before) / cv::getTickFrequency() * 1e3;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

double meanWidth(const Match& match) { return cv::mean(match.search_width)[0]; }

cv::Ptr<cv::StereoSGBM> opencvMatcher(const DisparityRange& range, int mode) {
  return cv::StereoSGBM::create(range.min_disparity, range.count, 3, 26, 470, 0, 0, 0, 0, 0, mode);
}

cv::Mat1f fromOpencv(const cv::Mat1s& disparity_16, const DisparityRange& range) {
  cv::Mat1f disparity_px;
  disparity_16.convertTo(disparity_px, CV_32F, 1.0 / 16);
  disparity_px.setTo(range.invalid(), disparity_px < range.min_disparity);
  return disparity_px;
}

/// What matching one frame starts from.
struct Job {
  cv::Mat1b left, right, aligned_right;
  cv::Mat1f truth_px;
  DisparityState previous;
  CameraMotion motion;
  SearchRanges ranges;
};

/// Runs the closed loop over the sequence, as DisparityEstimator does, and keeps what it needed.
std::vector<Job> prepareJobs(const Sequence& sequence, const DisparityParams& params, int frames) {
  const DisparityRange& range = params.matcher.range;
  EgoMotion ego_motion({});
  CoarseMatcher coarse_matcher(params.matcher);
  RowAligner aligner(params.row_alignment);
  Predictor predictor(range, params.prediction);
  SearchRangeBuilder builder(range, params.search);
  StereoMatcher matcher(params.matcher);
  DisparityState state;
  Prediction prediction;
  Match match;
  cv::Mat1f coarse_px, measured_px;
  std::vector<Job> jobs;
  for (int i = 0; i < std::min(frames, sequence.frames()); ++i) {
    const SequenceFrame frame = sequence.frame(i);
    Job job{frame.left, frame.right, {}, frame.truth_px, {}, {}, {}};
    const EgoMotionEstimate ego = ego_motion.estimate(frame.left, frame.right, sequence.rig());
    job.motion = ego.motion;
    coarse_matcher.match(frame.left, frame.right, coarse_px);
    const RowOffsetModel alignment = aligner.estimate(frame.left, frame.right, coarse_px, range);
    alignRightImage(frame.right, alignment, 0, job.aligned_right);
    if (ego.status == EgoMotionStatus::kTracked)
      predictor.predict(state, sequence.rig(), ego.motion, prediction);
    else
      predictor.predictNothing(frame.left.size(), prediction);
    builder.build(prediction, coarse_px, job.ranges);
    job.previous = {state.disparity_px.clone(), state.variance_px2.clone(),
                    state.missed_frames.clone()};
    matcher.match(job.left, job.aligned_right, job.ranges, match);
    filterBySupport(range, params.min_support, match.disparity_px, measured_px);
    correct(prediction, measured_px, range, params.correction, state);
    if (i >= kFramesBefore && ego.status == EgoMotionStatus::kTracked) jobs.push_back(job);
    job.ranges = {};
  }
  if (jobs.empty()) throw std::runtime_error("the camera's motion could not be followed");
  return jobs;
}

/// A method to be timed: works on a job and keeps its result for the accuracy.
struct Method {
  std::string name;
  std::function<void(const Job&)> run;
  std::map<int, std::vector<double>> ms;  ///< by number of threads
};

class MatcherComparison {
 public:
  MatcherComparison(const Sequence& sequence, const DisparityParams& params)
      : rig_(sequence.rig()),
        params_(params),
        range_(params.matcher.range),
        hh_(opencvMatcher(range_, cv::StereoSGBM::MODE_HH)),
        three_way_(opencvMatcher(range_, cv::StereoSGBM::MODE_SGBM_3WAY)),
        four_(with(PathSet::kStraight4)),
        eight_(with(PathSet::kAll8)),
        coarse_matcher_(params.matcher),
        aligner_(params.row_alignment),
        predictor_(range_, params.prediction),
        builder_(range_, params.search) {
    const auto coarse = [this](const Job& job) {
      coarse_matcher_.match(job.left, job.right, coarse_px_);
    };
    const auto ranges = [this](const Job& job) {
      predictor_.predict(job.previous, rig_, job.motion, prediction_);
      builder_.build(prediction_, coarse_px_, ranges_);
    };
    const auto reduced = [this](const Job& job) {
      four_.match(job.left, job.aligned_right, job.ranges, match_);
    };
    methods_ = {
        {"OpenCV MODE_HH (8 paths)",
         [this](const Job& job) { hh_->compute(job.left, job.right, opencv_); },
         {}},
        {"OpenCV MODE_SGBM_3WAY",
         [this](const Job& job) { three_way_->compute(job.left, job.right, opencv_); },
         {}},
        {"full search, 4 paths",
         [this](const Job& job) { four_.match(job.left, job.aligned_right, match_); },
         {}},
        {"full search, 8 paths",
         [this](const Job& job) { eight_.match(job.left, job.aligned_right, match_); },
         {}},
        {"reduced search: core", reduced, {}},
        {"reduced search: half resolution", coarse, {}},
        {"reduced search: prediction, ranges", ranges, {}},
        {"reduced search: all three",
         [=](const Job& job) {
           coarse(job);
           ranges(job);
           reduced(job);
         },
         {}},
        {"row alignment: estimate and warp",
         [this](const Job& job) {
           const RowOffsetModel alignment =
               aligner_.estimate(job.left, job.right, coarse_px_, range_);
           alignRightImage(job.right, alignment, 0, aligned_);
         },
         {}},
        {"support filter and median",
         [this](const Job&) {
           filterBySupport(range_, params_.min_support, match_.disparity_px, supported_px_);
           median3x3(range_, supported_px_, filtered_px_);
         },
         {}},
    };
  }

  void measure(const std::vector<Job>& jobs, int rounds, const std::vector<int>& threads) {
    for (const Job& job : jobs)
      for (int round = -1; round < rounds; ++round)  // the first one warms up
        for (int n : threads) {
          cv::setNumThreads(n);
          for (Method& method : methods_) {
            const double ms = timeOf([&] { method.run(job); });
            if (round >= 0) method.ms[n].push_back(ms);
          }
        }
  }

  void printTimes(const std::vector<int>& threads) const {
    std::printf("\n| median ms");
    for (int n : threads) std::printf(" | %d thread%s | x HH | x 3WAY", n, n == 1 ? "" : "s");
    std::printf(" |\n|---");
    for (size_t i = 0; i < threads.size(); ++i) std::printf("|---:|---:|---:");
    std::printf("|\n");
    for (const Method& method : methods_) {
      std::printf("| %-34s", method.name.c_str());
      for (int n : threads) {
        const double ms = median(method.ms.at(n));
        std::printf(" | %7.2f | %5.1f | %5.1f", ms, median(methods_[0].ms.at(n)) / ms,
                    median(methods_[1].ms.at(n)) / ms);
      }
      std::printf(" |\n");
    }
  }

  void printAccuracy(const std::vector<Job>& jobs) {
    if (std::all_of(jobs.begin(), jobs.end(), [](const Job& job) { return job.truth_px.empty(); }))
      return;
    std::printf(
        "\n| %% of the pixels with truth | density | outliers (D1) | with invalid (D1f) | mean "
        "width |\n|---|---:|---:|---:|---:|\n");
    const auto row = [&](const char* name, const std::function<cv::Mat1f(const Job&)>& result,
                         bool ours) {
      MeanDisparityScore mean;
      double width = 0;
      for (const Job& job : jobs) {
        if (job.truth_px.empty()) continue;
        mean.add(scoreDisparity(result(job), range_, job.truth_px));
        width += ours ? meanWidth(match_) : range_.count;
      }
      if (mean.frames)
        std::printf("| %-34s | %5.1f | %5.2f | %5.2f | %5.1f |\n", name, mean.density_percent,
                    mean.d1_percent, mean.d1_filled_percent, width / mean.frames);
    };
    const auto opencv = [&](cv::StereoSGBM& matcher, const Job& job, bool aligned) {
      matcher.compute(job.left, aligned ? job.aligned_right : job.right, opencv_);
      return fromOpencv(opencv_, range_);
    };
    const auto filtered = [&] {
      filterBySupport(range_, params_.min_support, match_.disparity_px, supported_px_);
      median3x3(range_, supported_px_, filtered_px_);
      return filtered_px_;
    };
    row(
        "OpenCV MODE_HH", [&](const Job& job) { return opencv(*hh_, job, false); }, false);
    row(
        "OpenCV MODE_HH, rows aligned", [&](const Job& job) { return opencv(*hh_, job, true); },
        false);
    row(
        "OpenCV MODE_SGBM_3WAY", [&](const Job& job) { return opencv(*three_way_, job, false); },
        false);
    row(
        "full search, 4 paths, rows as given",
        [&](const Job& job) {
          four_.match(job.left, job.right, match_);
          return filtered();
        },
        true);
    row(
        "full search, 4 paths",
        [&](const Job& job) {
          four_.match(job.left, job.aligned_right, match_);
          return filtered();
        },
        true);
    row(
        "full search, 8 paths",
        [&](const Job& job) {
          eight_.match(job.left, job.aligned_right, match_);
          return filtered();
        },
        true);
    row(
        "reduced search, 4 paths",
        [&](const Job& job) {
          four_.match(job.left, job.aligned_right, job.ranges, match_);
          return filtered();
        },
        true);
  }

 private:
  StereoMatcher with(PathSet paths) const {
    MatcherParams matcher = params_.matcher;
    matcher.paths = paths;
    return StereoMatcher(matcher);
  }

  StereoRig rig_;
  DisparityParams params_;
  DisparityRange range_;
  cv::Ptr<cv::StereoSGBM> hh_, three_way_;
  StereoMatcher four_, eight_;
  CoarseMatcher coarse_matcher_;
  RowAligner aligner_;
  Predictor predictor_;
  SearchRangeBuilder builder_;
  std::vector<Method> methods_;

  cv::Mat1s opencv_;
  cv::Mat1b aligned_;
  cv::Mat1f coarse_px_, supported_px_, filtered_px_;
  Prediction prediction_;
  SearchRanges ranges_;
  Match match_;
};

/// A map without holes: invalid pixels take the last valid value of their row.
cv::Mat1f dense(const cv::Mat1f& disparity_px, const DisparityRange& range) {
  cv::Mat1f filled = disparity_px.clone();
  for (int y = 0; y < filled.rows; ++y) {
    float last = static_cast<float>(range.min_disparity);
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

/// Times a full and a reduced search (8 disparities around the full search's result).
struct ScaledTimes {
  double full_ms, reduced_ms;
};
ScaledTimes timeScaled(const Job& job, const MatcherParams& params, double area, int rounds) {
  const double side = std::sqrt(area);
  cv::Mat1b left, right;
  const int how = area < 1 ? cv::INTER_AREA : cv::INTER_LINEAR;
  cv::resize(job.left, left, {}, side, side, how);
  cv::resize(job.aligned_right, right, {}, side, side, how);
  StereoMatcher matcher(params);
  Match match;
  matcher.match(left, right, match);
  const SearchRanges ranges =
      rangesAround(dense(match.disparity_px, params.range), params.range, 8);
  std::vector<double> full, reduced;
  matcher.match(left, right, ranges, match);
  for (int i = 0; i < rounds; ++i) {
    full.push_back(timeOf([&] { matcher.match(left, right, match); }));
    reduced.push_back(timeOf([&] { matcher.match(left, right, ranges, match); }));
  }
  return {*std::min_element(full.begin(), full.end()),
          *std::min_element(reduced.begin(), reduced.end())};
}

void printScaling(const Job& job, const MatcherParams& params, int rounds, int most_threads) {
  cv::setNumThreads(1);
  std::printf(
      "\n1 thread, 4 paths, fastest of %d, ms. Reduced: 8 disparities around each pixel's.\n",
      rounds);
  std::printf("\n| image area | full | reduced |\n|---|---:|---:|\n");
  for (double area : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    const ScaledTimes times = timeScaled(job, params, area, rounds);
    std::printf("| x %.2f | %7.2f | %7.2f |\n", area, times.full_ms, times.reduced_ms);
  }
  std::printf("\n| disparities | full | reduced |\n|---|---:|---:|\n");
  for (int count : {32, 64, 128, 192, 256}) {
    MatcherParams other = params;
    other.range.count = count;
    const ScaledTimes times = timeScaled(job, other, 1, rounds);
    std::printf("| %d | %7.2f | %7.2f |\n", count, times.full_ms, times.reduced_ms);
  }
  std::printf("\n| width asked for | mean width searched | ms |\n|---|---:|---:|\n");
  StereoMatcher matcher(params);
  Match full, match;
  matcher.match(job.left, job.aligned_right, full);
  const cv::Mat1f centre_px = dense(full.disparity_px, params.range);
  for (int width : {4, 8, 16, 24, 32, 48, 64, 96, 128}) {
    if (width > params.range.count) break;
    const SearchRanges ranges = rangesAround(centre_px, params.range, width);
    std::vector<double> ms;
    for (int i = 0; i <= rounds; ++i)
      ms.push_back(timeOf([&] { matcher.match(job.left, job.aligned_right, ranges, match); }));
    ms.erase(ms.begin());
    std::printf("| %d | %6.1f | %7.2f |\n", width, meanWidth(match),
                *std::min_element(ms.begin(), ms.end()));
  }

  std::printf("\n| threads | full | reduced |\n|---|---:|---:|\n");
  for (int threads = 1; threads <= most_threads; ++threads) {
    cv::setNumThreads(threads);
    const ScaledTimes times = timeScaled(job, params, 1, rounds);
    std::printf("| %d | %7.2f | %7.2f |\n", threads, times.full_ms, times.reduced_ms);
  }
}

void run(const Options& options) {
  DisparityParams params;
  params.matcher.range.count = options.disparities;
  const std::unique_ptr<Sequence> sequence = open(options);
  const std::vector<Job> jobs = prepareJobs(*sequence, params, options.frames + kFramesBefore);
  const int most_threads = std::max(2, cv::getNumberOfCPUs());
  std::printf("%s, %dx%d, %d disparities, %zu frames, %d rounds; SIMD target %s; OpenCV %s\n",
              sequence->name().c_str(), sequence->rig().size.width, sequence->rig().size.height,
              params.matcher.range.count, jobs.size(), options.rounds,
              StereoMatcher(params.matcher).simdTarget().c_str(), CV_VERSION);

  MatcherComparison comparison(*sequence, params);
  comparison.measure(jobs, options.rounds, {1, 2});
  comparison.printTimes({1, 2});
  comparison.printAccuracy(jobs);
  if (options.scaling) printScaling(jobs.back(), params.matcher, options.rounds, most_threads);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  using namespace predictive_stereo;
  try {
    for (int i = 1; i < argc; ++i)
      if (std::string(argv[i]) == "--help") {
        std::fputs(kUsage, stdout);
        return 0;
      }
    run(parse(argc, argv));
  } catch (const UsageError& error) {
    std::fprintf(stderr, "benchmark_matchers: %s\n%s", error.what(), kUsage);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "benchmark_matchers: %s\n", error.what());
    return 1;
  }
  return 0;
}
