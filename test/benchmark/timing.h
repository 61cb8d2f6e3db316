/// Times functions alternately, so that other load of the machine affects all of them equally.
#pragma once

#include <malloc.h>

#include <functional>
#include <limits>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "evaluation/statistics.h"

namespace predictive_stereo {

/// Makes malloc keep what is freed; call it first in main(). OpenCV's MODE_HH allocates 120 MB for
/// each image: otherwise, the system would clear these pages again each time. That costs 0.05 s on
/// some machines and 1 s on others, and slows what runs after it.
inline void keepFreedMemory() {
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

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
