#include "detection/suspicion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "detection/constants.h"
#include "detection/patches.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kTextureSide = 5;  // of the squares over which texture is summed
constexpr int kCell = 4;         // side of a cell [lattice points]
constexpr int kMargin = 5;       // lattice points along the border that are left out
static_assert(kMargin >= 2 * (kTextureSide / 2), "texture is not known closer to the border");

// The first point of a cell with the largest mismatch relative to its texture, if this is at least
// `least`. Divides only where it is.
std::optional<cv::Point> mostSuspicious(const cv::Mat1f& texture, const cv::Mat1f& mismatch,
                                        cv::Point first, float least) {
  std::optional<cv::Point> worst;
  float most = least;
  for (int v = first.y; v < first.y + kCell; ++v) {
    const float *const of_texture = texture[v], *const of_mismatch = mismatch[v];
    for (int u = first.x; u < first.x + kCell; ++u) {
      const float noise = of_texture[u] + kGreyNoise;
      if (!(of_mismatch[u] >= most * noise)) continue;
      const float suspicion = of_mismatch[u] / noise;
      if (worst && suspicion <= most) continue;
      most = suspicion;
      worst = cv::Point(u, v);
    }
  }
  return worst;
}

// Whether most pixels around a pixel have a similar disparity.
bool isWithinSurface(const FrameView& frame, cv::Point p) {
  const cv::Mat1f& disparity_px = frame.input.measured_disparity_px;
  const float d = disparity_px(p);
  int alike = 0;
  for (int dy = -kAround_px; dy <= kAround_px; dy += kAround_px)
    for (int dx = -kAround_px; dx <= kAround_px; dx += kAround_px) {
      const float other = disparity_px(p.y + dy, p.x + dx);
      alike += frame.range.isValid(other) &&
               std::abs(other - d) <= kDisparityError_px + kSameSurface * d;
    }
  return alike >= kFewestOfNine;
}

// Whether a static point was occluded in the past frame: at its position there was a surface so
// much nearer that it cannot be the same one, even if it moves with the camera.
bool wasHidden(const PastView& view, cv::Point pixel) {
  const cv::Mat1f& past_px = view.past.frame->disparity_px;
  const Eigen::Vector3f from = view.staticSource(pixel);
  const int x = cvRound(from.x()), y = cvRound(from.y());
  if (!(from.z() > 0) || x < 0 || y < 0 || x >= past_px.cols || y >= past_px.rows) return false;
  const auto disparity_times_depth = static_cast<float>(view.rig().disparityTimesDepth());
  const auto nearer_m = static_cast<float>(view.params().largest_speed_mps * view.past.seconds);
  const float before = past_px(y, x);
  const float hiding_m = disparity_times_depth / from.z() - nearer_m;
  return view.isKnown(before) && before > from.z() + kDisparityError_px &&
         before * hiding_m > disparity_times_depth;
}

bool isExplained(const PastView& view, cv::Point p) {
  const float own = view.disparity_px()(p);
  const GreyPatch now(view.images().level(1), 0.5f * static_cast<float>(p.x),
                      0.5f * static_cast<float>(p.y));
  const cv::Mat1b& previous = view.past_images().level(1);
  const auto explains = [&](float disparity) {
    const Eigen::Vector3f from =
        view.static_source(static_cast<float>(p.x), static_cast<float>(p.y), disparity);
    return now.differenceFrom(previous, 0.5f * from.x(), 0.5f * from.y(), 1,
                              GreyPatch::Brightness::kMayDiffer) < kMostDifference;
  };
  for (float error : {0.0f, kDisparityError_px, -kDisparityError_px})
    if (own + error > 0 && explains(own + error)) return true;
  for (int dy = -kAround_px; dy <= kAround_px; dy += kAround_px)
    for (int dx = -kAround_px; dx <= kAround_px; dx += kAround_px) {
      const float other = view.disparity_px()(p.y + dy, p.x + dx);
      if (view.isKnown(other) && other > 0 && std::abs(other - own) > kDisparitySigma_px &&
          explains(other))
        return true;
    }
  return false;
}

}  // namespace

void greyTexture(const cv::Mat1b& grey, cv::Mat1f& texture) {
  const cv::Size square(kTextureSide, kTextureSide);
  cv::Mat1b deviation;
  cv::blur(grey, deviation, square);
  cv::absdiff(grey, deviation, deviation);
  cv::boxFilter(deviation, texture, CV_32F, square);
}

Suspects findSuspects(const FrameView& frame, const cv::Mat1f& texture, const cv::Mat1f& mismatch) {
  const int rows = std::max(texture.rows - 2 * kMargin, 0) / kCell;
  const int columns = std::max(texture.cols - 2 * kMargin, 0) / kCell;
  std::vector<int> cells_of_row(static_cast<size_t>(rows), 0);
  std::vector<std::vector<cv::Point>> points_of_row(cells_of_row.size());
  const auto least = static_cast<float>(frame.params.min_mismatch);
  parallelForEach(rows, [&](int row) {
    const auto r = static_cast<size_t>(row);
    for (int column = 0; column < columns; ++column) {
      const cv::Point first(kMargin + kCell * column, kMargin + kCell * row);
      const auto worst = mostSuspicious(texture, mismatch, first, least);
      if (!worst) continue;
      ++cells_of_row[r];
      if (frame.obstacles.standing(*worst) && isWithinSurface(frame, 2 * *worst))
        points_of_row[r].push_back(2 * *worst);
    }
  });
  Suspects suspects;
  const int suspicious = std::accumulate(cells_of_row.begin(), cells_of_row.end(), 0);
  suspects.share = static_cast<double>(suspicious) / std::max(rows * columns, 1);
  for (const auto& of_row : points_of_row)
    suspects.points_px.insert(suspects.points_px.end(), of_row.begin(), of_row.end());
  return suspects;
}

std::vector<cv::Point> unexplainedPoints(const PastView& view,
                                         const std::vector<cv::Point>& points_px) {
  const size_t step = (points_px.size() + kMostSuspects - 1) / kMostSuspects;
  std::vector<uint8_t> unexplained(step ? (points_px.size() + step - 1) / step : 0);
  parallelForEach(static_cast<int>(unexplained.size()), [&](int i) {
    const cv::Point p = points_px[step * static_cast<size_t>(i)];
    const float d = view.disparity_px()(p);
    unexplained[static_cast<size_t>(i)] =
        view.isKnown(d) && d > 0 && !wasHidden(view, p) && !isExplained(view, p);
  });
  std::vector<cv::Point> kept;
  for (size_t i = 0; i < unexplained.size(); ++i)
    if (unexplained[i]) kept.push_back(points_px[step * i]);
  return kept;
}

}  // namespace predictive_stereo
