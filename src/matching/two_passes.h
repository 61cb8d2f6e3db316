/// The downward and the upward pass over an image, at the same time.
#pragma once

#include <opencv2/core.hpp>

namespace predictive_stereo {

/// Visits every row twice, by both passes in turn. While the downward pass starts from the top,
/// the upward one starts from the bottom; they meet before row `middle` and go on where the other
/// one has been. So each pass follows its order, and both run side by side: not an approximation.
/// @param visit_row  called with (y, whether by the upward pass, whether for the first time).
template <class VisitRow>
void visitRowsTwice(int height, int middle, const VisitRow& visit_row) {
  for (const bool is_first_visit : {true, false})
    cv::parallel_for_(cv::Range(0, 2), [&](const cv::Range& halves) {
      for (int half = halves.start; half < halves.end; ++half) {
        const bool is_top = half == 0, upward = is_top != is_first_visit;
        const int begin = is_top ? 0 : middle, end = is_top ? middle : height;
        for (int i = begin; i < end; ++i)
          visit_row(upward ? begin + end - 1 - i : i, upward, is_first_visit);
      }
    });
}

}  // namespace predictive_stereo
