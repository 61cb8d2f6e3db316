#include "matching/reference_sgm.h"

#include <algorithm>
#include <bitset>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "matching/census.h"

namespace predictive_stereo {
namespace {

using std::uint8_t;

constexpr int kNoDisparity = -1000;  // fails every left-right check

/// Equi-angular fit to the lowest aggregated cost and its two neighbours: both flanks get the slope
/// of the steeper one, which suits costs that grow linearly. Within [-0.5, 0.5] px.
float subpixelOffset(int below, int cost, int above) {
  const int steeper = std::max(below, above) - cost;
  return static_cast<float>(below - above) / static_cast<float>(std::max(2 * steeper, 1));
}

/// The disparity of a sub-pixel winner, see PrincipalOffset: what remains below the range counts as
/// its lowest disparity, as it does without an offset, where that one is the nearest to it.
float withoutFraction(float winner_px, float fraction_px, int lowest_px) {
  return std::max(winner_px - fraction_px, static_cast<float>(lowest_px));
}

/// See Match::ambiguity. For such small integers the single-precision quotient truncates correctly.
uint8_t ambiguity(int cost, int runner_up) {
  const int ratio =
      static_cast<int>(static_cast<float>(255 * cost) / static_cast<float>(std::max(runner_up, 1)));
  return static_cast<uint8_t>(runner_up == 0 ? 255 : ratio);
}

/// The lowest aggregated cost of a pixel.
struct Winner {
  int index;  ///< the smallest of equals
  int cost;
  int below, above;  ///< costs of its neighbours; only if `inside`
  bool inside;       ///< both neighbours are in the pixel's window
  bool has_second;   ///< whether there are costs with |index difference| > 1
  int runner_up;     ///< the lowest of these; only if `has_second`
};

/// Aggregation of one image pair. Disparities are indices here: 0 is min_disparity.
class ReferenceSgm {
 public:
  ReferenceSgm(const cv::Mat1b& left, const cv::Mat1b& right, const MatcherParams& params,
               const PrincipalOffset& offset, const SearchWindows& windows)
      : params_(params),
        fraction_px_(offset.fraction_px),
        first_shift_(offset.columnShifts(params.range).min_disparity),
        windows_(windows),
        size_(left.size()),
        count_(params.range.count),
        left_(left),
        sums_(left.total() * params.range.count, 0),
        upward_sums_(sums_) {
    censusReference(left, params.census, left_census_);
    censusReference(right, params.census, right_census_);
  }

