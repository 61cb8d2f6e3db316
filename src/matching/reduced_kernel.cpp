#include "matching/reduced_kernel.h"

#include <algorithm>
#include <type_traits>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/reduced_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "matching/window_vectors-inl.h"

PREDICTIVE_STEREO_BEGIN_KERNELS;

#if PREDICTIVE_STEREO_HAS_VECTORS

constexpr WindowRun kNoWindow{0, 0, 0};

/// A horizontal path at its current pixel.
struct Walker {
  const WindowRun* window = &kNoWindow;  ///< at that pixel; kNoWindow: the path starts
  bool backward;                         ///< from right to left
  /// With room to read beyond both ends of the window.
  HWY_ALIGN uint8_t memory[kBeyond + 256 + kBeyond];
  uint8_t* const goodness = memory + kBeyond;

  explicit Walker(bool walks_backward) : backward(walks_backward) {}
  Neighbour here() const { return {goodness, window->first, window->width}; }
};

/// The work of one visit to the pixels of a run.
struct Visit {
  bool matches;                ///< computes their matching costs
  Walker* walker;              ///< the horizontal path to add, or nullptr
  bool from_previous_row;      ///< adds the paths from the previous row
  const uint8_t* sums_before;  ///< sums of earlier visits, or nullptr
  uint8_t* sums;
};

template <bool kStraight, bool kDiagonal>
class RowAggregation {
 public:
  explicit RowAggregation(const ReducedSearchRow& row)
      : row_(row),
        p1_(hn::Set(run_d_, static_cast<uint8_t>(row.p1))),
        p2_(hn::Set(run_d_, static_cast<uint8_t>(row.p2))),
        runs_((row.columns + kWindowRun - 1) / kWindowRun) {}

  HWY_INLINE void run() {
    const bool is_first_visit = !row_.sums_before;
    if constexpr (kStraight && !kDiagonal) {
      if (row_.part == RowPart::kAcross)
        walkFromBothEnds<false>();
      else if (row_.part == RowPart::kDown)
        followVerticals(row_.begin_run, row_.end_run);
      else
        is_first_visit ? walkFromBothEnds<true>() : followVerticals(0, runs_);
    } else {
      Walker* const walker = !kStraight ? nullptr : row_.upward ? &backward_ : &forward_;
      for (int i = 0; i < runs_; ++i)
        visit(row_.upward ? runs_ - 1 - i : i,
              {is_first_visit, walker, true, row_.sums_before, row_.sums});
    }
  }

 private:
  /// Whether this is a whole run of windows of 16.
  static HWY_INLINE bool isNarrow(const ReducedSearchRow& row, int run) {
    return row.windows[run].width == kLanes && (run + 1) * kWindowRun <= row.columns;
  }

  // --- Straight paths -----------------------------------------------------------------------

  /// First visit: both horizontal paths. The first one at a run computes the matching costs; the
  /// second one completes the sums, with kDown together with the vertical path.
  template <bool kDown>
  HWY_INLINE void walkFromBothEnds() {
    int i = 0, j = runs_ - 1;  // the next runs of the two paths
    const auto isReady = [this](int run, const Walker& walker) {
      return isNarrow(row_, run) && walker.window->width == kLanes;
    };
    while (i < runs_ || j >= 0) {
      if (i < runs_ && j >= 0 && i != j && isReady(i, forward_) && isReady(j, backward_)) {
        i < j ? walkTogether<true, kDown>(i, j) : walkTogether<false, kDown>(i, j);
      } else if (i < runs_ && (j < 0 || i == j || !isReady(i, forward_))) {
        visit(i, visitBy(forward_, i <= j, kDown));
        ++i;
      } else {
        visit(j, visitBy(backward_, i <= j, kDown));
        --j;
      }
    }
  }

  Visit visitBy(Walker& walker, bool comes_first, bool down) const {
    if (comes_first) return {true, &walker, false, nullptr, row_.half_sums};
    return {false, &walker, down, row_.half_sums, row_.sums};
  }

