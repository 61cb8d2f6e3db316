/// Rows of every length beside a guard page (guarded_memory.h), on every SIMD target: the loops of
/// the filters read and write only the memory that their headers document.
#include <gtest/gtest.h>

#include <vector>

#include "filtering/correction_rows.h"
#include "filtering/hole_kernels.h"
#include "filtering/post_filter_kernels.h"
#include "filtering/prediction_rows.h"
#include "filtering/range_rows.h"
#include "filtering/variance_rows.h"
#include "guarded_memory.h"

namespace predictive_stereo {
namespace {

using testing::forEveryGuardAndTarget;
using testing::Guard;
using testing::GuardedRow;
using testing::kMostGuarded;

using Floats = GuardedRow<float>;
using Bytes = GuardedRow<uint8_t>;
using Shorts = GuardedRow<int16_t>;

// Disparities, some of them invalid.
constexpr float kSmallest = 0, kInvalid = -1;
Floats disparities(Guard guard, int beyond = 0) {
  return Floats(kMostGuarded + beyond, guard, -1, 6);
}
Floats variances(Guard guard) { return Floats(kMostGuarded, guard, 0, 4); }
Bytes bytes(Guard guard, int below = 4) { return Bytes(kMostGuarded, guard, 0, below); }

// Calls body(guard, width) for every width, with the same rows.
template <class MakeBody>
void forEveryRow(const MakeBody& make_body) {
  forEveryGuardAndTarget([&](Guard guard) {
    make_body(guard, [](const auto& body) {
      for (int width = 1; width <= kMostGuarded; ++width) body(width);
    });
  });
}

TEST(BorderReads, OfCorrection) {
  const CorrectionLimits limits{kSmallest, kInvalid, 0.5f, 4, 3, 255, 0};
  forEveryRow([&](Guard guard, const auto& for_every_width) {
    const Floats measured = disparities(guard), predicted = disparities(guard),
                 p = variances(guard), disparity = disparities(guard), variance = variances(guard),
                 nearest = disparities(guard, kBesideNearest);
    const Bytes missed = bytes(guard), missed_before = bytes(guard);
    for_every_width([&](int n) {
      const CorrectionRow row{measured(n),  predicted(n), p(n),     missed_before(n),
                              disparity(n), variance(n),  missed(n)};
      correctRow(row, n, limits);
      dropRefuted(row, n, limits, nearest(n + kBesideNearest));
    });
  });
}

TEST(BorderReads, OfPrediction) {
  forEveryRow([&](Guard guard, const auto& for_every_width) {
    const Floats disparity = disparities(guard), below = disparities(guard),
                 variance = variances(guard), moved = disparities(guard),
                 moved_variance = variances(guard);
    const GuardedRow<int32_t> target(kMostGuarded, guard);
    const Bytes edges = bytes(guard), united = bytes(guard);
    for_every_width([&](int n) {
      // 3 columns to the left, a little nearer.
      const RowMotion motion{{1, 0, 0, 0}, {-1, 0, 1, 0}, {0, 2, 0, 0.9f}};
      WarpedRow warped{target(n), moved(n), moved_variance(n), 0, 0};
      warpRow(motion, disparity(n), variance(n), {n, 5, kSmallest, 128}, warped);
      markEdges(disparity(n), below(n), n, 1, kSmallest, edges(n));
      uniteMarks(edges(n), n, united(n));
      const RowNoise noise{0.1f, 1, 1, 1, 0, 0, 0, 0.01f, 0.01f, 50};
      addNoiseOrReset(noise, disparity(n), edges(n), n, kSmallest, 9, variance(n));
    });
  });
}

TEST(BorderReads, OfHolesThatAreFilled) {
  forEveryRow([&](Guard guard, const auto& for_every_width) {
    const Floats before = disparities(guard), after = disparities(guard),
                 filled = disparities(guard), v0 = variances(guard), v1 = variances(guard),
                 v2 = variances(guard);
    const Bytes m0 = bytes(guard), m1 = bytes(guard), m2 = bytes(guard);
    for_every_width([&](int n) {
      fillBetween({before(n), v0(n), m0(n)}, {after(n), v2(n), m2(n)}, n, kSmallest,
                  {filled(n), v1(n), m1(n)});
      // Parts of one row, one pixel apart.
      if (n > 2)
        fillBetween({before(n), v0(n), m0(n)}, {before(n) + 2, v0(n) + 2, m0(n) + 2}, n - 2,
                    kSmallest, {before(n) + 1, v0(n) + 1, m0(n) + 1});
      fillHolesOfRow(n, kSmallest, {9, 3, 2}, after(n));
      fillHolesOfColumns(before(n), n / 3, n / 3, 3, kSmallest, {9, 3, 2});
    });
  });
}

TEST(BorderReads, OfSearchRanges) {
  forEveryRow([&](Guard guard, const auto& for_every_width) {
    const Floats disparity = disparities(guard), variance = variances(guard);
    const Bytes near_edge = bytes(guard, 2), missed = bytes(guard);
    const auto shorts = [guard] { return Shorts(kMostGuarded, guard, -3, 100); };
    const Shorts first = shorts(), last = shorts(), columns_first = shorts(),
                 columns_last = shorts(), hull_first = shorts(), hull_last = shorts(),
                 coarse_first = shorts(), coarse_last = shorts();
    const GuardedRow<uint16_t> widths(kMostGuarded, guard);
    for_every_width([&](int n) {
      const RangeRow ranges{first(n), last(n)}, hull{hull_first(n), hull_last(n)};
      widenPredicted({disparity(n), variance(n), near_edge(n), missed(n)}, n, {3, 1, 16}, kSmallest,
                     255, ranges);
      widenMeasured(disparity(n), n, 2, kSmallest, ranges);
      const ConstRangeRow row{first(n), last(n)};
      const ConstRangeRow rows[3] = {row, row, row};
      hullOfRows(rows, n, {columns_first(n), columns_last(n)}, hull);
      uniteWithCoarse({coarse_first(n / 2), coarse_last(n / 2)}, n / 2, n, hull);
      uniteRows(row, n, hull);
      cutRanges(row, n, 0, 127, hull);
      widthsOfRow({hull_first(n), hull_last(n)}, n, widths(n));
    });
  });
}

TEST(BorderReads, OfVariance) {
  forEveryRow([&](Guard guard, const auto& for_every_width) {
    const Floats above = disparities(guard), centre = disparities(guard),
                 below = disparities(guard), filtered = disparities(guard),
                 predicted = disparities(guard), measured = disparities(guard),
                 variance = variances(guard), published = disparities(guard),
                 published_variance = variances(guard), disagreement = variances(guard);
    const Bytes ambiguity = bytes(guard, 256);
    const MeasurementTerms terms{kSmallest, {}};
    const PublishedTerms published_terms{kSmallest, kInvalid, 1, 1, 1, 1, 1, 1, 4, 1, 1, 1, 0, 100};
    for_every_width([&](int n) {
      measurementVarianceRow(measured(n), ambiguity(n), n, terms, variance(n));
      const DisagreementRows rows{centre(n), {above(n), above(n)}, {below(n), below(n)}};
      measureDisagreementOfRow(rows, n, kSmallest, disagreement(n));
      publishRow({rows, filtered(n), predicted(n), measured(n), variance(n), ambiguity(n),
                  published(n), published_variance(n)},
                 n, published_terms);
    });
  });
}

TEST(BorderReads, OfPostFilters) {
  constexpr int kAround = 2, kBeside = 1;  // additional pixels on both sides
  forEveryRow([&](Guard guard, const auto& for_every_width) {
    const Floats disparity = disparities(guard), filtered = disparities(guard),
                 above = disparities(guard, 2 * kBeside), centre = disparities(guard, 2 * kBeside),
                 below = disparities(guard, 2 * kBeside);
    const GuardedRow<int32_t> keys(kMostGuarded + 2 * kAround, guard, -100, 100),
        own_keys(kMostGuarded, guard);
    for_every_width([&](int n) {
      supportKeysOfRow(disparity(n), n, kSmallest, own_keys(n));
      const int32_t* const row = keys(n + 2 * kAround) + kAround;
      const int32_t* const rows[5] = {row, row, row, row, row};
      filterRowBySupport(disparity(n), rows, n, kSmallest, kInvalid, 5, filtered(n));
      const int around = n + 2 * kBeside;
      const float* const medians[3] = {above(around) + kBeside, centre(around) + kBeside,
                                       below(around) + kBeside};
      medianOfRow(medians, n, kSmallest, kInvalid, filtered(n));
    });
  });
}

}  // namespace
}  // namespace predictive_stereo