  void aggregate() {
    if (params_.paths != PathSet::kDiagonal4)
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}})
        aggregatePath(dx, dy);
    if (params_.paths != PathSet::kStraight4)
      for (const auto& [dx, dy] : {std::pair(1, 1), {-1, -1}, {-1, 1}, {1, -1}})
        aggregatePath(dx, dy);
    const bool halve = params_.paths == PathSet::kAll8;
    std::transform(sums_.begin(), sums_.end(), upward_sums_.begin(), sums_.begin(),
                   [&](int down, int up) { return joinPasses(down, up, halve); });
  }

  void chooseWinners(Match& match) const {
    std::vector<int> right_indices;
    for (int y = 0; y < size_.height; ++y) {
      chooseRightWinners(y, right_indices);
      for (int x = 0; x < size_.width; ++x) describe(x, y, right_indices, match);
    }
  }

 private:
  /// Hamming distance; columns outside the right image repeat its border.
  int cost(int x, int y, int index) const {
    const int right_x = std::clamp(x - first_shift_ - index, 0, size_.width - 1);
    return static_cast<int>(
        std::bitset<32>(left_census_(y, x) ^ right_census_(y, right_x)).count());
  }

  /// Eq. 1 along the path that steps by (dx, dy). A path's costs L are stored as goodness
  /// G = max(P2 - (L - min L), 0), which is all that a step passes on. Disparities outside a
  /// pixel's window have G = 0: the next pixel pays P2 to reach them.
  void aggregatePath(int dx, int dy) {
    // One more disparity on both sides with G = 0: no check whether a neighbour exists.
    const int stride = count_ + 2;
    std::vector<uint8_t> current(size_.width * stride), previous(current.size());
    for (int row = 0; row < size_.height; ++row) {
      const int y = dy < 0 ? size_.height - 1 - row : row;
      std::swap(current, previous);
      for (int column = 0; column < size_.width; ++column) {
        const int x = dx < 0 ? size_.width - 1 - column : column;
        const auto& neighbours = dy == 0 ? current : previous;
        const bool starts = !hasWindow(x - dx, y - dy);
        const uint8_t* neighbour = starts ? nullptr : &neighbours[(x - dx) * stride + 1];
        auto& sums = dx + 2 * dy > 0 ? sums_ : upward_sums_;
        const int floor = std::max(floorTo(x, y, -dx, 0), floorTo(x, y, 0, -dy));
        step(x, y, neighbour, floor, &current[x * stride + 1], &sums[offsetOf(x, y)]);
      }
    }
  }

  /// Entry of JumpFloors between a pixel and its neighbour in the direction (dx, dy).
  int floorTo(int x, int y, int dx, int dy) const {
    const auto grey = [&](int steps) -> int {
      return left_(std::clamp(y + steps * dy, 0, size_.height - 1),
                   std::clamp(x + steps * dx, 0, size_.width - 1));
    };
    const int step = std::min(std::abs(grey(0) - grey(1)), std::abs(grey(-2) - grey(3)));
    const bool is_edge = params_.edge_step > 0 && step >= params_.edge_step;
    return is_edge ? std::max(params_.p2 - params_.p2_edge, 0) : 0;
  }

  /// One pixel of a path. neighbour = nullptr: the path starts here.
  void step(int x, int y, const uint8_t* neighbour, int floor, uint8_t* goodness, uint8_t* sums) {
    const WindowRun& window = windowOf(x, y);
    const int first = window.first, end = first + window.width;
    int path_costs[256], lowest = 255;
    for (int i = first; i < end; ++i) {
      int carried = params_.p2;
      if (neighbour)
        carried =
            std::max<int>(neighbour[i], std::max(neighbour[i - 1], neighbour[i + 1]) - params_.p1);
      path_costs[i] = cost(x, y, i) + params_.p2 - std::max(carried, floor);
      lowest = std::min(lowest, path_costs[i]);
    }
    std::fill(goodness, goodness + count_, uint8_t{0});
    for (int i = first; i < end; ++i) {
      goodness[i] = static_cast<uint8_t>(std::max(params_.p2 - (path_costs[i] - lowest), 0));
      sums[i] = static_cast<uint8_t>(std::min(sums[i] + path_costs[i], 255));
    }
  }

  /// Sums of 8 paths are halved: see path_step-inl.h.
  static uint8_t joinPasses(int down, int up, bool halve) {
    return static_cast<uint8_t>(halve ? (down + up + 1) / 2 : std::min(down + up, 255));
  }

  /// The right image's winners, searched along the diagonals of the left image's sums. Of equal
  /// sums the smallest disparity wins, which comes first.
  void chooseRightWinners(int y, std::vector<int>& indices) const {
    std::vector<int> lowest(size_.width, 255);  // saturated sums cannot win
    indices.assign(size_.width, kNoDisparity);
    for (int x = 0; x < size_.width; ++x) {
      const uint8_t* sums = sumsOf(x, y);
      const int first = windowOf(x, y).first, end = first + windows_.width(y, x);
      for (int index = first; index < end; ++index) {
        const int right_x = x - first_shift_ - index;
        if (right_x < 0 || right_x >= size_.width || sums[index] >= lowest[right_x]) continue;
        lowest[right_x] = sums[index];
        indices[right_x] = index;
      }
    }
  }

  Winner findWinner(int x, int y) const {
    const WindowRun& window = windowOf(x, y);
    const int first = window.first, end = first + window.width;
    const uint8_t* sums = sumsOf(x, y);
    Winner winner{};
    winner.index = static_cast<int>(std::min_element(sums + first, sums + end) - sums);
    winner.cost = sums[winner.index];
    winner.inside = winner.index > first && winner.index < end - 1;
    if (winner.inside) {
      winner.below = sums[winner.index - 1];
      winner.above = sums[winner.index + 1];
    }
    winner.runner_up = 255;
    for (int i = first; i < end; ++i) {
      if (std::abs(i - winner.index) <= 1) continue;
      winner.has_second = true;
      winner.runner_up = std::min<int>(winner.runner_up, sums[i]);
    }
    return winner;
  }

  void describe(int x, int y, const std::vector<int>& right_indices, Match& match) const {
    match.disparity_px(y, x) = params_.range.invalid();
    match.ambiguity(y, x) = 255;
    if (windows_.width(y, x) == 0) return;

    const Winner winner = findWinner(x, y);
    int difference = 0;  // of left and right
    if (params_.left_right_tolerance_px >= 0) {
      const int right_x = x - first_shift_ - winner.index;
      if (right_x < 0 || right_x >= size_.width) return;
      difference = std::abs(right_indices[right_x] - winner.index);
      if (difference > params_.left_right_tolerance_px) return;
    }
    if (winner.has_second && difference <= 1)
      match.ambiguity(y, x) = ambiguity(winner.cost, winner.runner_up);
    const int lowest_px = params_.range.min_disparity;
    auto disparity_px = static_cast<float>(lowest_px + winner.index);
    if (winner.inside) disparity_px += subpixelOffset(winner.below, winner.cost, winner.above);
    match.disparity_px(y, x) = withoutFraction(disparity_px, fraction_px_, lowest_px);
  }

  const WindowRun& windowOf(int x, int y) const { return windows_.row(y)[x / windows_.run_length]; }
  bool hasWindow(int x, int y) const {
    const bool inside = x >= 0 && x < size_.width && y >= 0 && y < size_.height;
    return inside && windowOf(x, y).width > 0;
  }
  size_t offsetOf(int x, int y) const {
    return (static_cast<size_t>(y) * size_.width + x) * count_;
  }
  const uint8_t* sumsOf(int x, int y) const { return &sums_[offsetOf(x, y)]; }

  const MatcherParams& params_;
  const float fraction_px_;
  const int first_shift_;  ///< x_left - x_right at index 0
  const SearchWindows& windows_;
  const cv::Size size_;
  const int count_;
  const cv::Mat1b left_;
  cv::Mat1i left_census_, right_census_;
  /// Saturating sums over the paths of the downward pass (finally of both passes) and of the upward
  /// pass: [y][x][index].
  std::vector<uint8_t> sums_, upward_sums_;
};

}  // namespace

void matchReference(const cv::Mat1b& left, const cv::Mat1b& right, const MatcherParams& params,
                    const PrincipalOffset& offset, const SearchWindows& windows, Match& match) {
  match.disparity_px.create(left.size());
  match.ambiguity.create(left.size());
  ReferenceSgm sgm(left, right, params, offset, windows);
  sgm.aggregate();
  sgm.chooseWinners(match);
}

}  // namespace predictive_stereo
