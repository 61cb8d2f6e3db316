#include "matching/census.h"

#include <algorithm>

namespace predictive_stereo {

CensusPattern::CensusPattern(CensusForm form) {
  const bool with_centre = form == CensusForm::k5x5;
  const int radius_x = with_centre ? 2 : 4;
  const int radius_y = form == CensusForm::kCentreSymmetric9x7 ? 3 : 2;
  for (int y = -radius_y; y <= radius_y; ++y)
    for (int x = -radius_x; x <= radius_x; ++x) {
      const bool is_centre = y == 0 && x == 0;
      const bool before_centre = y < 0 || (y == 0 && x < 0);
      if (with_centre && !is_centre) comparisons_[size_++] = {x, y, 0, 0};
      if (!with_centre && before_centre) comparisons_[size_++] = {x, y, -x, -y};
    }
}

void censusReference(const cv::Mat1b& image, CensusForm form, cv::Mat1i& words) {
  const CensusPattern pattern(form);
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
