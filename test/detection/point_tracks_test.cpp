/// Limits of candidates: the first useful ones are kept in their order, and no others.
#include "detection/point_tracks.h"

#include <gtest/gtest.h>

#include <numeric>

namespace predictive_stereo {
namespace {

std::vector<int> numbers(int count) {
  std::vector<int> all(static_cast<size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(FirstResults, AreTheFirstEightThatAreAnyGood) {
  int asked = 0;
  const auto square_of_odd = [&](int i) {
    ++asked;
    return i % 2 ? std::optional<double>(i * i) : std::nullopt;
  };
  EXPECT_EQ(firstResults(numbers(100), square_of_odd),
            (std::vector<double>{1, 9, 25, 49, 81, 121, 169, 225}));
  EXPECT_EQ(asked, 16) << "what costs time is not done for the rest";
  EXPECT_EQ(firstResults(numbers(4), square_of_odd), (std::vector<double>{1, 9}));
  EXPECT_TRUE(firstResults(numbers(0), square_of_odd).empty());
}

}  // namespace
}  // namespace predictive_stereo
