/// Statistics that several evaluations need.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace predictive_stereo {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

/// A share; `otherwise` of nothing.
template <class Part, class Whole>
double ratio(Part part, Whole whole, double otherwise = 0) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : otherwise;
}

/// Moves the mean of `count` values to that of `count` + 1.
inline void updateMean(double& mean, double value, int count) {
  mean += (value - mean) / (count + 1);
}

/// `otherwise` without values.
inline double mean(const std::vector<double>& values, double otherwise = 0) {
  double sum = 0;
  for (const double value : values) sum += value;
  return ratio(sum, values.size(), otherwise);
}

/// The value whose rank is nearest to this share of the values; `otherwise` without values.
inline double nearestQuantile(std::vector<double> values, double share, double otherwise = 0) {
  if (values.empty()) return otherwise;
  const auto at = values.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The upper one of two; NaN without values.
inline double median(std::vector<double> values) {
  return nearestQuantile(std::move(values), 0.5, kNotKnown);
}

/// Number, mean and variance of values, without storing them.
class Moments {
 public:
  void add(double value) {
    ++count_;
    sum_ += value;
    sum_squares_ += value * value;
  }
  Moments& operator+=(const Moments& other) {
    count_ += other.count_;
    sum_ += other.sum_;
    sum_squares_ += other.sum_squares_;
    return *this;
  }
  int64_t count() const { return count_; }
  /// 0 without values, and so are the following.
  double mean() const { return ratio(sum_, count_); }
  double variance() const { return ratio(sum_squares_, count_) - mean() * mean(); }

 private:
  int64_t count_ = 0;
  double sum_ = 0, sum_squares_ = 0;
};

}  // namespace predictive_stereo