  /// Both horizontal paths, from runs i and j on, while these runs are narrow and the paths do not
  /// meet. kComeFirst: the other path has not visited these runs yet.
  template <bool kComeFirst, bool kDown>
  HWY_INLINE void walkTogether(int& i, int& j) {
    // The loop reads local copies: compilers assume that a written byte may change members of this
    // object.
    const ReducedSearchRow row = row_;
    const int runs = runs_;
    const PairBytes d;
    const auto p1 = lowLanes(d, run_d_, p1_), p2 = lowLanes(d, run_d_, p2_);
    const BitCounter<RunBytes> counter(row.p2);
    uint8_t* const sums = kComeFirst ? row.half_sums : row.sums;
    const uint8_t* const sums_before = kDown ? row.sums : row.half_sums;
    Pair goodness = loadPair(d, forward_.goodness, backward_.goodness);
    int forward_first = forward_.window->first, backward_first = backward_.window->first;
    int a = i, b = j;
    do {
      const WindowRun one = row.windows[a], other = row.windows[b];
      if constexpr (kComeFirst) {
        matchNarrow(row, a, one, counter);
        matchNarrow(row, b, other, counter);
      } else if constexpr (kDown) {
        followVertical(row, a, row.half_sums);
        followVertical(row, b, row.half_sums);
      }
      const PairShuffles shuffles(one.first - forward_first, other.first - backward_first);
      const auto pixels = [&](auto number) HWY_ATTR {
        constexpr int k = number;
        const int at_one = one.position + k * kLanes;
        const int at_other = other.position + (kWindowRun - 1 - k) * kLanes;
        const Pair costs = loadPair(d, row.costs + at_one, row.costs + at_other);
        const Pair floors = setPair(d, row.floors_across[a * kWindowRun + k],
                                    row.floors_across[b * kWindowRun + kWindowRun - k]);
        Pair total;
        if constexpr (!kComeFirst)
          total = loadPair(d, sums_before + at_one, sums_before + at_other);
        for (int part = 0; part < kPairParts; ++part) {
          PairVector& passed_on = goodness.parts[part];
          const auto carried =
              k == 0 ? shuffled(passed_on, shuffles.of_part[part]) : unshifted(d, passed_on);
          const PairVector path = pathCost(costs.parts[part], carried, p1, floors.parts[part]);
          passed_on = goodnessOf(d, path, p2);
          total.parts[part] = kComeFirst ? path : hn::SaturatedAdd(total.parts[part], path);
        }
        storePair(d, total, sums + at_one, sums + at_other);
      };
      pixels(std::integral_constant<int, 0>());
      pixels(std::integral_constant<int, 1>());
      pixels(std::integral_constant<int, 2>());
      pixels(std::integral_constant<int, 3>());
      forward_first = one.first;
      backward_first = other.first;
      ++a;
      --b;
    } while ((kComeFirst ? a < b : a < runs && b >= 0) && isNarrow(row, a) && isNarrow(row, b));
    storePair(d, goodness, forward_.goodness, backward_.goodness);
    forward_.window = row.windows + a - 1;
    backward_.window = row.windows + b + 1;
    i = a;
    j = b;
  }

  /// The vertical path alone.
  HWY_INLINE void followVerticals(int begin_run, int end_run) {
    const ReducedSearchRow row = row_;
    for (int i = begin_run; i < end_run; ++i) followVertical(row, i, row.sums_before);
  }

  static HWY_INLINE void matchNarrow(const ReducedSearchRow& row, int run, const WindowRun& window,
                                     const BitCounter<RunBytes>& counter) {
    const RunBytes d;
    const int x = run * kWindowRun;
    const auto words = hn::LoadDup128(d, reinterpret_cast<const uint8_t*>(row.left_words + x));
    const uint8_t* const right = row.right_bytes + (row.columns - 1 - x + window.first);
    for (int k = 0; k < kWindowRun; k += kPixelsOfVector) {
      hn::Vec<RunBytes> differing[kCensusBytes];
      for (int b = 0; b < kCensusBytes; ++b) {
        const auto left =
            hn::TableLookupBytes(words, hn::Load(d, kSpreadWord.of_byte[b] + k * kLanes));
        differing[b] = hn::Xor(left, loadDescending(d, right + b * row.right_stride - k));
      }
      hn::StoreU(counter.count(differing), d, row.costs + window.position + k * kLanes);
    }
  }

