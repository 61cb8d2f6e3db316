/// Largest number of candidates per frame, which bounds the time. Crowds and foliage have about 5
/// across the line of sight and 20 along it; the largest ones come first.
#pragma once

#include <optional>
#include <type_traits>
#include <vector>

namespace predictive_stereo {

constexpr size_t kMostAcross = 8, kMostAlong = 12;

/// The first `most` results of `make`; further items are not used.
/// @param make  called with an item; returns a std::optional.
template <class Items, class Make>
auto firstResults(size_t most, const Items& items, const Make& make) {
  std::vector<typename std::invoke_result_t<Make, decltype(*items.begin())>::value_type> made;
  for (const auto& item : items) {
    if (made.size() == most) break;
    if (auto one = make(item)) made.push_back(std::move(*one));
  }
  return made;
}

}  // namespace predictive_stereo
