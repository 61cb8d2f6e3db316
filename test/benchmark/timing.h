/// Times functions alternately, so that other load of the machine affects all of them equally.
#pragma once

#include <functional>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "evaluation/statistics.h"

namespace predictive_stereo {

inline double timeOf(const std::function<void()>& work) {
  const auto before = static_cast<double>(cv::getTickCount());
  work();
  return (static_cast<double>(cv::getTickCount()) - before) / cv::getTickFrequency() * 1e3;
}

/// Median time of each function [ms], after one round of warm-up.
inline std::vector<double> mediansInTurn(const std::vector<std::function<void()>>& works,
                                         int rounds) {
  std::vector<std::vector<double>> ms(works.size());
  for (int round = -1; round < rounds; ++round)
    for (size_t i = 0; i < works.size(); ++i) {
      const double time = timeOf(works[i]);
      if (round >= 0) ms[i].push_back(time);
    }
  std::vector<double> medians;
  for (const auto& times : ms) medians.push_back(median(times));
  return medians;
}

}  // namespace predictive_stereo
