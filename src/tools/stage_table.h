#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "predictive_stereo/stage_times.h"

namespace predictive_stereo {

/// The value below which a share of the values is; there must be at least one.
inline double quantile(std::vector<double> values, double share) {
  const size_t index =
      std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index),
                   values.end());
  return values[index];
}

/// Times of many frames, printed as one line per stage: median and 95th percentile.
class StageTable {
 public:
  void add(const StageTimes& times) {
    for (const StageTime& time : times) {
      auto stage = std::find_if(stages_.begin(), stages_.end(),
                                [&](const auto& known) { return known.first == time.name; });
      if (stage == stages_.end()) stage = stages_.insert(stages_.end(), {time.name, {}});
      stage->second.push_back(time.ms);
    }
  }

  /// Quantile of the times of a stage [ms]; NaN if it never ran.
  double quantileOf(const std::string& name, double share) const {
    for (const auto& [known, ms] : stages_)
      if (known == name) return quantile(ms, share);
    return std::nan("");
  }

  void print(std::ostream& out) const {
    out << cv::format("%-24s %10s %10s\n", "stage", "median ms", "p95 ms");
    for (const auto& [name, ms] : stages_)
      out << cv::format("%-24s %10.2f %10.2f\n", name.c_str(), quantile(ms, 0.5),
                        quantile(ms, 0.95));
  }

 private:
  std::vector<std::pair<std::string, std::vector<double>>> stages_;
};

}  // namespace predictive_stereo
