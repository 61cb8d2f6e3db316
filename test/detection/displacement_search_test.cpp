/// Shifts along a row are identical to plain sums, on every SIMD target.
#include "detection/displacement_search.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>
#include <vector>

#include "every_target.h"

namespace predictive_stereo {
namespace {

std::vector<int32_t> reference(const std::vector<uint8_t>& grey,
                               const std::vector<const uint8_t*>& before, int trials) {
  const int n = static_cast<int>(grey.size());
  std::vector<int32_t> totals;
  for (int k = 0; k < trials; ++k) {
    int32_t sum = 0, total = 0;
    for (int i = 0; i < n; ++i)
      sum += grey[static_cast<size_t>(i)] - before[static_cast<size_t>(i)][2 * k];
    for (int i = 0; i < n; ++i)
      total += std::abs(n * (grey[static_cast<size_t>(i)] - before[static_cast<size_t>(i)][2 * k]) -
                        sum);
    totals.push_back(total);
  }
  return totals;
}

void expectAsReference(const std::vector<uint8_t>& image, const std::vector<uint8_t>& grey,
                       const std::vector<size_t>& at, int trials) {
  std::vector<const uint8_t*> before;
  for (size_t offset : at) before.push_back(&image[offset]);
  forEveryTarget([&] {
    std::vector<int32_t> total(
        static_cast<size_t>((trials + kShiftBlock - 1) / kShiftBlock * kShiftBlock));
    totalsOfShifts(grey.data(), before.data(), static_cast<int>(grey.size()), trials, total.data());
    total.resize(static_cast<size_t>(trials));
    EXPECT_EQ(total, reference(grey, before, trials));
  });
}

TEST(ShiftRows, AreThePlainSums) {
  std::mt19937 random(1);
  std::vector<uint8_t> image(4000);
  for (uint8_t& grey : image) grey = static_cast<uint8_t>(random());
  for (int samples : {1, 2, 12, 47, kMostShiftedSamples})
    for (int trials : {1, 3, 15, 16, 17, 41}) {
      std::vector<uint8_t> grey;
      std::vector<size_t> at;
      for (int i = 0; i < samples; ++i) {
        grey.push_back(static_cast<uint8_t>(random()));
        at.push_back(random() % (image.size() - 2 * 48));
      }
      expectAsReference(image, grey, at, trials);
    }
}

TEST(ShiftRows, SumsOfTheLargestDifferencesFit) {
  std::vector<uint8_t> image(400, 255), grey(kMostShiftedSamples, 0);
  std::fill_n(image.begin(), 200, uint8_t{0});
  std::fill_n(grey.begin(), grey.size() / 2, uint8_t{255});
  std::vector<size_t> at(grey.size(), 200);
  std::fill_n(at.begin(), at.size() / 2, size_t{0});
  expectAsReference(image, grey, at, 41);
}

}  // namespace
}  // namespace predictive_stereo