  /// The vertical path of a run. The pixels of a whole narrow run do not depend on each other, and
  /// fill registers of any width.
  HWY_INLINE void followVertical(const ReducedSearchRow& row, int run, const uint8_t* sums_before) {
    const WindowRun* const above = row.previous_windows;
    if (HWY_UNLIKELY(!isNarrow(row, run) || !above || above[run].width != kLanes))
      return visit(run, {false, nullptr, true, sums_before, row.sums});
    const RunBytes d;
    const auto p1 = p1_, p2 = p2_;
    const WindowRun window = row.windows[run];
    const uint8_t* const goodness = row.previous.straight + above[run].position;
    const auto shuffles = shufflesBy(d, window.first - above[run].first);
    const auto floors = hn::LoadDup128(d, row.floors_down + run * kWindowRun);
    for (int i = 0; i < kWindowRun * kLanes; i += kPixelsOfVector * kLanes) {
      const int at = window.position + i;
      const auto floor = hn::TableLookupBytes(floors, hn::Load(d, kSpreadByte.of_byte[0] + i));
      const auto path = pathCost(hn::LoadU(d, row.costs + at),
                                 shuffled(hn::LoadU(d, goodness + i), shuffles), p1, floor);
      hn::StoreU(goodnessOf(d, path, p2), d, row.next.straight + at);
      hn::StoreU(hn::SaturatedAdd(hn::LoadU(d, sums_before + at), path), d, row.sums + at);
    }
  }

  // --- Any paths and windows ----------------------------------------------------------------

  void visit(int run, const Visit& visit) {
    const WindowRun& window = row_.windows[run];
    if (window.width == kLanes)
      visitRun<1>(d_, run, window, visit);
    else if (window.width == kWideLanes)
      visitRun<1>(WideBytes(), run, window, visit);
    else if (window.width == 2 * kWideLanes)
      visitRun<2>(WideBytes(), run, window, visit);
    else if (window.width == 4 * kWideLanes)
      visitRun<4>(WideBytes(), run, window, visit);
    else if (window.width % kWideLanes == 0 && window.width > 0)
      visitRun<0>(WideBytes(), run, window, visit);
    else if (window.width > 0)
      visitRun<0>(d_, run, window, visit);
    else if (visit.walker)
      visit.walker->window = &kNoWindow;
  }

