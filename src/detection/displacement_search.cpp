#include "detection/displacement_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace predictive_stereo {
namespace {

constexpr size_t kMostPoints = 160;
constexpr int kReachX = 40, kReachY = 6;  // lattice points
constexpr int kCoarse = 2;                // lattice points between coarse trials
constexpr size_t kFewestPoints = 12;

struct Sample {
  float grey;
  int x, y;  // lattice, of the static source
};

// Mean |difference| after the mean difference is taken away; infinity where too many points leave
// the image.
float mismatchAt(const cv::Mat1b& previous, const std::vector<Sample>& samples, int dx, int dy,
                 std::vector<float>& differences) {
  differences.clear();
  float sum = 0;
  for (const Sample& s : samples) {
    const int x = s.x + dx, y = s.y + dy;
    if (x < 0 || y < 0 || x >= previous.cols || y >= previous.rows) continue;
    differences.push_back(s.grey - static_cast<float>(previous(y, x)));
    sum += differences.back();
  }
  if (3 * differences.size() < 2 * samples.size()) return std::numeric_limits<float>::infinity();
  const float mean = sum / static_cast<float>(differences.size());
  float total = 0;
  for (float d : differences) total += std::abs(d - mean);
  return total / static_cast<float>(differences.size());
}

}  // namespace

std::optional<cv::Point> searchShift(const ImagePyramid& current, const ImagePyramid& previous,
                                     const SourceOf& static_source, const cv::Mat1f& disparity_px,
                                     const std::vector<cv::Point>& points) {
  const cv::Mat1b& image = previous.level(1);
  const auto right = static_cast<float>(image.cols - 1),
             bottom = static_cast<float>(image.rows - 1);
  std::vector<Sample> samples;
  const size_t step = points.size() / (kMostPoints + 1) + 1;
  for (size_t i = 0; i < points.size(); i += step) {
    const cv::Point pixel = 2 * points[i];
    const Eigen::Vector3f at = static_source(static_cast<float>(pixel.x),
                                             static_cast<float>(pixel.y), disparity_px(pixel));
    const float x = 0.5f * at.x(), y = 0.5f * at.y();
    if (!(x >= 0 && y >= 0 && x < right && y < bottom && at.z() > 0)) continue;
    samples.push_back({static_cast<float>(current.level(1)(points[i])), cvRound(x), cvRound(y)});
  }
  if (samples.size() < kFewestPoints) return std::nullopt;
  std::vector<float> work;
  float best = std::numeric_limits<float>::infinity(), sum = 0;
  int tried = 0;
  cv::Point at;
  const auto attempt = [&](int dx, int dy) {
    const float m = mismatchAt(image, samples, dx, dy, work);
    if (!std::isfinite(m)) return;
    sum += m;
    ++tried;
    if (m < best) best = m, at = {dx, dy};
  };
  for (int dy = -kReachY; dy <= kReachY; dy += kCoarse)
    for (int dx = -kReachX; dx <= kReachX; dx += kCoarse) attempt(dx, dy);
  if (tried == 0 || best > 0.7f * sum / static_cast<float>(tried)) return std::nullopt;
  const cv::Point coarse = at;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) attempt(coarse.x + dx, coarse.y + dy);
  return cv::Point(2 * at.x, 2 * at.y);
}

}  // namespace predictive_stereo
