/// Rows of segments are identical to plain loops, on every SIMD target.
#include "detection/segmentation_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "every_target.h"

namespace predictive_stereo {
namespace {

class SegmentationRows : public testing::TestWithParam<int> {
 protected:
  SegmentationRows() {
    std::mt19937 random(static_cast<unsigned>(GetParam()));
    std::uniform_int_distribution<int> value(-20, 20);
    const auto n = static_cast<size_t>(GetParam());
    for (size_t i = 0; i < 2 * n; ++i) disparity.push_back(static_cast<float>(value(random)));
    for (size_t i = 0; i < n; ++i) {
      first.push_back(static_cast<float>(value(random)));
      second.push_back(static_cast<float>(value(random)));
      some.push_back(value(random) > 0 ? 255 : 0);
      others.push_back(value(random) > 0 ? 255 : 0);
    }
  }
  int width() const { return GetParam(); }

  std::vector<float> disparity, first, second;
  std::vector<uint8_t> some, others;
};

TEST_P(SegmentationRows, LayerIsWithinItsDisparitiesAndNoGround) {
  forEveryTarget([&] {
    std::vector<uint8_t> layer(some.size());
    layerRow(disparity.data(), first.data(), width(), -3, 7, 4, layer.data());
    for (size_t u = 0; u < layer.size(); ++u) {
      const float d = disparity[2 * u];
      EXPECT_EQ(layer[u], d >= -3 && d <= 7 && first[u] < 4 ? 255 : 0) << u;
    }
  });
}

TEST_P(SegmentationRows, SupportIsTheClampedDifference) {
  forEveryTarget([&] {
    std::vector<float> support(first.size());
    supportRow(first.data(), second.data(), width(), 5, support.data());
    for (size_t u = 0; u < support.size(); ++u)
      EXPECT_EQ(support[u],
                first[u] < 0 || second[u] < 0 ? 0 : std::clamp(first[u] - second[u], -5.0f, 5.0f))
          << u;
  });
}

TEST_P(SegmentationRows, SupportedAreThoseAboveTheThreshold) {
  forEveryTarget([&] {
    std::vector<uint8_t> supported(some.size());
    supportedRow(some.data(), first.data(), width(), 2, supported.data());
    for (size_t u = 0; u < some.size(); ++u)
      EXPECT_EQ(supported[u], some[u] && first[u] > 2 ? 255 : 0) << u;
  });
}

TEST_P(SegmentationRows, RefutedMembersAreDropped) {
  forEveryTarget([&] {
    std::vector<uint8_t> members = others;
    dropRefutedRow(some.data(), first.data(), width(), -2, members.data());
    for (size_t u = 0; u < some.size(); ++u)
      EXPECT_EQ(members[u], some[u] && first[u] >= -2 ? others[u] : 0) << u;
  });
}

INSTANTIATE_TEST_SUITE_P(Widths, SegmentationRows, testing::Values(1, 7, 16, 33, 250));

}  // namespace
}  // namespace predictive_stereo
