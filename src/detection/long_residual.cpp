#include "detection/long_residual.h"

#include <algorithm>

#include "detection/frame_comparison.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

PastCamera cameraOf(const StereoRig& rig, const PastFrame& past) {
  const Eigen::Vector3f position = past.T_past_cam.inverse().translation().cast<float>();
  return {position.x(),
          position.y(),
          position.z(),
          static_cast<float>(rig.fx_px),
          static_cast<float>(rig.cx_left_px),
          static_cast<float>(rig.cy_px),
          static_cast<float>(rig.disparityTimesDepth())};
}

PastDisparities disparitiesOf(const PastFrame& past, const SourceOf& source_of) {
  const cv::Mat1f& map = past.frame->disparity_px;
  return {source_of.H().data(), map[0], static_cast<int>(map.step1()), map.cols, map.rows};
}

template <class T>
void repeatEach(const T* points, int width, T* lattice) {
  for (int i = 0; i < width / 2; ++i) lattice[2 * i] = lattice[2 * i + 1] = points[i];
  if (width % 2 != 0) lattice[width - 1] = points[width / 2];
}

}  // namespace

float parallaxSince(const StereoRig& rig, const PastFrame& past, const Eigen::Vector3f& point_px) {
  return cameraOf(rig, past).parallax(point_px.x(), point_px.y(), point_px.z());
}

void longResidual(const StereoRig& rig, const cv::Mat1f& disparity_px, const DisparityRange& range,
                  const std::vector<PastPair>& pairs, double most_px, cv::Size lattice,
                  cv::Mat1f& residual_px, cv::Mat1b& pair) {
  std::vector<SourceOf> sources;  // two for each pair: past and halfway frame
  for (const PastPair& p : pairs)
    for (const PastFrame* frame : {&p.past, &p.halfway})
      sources.emplace_back(disparityMotion(rig, frame->T_past_cam));
  std::vector<PastPairOfRow> of_row;
  for (size_t k = 0; k < pairs.size(); ++k)
    of_row.push_back({cameraOf(rig, pairs[k].past), disparitiesOf(pairs[k].past, sources[2 * k]),
                      disparitiesOf(pairs[k].halfway, sources[2 * k + 1]),
                      static_cast<float>(pairs[k].past.seconds / pairs[k].halfway.seconds)});
  residual_px.create(lattice);
  pair.create(lattice);
  const int points = (lattice.width + 1) / 2;
  parallelFor(cv::Range(0, (lattice.height + 1) / 2), [&](const cv::Range& rows) {
    cv::AutoBuffer<float, 1024> residuals(static_cast<size_t>(points));
    cv::AutoBuffer<uchar, 1024> pairs_of(static_cast<size_t>(points));
    for (int v = 2 * rows.start; v < 2 * rows.end; v += 2) {
      const int y = 2 * v;
      longResidualRow({disparity_px[y], y, points, of_row.data(), static_cast<int>(of_row.size()),
                       static_cast<float>(range.min_disparity), static_cast<float>(most_px)},
                      residuals.data(), pairs_of.data());
      repeatEach(residuals.data(), lattice.width, residual_px[v]);
      repeatEach(pairs_of.data(), lattice.width, pair[v]);
      if (v + 1 == lattice.height) continue;
      std::copy_n(residual_px[v], lattice.width, residual_px[v + 1]);
      std::copy_n(pair[v], lattice.width, pair[v + 1]);
    }
  });
}

}  // namespace predictive_stereo
