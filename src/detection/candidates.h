/// How many candidates a frame looks at, so that its time is bounded. Crowds and foliage have 5
/// across the line of sight and 20 along it; the largest come first.
#pragma once

#include <optional>
#include <type_traits>
#include <vector>

namespace predictive_stereo {

constexpr size_t kMostAcross = 8, kMostAlong = 12;

/// What `make` makes of the first items that it makes something of; the rest is not looked at.
/// @param make  returns a std::optional.
template <class Items, class Make>
auto firstFew(size_t most, const Items& items, const Make& make) {
  std::vector<typename std::invoke_result_t<Make, decltype(*items.begin())>::value_type> made;
  for (const auto& item : items) {
    if (made.size() == most) break;
    if (auto one = make(item)) made.push_back(std::move(*one));
  }
  return made;
}

}  // namespace predictive_stereo