  /// kVectors: number of vectors of a window; 0: not known at compile time.
  template <int kVectors, class D>
  HWY_NOINLINE void visitRun(D d, int run, const WindowRun& run_window, const Visit& visit_of_run) {
    using Window = WindowPaths<D, kVectors>;
    constexpr int kLanesOfD = hn::MaxLanes(D());
    const ReducedSearchRow row = row_;
    const Visit visit = visit_of_run;
    const WindowRun window = run_window;
    const Window paths(window, row.p1, row.p2);
    const BitCounter<D> counter(row.p2);
    const int pixels = std::min(kWindowRun, row.columns - run * kWindowRun);
    const bool backward = visit.walker && visit.walker->backward;
    typename Window::Passed along, carried;
    typename Window::Vectors costs, sums, goodness;
    paths.carry(visit.walker ? visit.walker->here() : Neighbour{nullptr, 0, 0}, along);
    for (int i = 0; i < pixels; ++i) {
      const int k = backward ? pixels - 1 - i : i;
      const int x = run * kWindowRun + k, at = window.position + k * window.width;
      for (int v = 0; v < paths.vectors(); ++v) {
        const int index = v * kLanesOfD;
        costs[v] = visit.matches
                       ? matchingCosts(d, row, x, window.first + index, at + index, counter)
                       : hn::LoadU(d, row.costs + at + index);
        sums[v] = hn::Zero(d);
      }
      if (visit.walker) {
        paths.step(costs, along, row.floors_across[backward ? x + 1 : x], sums, goodness);
        paths.carrySameWindow(goodness, along);
        if (i == pixels - 1) paths.store(goodness, visit.walker->goodness);
      }
      const auto follow = [&](const Neighbour& neighbour, uint8_t floor, uint8_t* next) HWY_ATTR {
        typename Window::Vectors passed_on;
        paths.carry(neighbour, carried);
        paths.step(costs, carried, floor, sums, passed_on);
        paths.store(passed_on, next + at);
      };
      if (visit.from_previous_row) {
        const int step = row.upward ? -1 : 1;
        const uint8_t down = row.floors_down[x];
        if constexpr (kStraight)
          follow(inPreviousRow(row, x, row.previous.straight), down, row.next.straight);
        if constexpr (kDiagonal) {
          const uint8_t behind = row.floors_across[row.upward ? x + 1 : x];
          const uint8_t ahead = row.floors_across[row.upward ? x : x + 1];
          follow(inPreviousRow(row, x - step, row.previous.from_behind), std::max(behind, down),
                 row.next.from_behind);
          follow(inPreviousRow(row, x + step, row.previous.from_ahead), std::max(ahead, down),
                 row.next.from_ahead);
        }
      }
      for (int v = 0; v < paths.vectors(); ++v) {
        const int bytes = at + v * kLanesOfD;
        if (visit.sums_before)
          sums[v] = joinPasses < kStraight &&
                    kDiagonal > (sums[v], hn::LoadU(d, visit.sums_before + bytes));
        hn::StoreU(sums[v], d, visit.sums + bytes);
      }
    }
    if (visit.walker) visit.walker->window = row.windows + run;
  }

  static HWY_INLINE Neighbour inPreviousRow(const ReducedSearchRow& row, int x,
                                            const uint8_t* goodness) {
    if (!row.previous_windows || x < 0 || x >= row.columns) return {nullptr, 0, 0};
    const WindowRun window = row.previous_windows[x / kWindowRun];
    return {goodness + window.position + x % kWindowRun * window.width, window.first, window.width};
  }

  /// Hamming distances + P2 of the disparities from `index` on, stored for the second visit.
  template <class D>
  static HWY_INLINE hn::Vec<D> matchingCosts(D d, const ReducedSearchRow& row, int x, int index,
                                             int place, const BitCounter<D>& counter) {
    const auto left = static_cast<unsigned>(row.left_words[x]);
    const uint8_t* const right = row.right_bytes + (row.columns - 1 - x + index);
    hn::Vec<D> differing[kCensusBytes];
    for (int b = 0; b < kCensusBytes; ++b)
      differing[b] = hn::Xor(hn::Set(d, static_cast<uint8_t>(left >> (8 * b))),
                             hn::LoadU(d, right + b * row.right_stride));
    const hn::Vec<D> costs = counter.count(differing);
    hn::StoreU(costs, d, row.costs + place);
    return costs;
  }

  const Bytes16 d_{};
  const RunBytes run_d_{};
  const ReducedSearchRow row_;
  const hn::Vec<RunBytes> p1_, p2_;
  const int runs_;
  Walker forward_{false}, backward_{true};
};

void AggregateReducedRow(const ReducedSearchRow& row) {
  if (row.paths == PathSet::kStraight4) RowAggregation<true, false>(row).run();
  if (row.paths == PathSet::kDiagonal4) RowAggregation<false, true>(row).run();
  if (row.paths == PathSet::kAll8) RowAggregation<true, true>(row).run();
}

#else
void AggregateReducedRow(const ReducedSearchRow&) {}
#endif

PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {

HWY_EXPORT(AggregateReducedRow);

ReducedSearchRowFunction reducedSearchRow(int64_t simd_target) {
  return PREDICTIVE_STEREO_DISPATCH(AggregateReducedRow, simd_target);
}

}  // namespace predictive_stereo
#endif
