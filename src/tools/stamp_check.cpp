#include <cmath>
#include <limits>

#include "nodelets/nodelet_params.h"
#include "predictive_stereo/sequence_guard.h"
#include "tools/bag_check.h"

namespace predictive_stereo {
namespace {

constexpr double kSlow_hz = 5;
constexpr double kLargestGap_s = 1.0;

// Largest distance between a stamp of `a` and the nearest one of `b`, without the worst 5 %:
// single lost messages do not mean that the streams are not synchronised.
double stampDistance(const StampStream& a, const StampStream& b) {
  std::vector<ros::Time> sorted = b.stamps;
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> distances;
  for (const ros::Time& stamp : a.stamps) {
    const auto next = std::lower_bound(sorted.begin(), sorted.end(), stamp);
    double nearest = std::numeric_limits<double>::infinity();
    if (next != sorted.end()) nearest = std::abs((*next - stamp).toSec());
    if (next != sorted.begin())
      nearest = std::min(nearest, std::abs((stamp - *(next - 1)).toSec()));
    distances.push_back(nearest);
  }
  std::sort(distances.begin(), distances.end());
  return distances[static_cast<size_t>(0.95 * static_cast<double>(distances.size() - 1))];
}

void checkSynchronisation(const std::vector<StampStream>& streams, double period_s,
                          BagCheck& result) {
  const SyncParams defaults;
  double largest_s = 0;
  for (size_t i = 1; i < streams.size(); ++i) {
    if (i > 1 && streams[i].unstamped()) continue;  // one calibration for all images
    const double distance_s = stampDistance(streams[0], streams[i]);
    largest_s = std::max(largest_s, distance_s);
    if (distance_s < 0.5 * period_s) continue;
    result.fault(
        streams[i].topic +
        cv::format(": its stamps differ from those of the left images by %.3f s, half the time "
                   "between two frames (%.3f s) or more: ",
                   distance_s, period_s) +
        (i == 1 ? "the cameras are not synchronised; trigger them together"
                : "each image needs a camera_info with its stamp, or one whose stamp is always 0"));
    return;
  }
  if (largest_s == 0) {
    result.good("stamps of both cameras are equal");
  } else if (largest_s <= defaults.sync_tolerance) {
    result.good(
        cv::format("stamps of both cameras differ by up to %.2f ms: approximate_sync, which is the "
                   "default, is needed",
                   1e3 * largest_s));
  } else {
    const double tolerance_s = std::min(0.49 * period_s, 1.2 * largest_s);
    result.arguments.push_back(cv::format("sync_tolerance:=%.4f", tolerance_s));
    result.advice(cv::format(
        "stamps of both cameras differ by up to %.1f ms: give sync_tolerance:=%.4f; fast "
        "motion makes disparities wrong",
        1e3 * largest_s, tolerance_s));
  }
}

}  // namespace

void checkStamps(const std::vector<StampStream>& streams, BagCheck& result) {
  for (size_t i = 0; i < 2; ++i)
    if (streams[i].unstamped()) {
      result.fault(streams[i].topic +
                   " has stamps of zero: the camera driver must stamp its images");
      return;
    }
  std::vector<ros::Time> left = streams[0].stamps;
  left.erase(std::unique(left.begin(), left.end()), left.end());
  if (const size_t repeated = streams[0].stamps.size() - left.size())
    result.advice(cv::format(
        "%zu left images have the stamp of the one before, and are ignored: was the topic recorded "
        "twice, or does the driver send frames twice?",
        repeated));
  if (left.size() < 2) {
    result.advice("the bag has fewer than two left images: prediction needs at least two");
    return;
  }
  std::vector<double> periods;
  size_t late = 0, backward = 0, gaps = 0;
  for (size_t i = 1; i < left.size(); ++i) {
    const double period = (left[i] - left[i - 1]).toSec();
    if (period < 0) ++(period < -SequenceGuard::kLargestDelay_s ? backward : late);
    if (period > kLargestGap_s) ++gaps;
    periods.push_back(period);
  }
  std::nth_element(periods.begin(), periods.begin() + periods.size() / 2, periods.end());
  const double period_s = periods[periods.size() / 2];
  const double rate_hz = period_s > 0 ? 1 / period_s : 0;
  result.good(cv::format("%zu left images in the first %.1f s, %.1f Hz", left.size(),
                         (left.back() - left.front()).toSec(), rate_hz));
  if (late)
    result.advice(
        cv::format("%zu left images are older than the one before, and are ignored: the "
                   "camera driver must send them in the order of their stamps",
                   late));
  if (backward)
    result.advice(cv::format("stamps go back %zu times: all nodelets reset there", backward));
  if (gaps)
    result.advice(cv::format("%zu gaps of more than max_gap = %g s: all nodelets reset after them",
                             gaps, kLargestGap_s));
  if (rate_hz < kSlow_hz)
    result.advice(cv::format(
        "%.1f Hz is slow: the prediction gets worse with the camera's motion between two "
        "frames; record at a higher rate",
        rate_hz));
  checkSynchronisation(streams, period_s, result);
}

}  // namespace predictive_stereo
