#include "detection/grown_segment.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "detection/segmentation_rows.h"

namespace predictive_stereo {
namespace {

constexpr int kMostGrowth = 4;              // cells after / before
constexpr double kMostContradicting = 0.5;  // contradicting cells / supporting cells

}  // namespace

void growOverLayer(const cv::Mat1b& layer, const cv::Mat1f& support, const cv::Mat1f& smooth,
                   float least_smooth, float decisive, cv::Mat1b& mask, GrowingWork& work) {
  cv::Mat1b open = work.open.map(layer.size());
  open.setTo(255);
  for (int v = 0; v < layer.rows; ++v)
    dropRefutedRow(layer[v], smooth[v], layer.cols, least_smooth, open[v]);
  cv::morphologyEx(open, open, cv::MORPH_OPEN, cv::Mat1b::ones(3, 3));

  cv::Mat1i labels = work.labels.map(layer.size());
  const int count = cv::connectedComponents(open, labels, 4, CV_32S);
  std::vector<int>& common = work.common;
  common.assign(static_cast<size_t>(count), 0);
  int cells = 0;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (mask(v, u)) ++cells, ++common[static_cast<size_t>(labels(v, u))];
  common[0] = 0;
  const auto most = std::max_element(common.begin(), common.end());
  if (2 * *most <= cells) return;
  const int part = static_cast<int>(most - common.begin());

  cv::Mat1b grown = work.grown.map(layer.size());
  int grown_cells = 0;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      const bool inside = mask(v, u) || labels(v, u) == part;
      grown(v, u) = inside ? 255 : 0;
      grown_cells += inside;
    }
  if (grown_cells > kMostGrowth * cells) return;
  // Refuted cells are in the layer, but not in the part: count in the whole box.
  const cv::Rect box = cv::boundingRect(grown);
  int supporting = 0, contradicting = 0;
  for (int v = box.y; v < box.br().y; ++v)
    for (int u = box.x; u < box.br().x; ++u) {
      supporting += layer(v, u) && support(v, u) > decisive;
      contradicting += layer(v, u) && support(v, u) < -decisive;
    }
  if (contradicting > kMostContradicting * supporting) return;
  grown.copyTo(mask);
}

}  // namespace predictive_stereo
