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

TEST(FirstFew, TakesTheFirstThatAreAnyGood) {
  int asked = 0;
  const auto square_of_odd = [&](int i) {
    ++asked;
    return i % 2 ? std::optional<double>(i * i) : std::nullopt;
  };
  EXPECT_EQ(firstResults(3, numbers(100), square_of_odd), (std::vector<double>{1, 9, 25}));
  EXPECT_EQ(asked, 6) << "what costs time is not done for the rest";
  EXPECT_EQ(firstResults(3, numbers(4), square_of_odd), (std::vector<double>{1, 9}));
  EXPECT_TRUE(firstResults(3, numbers(0), square_of_odd).empty());
  EXPECT_TRUE(firstResults(0, numbers(9), square_of_odd).empty());
}

TEST(FirstFew, TakesExactlyAsManyAsAFrameMay) {
  const auto any = [](int i) { return std::optional<int>(i); };
  for (const size_t most : {kMostAcross, kMostAlong}) {
    const auto last = static_cast<int>(most);
    EXPECT_EQ(firstResults(most, numbers(last - 1), any), numbers(last - 1));
    EXPECT_EQ(firstResults(most, numbers(last), any), numbers(last));
    EXPECT_EQ(firstResults(most, numbers(last + 1), any), numbers(last));
  }
}

}  // namespace
}  // namespace predictive_stereo
