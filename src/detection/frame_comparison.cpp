#include "detection/frame_comparison.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {
namespace {

constexpr int kWindow = 5;
constexpr float kFewestKnown = 0.5f * kWindow * kWindow;
constexpr float kNearestDisparity = 0.5f;  // farther points tell nothing of motion

void boxSum(const cv::Mat1f& in, cv::Mat1f& out) {
  cv::boxFilter(in, out, CV_32F, {kWindow, kWindow}, {-1, -1}, false, cv::BORDER_CONSTANT);
}

}  // namespace

void compareFrames(const ImagePyramid& current, const cv::Mat1f& disparity_px,
                   const DisparityRange& range, const ImagePyramid& previous,
                   const SourceOf& source_of, const cv::Rect& area, Comparison& comparison,
                   cv::Mat3f* source) {
  comparison.area = area;
  const cv::Mat1b& now = current.level(1);
  const cv::Mat1b& before = previous.level(1);
  comparison.difference.create(area.size());
  comparison.known.create(area.size());
  if (source) source->create(area.size());
  const float smallest = std::max(static_cast<float>(range.min_disparity), kNearestDisparity);
  const auto last_x = static_cast<float>(before.cols - 1),
             last_y = static_cast<float>(before.rows - 1);
  cv::parallel_for_(cv::Range(0, area.height), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      const int y = 2 * (area.y + v);
      const float* disparity = disparity_px[y];
      const uchar* grey = now[area.y + v];
      for (int u = 0; u < area.width; ++u) {
        const int x = 2 * (area.x + u);
        const float d = disparity[x];
        float difference = 0, known = 0;
        Eigen::Vector3f at(0, 0, -1);
        if (d >= smallest) {
          at = source_of(static_cast<float>(x), static_cast<float>(y), d);
          const float sx = 0.5f * at.x(), sy = 0.5f * at.y();
          if (sx >= 0 && sy >= 0 && sx < last_x && sy < last_y && at.z() > 0) {
            const int ix = static_cast<int>(sx), iy = static_cast<int>(sy);
            const float fx = sx - static_cast<float>(ix), fy = sy - static_cast<float>(iy);
            const uchar* upper = before[iy] + ix;
            const uchar* lower = before[iy + 1] + ix;
            const float top = upper[0] + fx * static_cast<float>(upper[1] - upper[0]);
            const float bottom = lower[0] + fx * static_cast<float>(lower[1] - lower[0]);
            difference = grey[area.x + u] - (top + fy * (bottom - top));
            known = 1;
          } else {
            at.z() = -1;
          }
        }
        comparison.difference(v, u) = difference;
        comparison.known(v, u) = known;
        if (source) (*source)(v, u) = {at.x(), at.y(), at.z()};
      }
    }
  });
  boxSum(comparison.difference, comparison.mean);
  boxSum(comparison.known, comparison.count);
  cv::Mat1f& difference = comparison.difference;
  cv::parallel_for_(cv::Range(0, area.height), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      float* of_row = difference[v];
      const float *known = comparison.known[v], *mean = comparison.mean[v],
                  *count = comparison.count[v];
      for (int u = 0; u < area.width; ++u)
        of_row[u] = known[u] * std::abs(of_row[u] - mean[u] / std::max(count[u], 1.0f));
    }
  });
  boxSum(difference, comparison.mismatch);
  cv::parallel_for_(cv::Range(0, area.height), [&](const cv::Range& rows) {
    for (int v = rows.start; v < rows.end; ++v) {
      float* mismatch = comparison.mismatch[v];
      const float *known = comparison.known[v], *count = comparison.count[v];
      for (int u = 0; u < area.width; ++u)
        mismatch[u] = count[u] >= kFewestKnown && known[u] > 0 ? mismatch[u] / count[u]
                                                               : Comparison::kUnknown;
    }
  });
}

void latticeTexture(const ImagePyramid& current, cv::Mat1f& texture) {
  cv::Mat1f grey, mean;
  current.level(1).convertTo(grey, CV_32F);
  cv::boxFilter(grey, mean, CV_32F, {kWindow, kWindow});
  cv::absdiff(grey, mean, grey);
  cv::boxFilter(grey, texture, CV_32F, {kWindow, kWindow});
}

}  // namespace predictive_stereo
