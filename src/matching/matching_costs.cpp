#include "matching/matching_costs.h"

#include <algorithm>
#include <bitset>

namespace predictive_stereo {

CostTables::CostTables(int p2) {
  for (unsigned left = 0; left < 16; ++left)
    for (unsigned right = 0; right < 16; ++right) {
      distance[left][right] = static_cast<uint8_t>(std::bitset<4>(left ^ right).count());
      distance_and_p2[left][right] = static_cast<uint8_t>(distance[left][right] + p2);
    }
}

int nibbleCount(CensusForm form) { return form == CensusForm::kCentreSymmetric9x7 ? 8 : 6; }

void RightWords::build(const cv::Mat1i& words, const DisparityRange& range, int nibbles,
                       int phases) {
  constexpr int kLargestVector = 64;
  const int width = words.cols;
  const int entries = width - 1 + range.count;
  nibbles_ = nibbles;
  stride_ = (entries / phases + 1 + kLargestVector + 63) / 64 * 64;
  planes_.create(words.rows, static_cast<int>(stride_) * nibbles * phases);
  cv::parallel_for_(cv::Range(0, words.rows), [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y)
      for (int entry = 0; entry < entries; ++entry) {
        const int x = std::clamp(width - 1 - range.min_disparity - entry, 0, width - 1);
        const unsigned word = words(y, x);
        uint8_t* target =
            planes_[y] + static_cast<size_t>(entry % phases) * nibbles * stride_ + entry / phases;
        for (int n = 0; n < nibbles; ++n) target[n * stride_] = (word >> (4 * n)) & 15;
      }
  });
}

}  // namespace predictive_stereo
