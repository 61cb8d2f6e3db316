#include "matching/census.h"

#include <algorithm>
#include <cstdlib>

namespace predictive_stereo {

CensusPattern censusPattern(CensusForm form) {
  constexpr int kNear = 2;  // within 5x5
  CensusPattern pattern{};
  size_t size = 0;
  for (int y = -kNear; y <= kNear; ++y)
    for (int x = -kCensusMargin; x <= kCensusMargin; ++x) {
      const bool is_near = std::abs(x) <= kNear;
      const bool is_centre = y == 0 && x == 0;
      if (form == CensusForm::k5x5) {
        if (is_near && !is_centre) pattern[size++] = {x, y, 0, 0};
        continue;
      }
      const bool is_mixed = form == CensusForm::kMixed9x5;
      const bool before_centre = y < 0 || (y == 0 && x < 0);
      if (before_centre && (is_near || !is_mixed)) pattern[size++] = {x, y, -x, -y};
      // Of the far pixels every second one, and those above and below.
      const bool is_second = (x + y) % 2 == 0;
      if (is_mixed && ((!is_near && is_second) || (x == 0 && std::abs(y) == kNear)))
        pattern[size++] = {x, y, 0, 0};
    }
  return pattern;
}

void censusReference(const cv::Mat1b& image, CensusForm form, cv::Mat1i& words) {
  const CensusPattern pattern = censusPattern(form);
  const auto at = [&](int x, int y) {
    return image(std::clamp(y, 0, image.rows - 1), std::clamp(x, 0, image.cols - 1));
  };
  words.create(image.size());
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      int word = 0, bit = 0;
      for (const CensusComparison& c : pattern)
        word |= (at(x + c.first_x, y + c.first_y) < at(x + c.second_x, y + c.second_y)) << bit++;
      words(y, x) = word;
    }
}

}  // namespace predictive_stereo
