#include "detection/frame_comparison.h"

#include <algorithm>

namespace predictive_stereo {
namespace {

constexpr float kFewestKnown = 0.5f * kComparedSide * kComparedSide;
constexpr double kFastestAway_mps = 30;  // that something which moves along may be
constexpr float kHidingMargin_px = 1.0f;
constexpr float kNearestDisparity = 0.5f;  // farther points tell nothing of motion

template <class Work>
void forEachRow(int rows, const Work& work) {
  cv::parallel_for_(cv::Range(0, rows), [&](const cv::Range& range) {
    for (int v = range.start; v < range.end; ++v) work(v);
  });
}

// The points of `area` in lattice row `v`.
LatticeRow latticeRow(const SourceOf& source_of, const cv::Mat1f& disparity_px,
                      const DisparityRange& range, const cv::Size& lattice, const cv::Rect& area,
                      int v) {
  const int x = 2 * area.x, y = 2 * v;
  return {source_of.H().data(),
          disparity_px[y] + x,
          x,
          y,
          area.width,
          std::max(static_cast<float>(range.min_disparity), kNearestDisparity),
          lattice.width,
          lattice.height};
}

}  // namespace

Uncovered::Uncovered(const StereoRig& rig, const SourceOf& static_source,
                     const cv::Mat1f& previous_disparity_px, double seconds)
    : static_source_(static_source),
      previous_px_(previous_disparity_px),
      disparity_times_depth_(static_cast<float>(rig.disparityTimesDepth())),
      nearer_m_(static_cast<float>(kFastestAway_mps * seconds)) {}

bool Uncovered::operator()(cv::Point pixel, float disparity_px) const {
  const Eigen::Vector3f from =
      static_source_(static_cast<float>(pixel.x), static_cast<float>(pixel.y), disparity_px);
  const int x = cvRound(from.x()), y = cvRound(from.y());
  if (!(from.z() > 0) || x < 0 || y < 0 || x >= previous_px_.cols || y >= previous_px_.rows)
    return false;
  const float before = previous_px_(y, x);
  const float hiding_m = disparity_times_depth_ / from.z() - nearer_m_;
  return before > from.z() + kHidingMargin_px && before * hiding_m > disparity_times_depth_;
}

void BorderedMap::create(cv::Size size) {
  stride_ = static_cast<size_t>(size.width + 2 * kComparedReach);
  const size_t needed = stride_ * static_cast<size_t>(size.height + 2 * kComparedReach);
  if (values_.size() < needed) values_.resize(needed);
  std::fill_n(withBorder(-kComparedReach), kComparedReach * stride_, 0.0f);
  std::fill_n(withBorder(size.height), kComparedReach * stride_, 0.0f);
  for (int v = 0; v < size.height; ++v) {
    std::fill_n(withBorder(v), kComparedReach, 0.0f);
    std::fill_n(row(v) + size.width, kComparedReach, 0.0f);
  }
}

std::array<const float*, kComparedSide> BorderedMap::around(int v) {
  std::array<const float*, kComparedSide> rows;
  for (int k = 0; k < kComparedSide; ++k) rows[k] = withBorder(v + k - kComparedReach);
  return rows;
}

void compareFrames(const ImagePyramid& current, const cv::Mat1f& disparity_px,
                   const DisparityRange& range, const ImagePyramid& previous,
                   const SourceOf& source_of, const cv::Rect& area, Comparison& comparison,
                   const std::function<void(const LatticeRow&, const RowSources&)>& beside_row) {
  const cv::Mat1b& now = current.level(1);
  const cv::Mat1b& before = previous.level(1);
  CV_Assert(before.isContinuous());
  comparison.area = area;
  comparison.mismatch = comparison.memory.map(area.size());
  Comparison& c = comparison;
  for (BorderedMap* map : {&c.difference, &c.known, &c.deviation, &c.count})
    map->create(area.size());
  forEachRow(area.height, [&](int v) {
    const int y = area.y + v;
    const LatticeRow row = latticeRow(source_of, disparity_px, range, before.size(), area, y);
    RowSources sources(area.width);
    projectRow(row, sources);
    compareRow(row, sources, now[y] + area.x, before.data, c.difference.row(v), c.known.row(v));
    if (beside_row) beside_row(row, sources);
  });
  forEachRow(area.height, [&](int v) {
    deviationRow(c.difference.around(v).data(), c.known.around(v).data(), area.width,
                 c.deviation.row(v), c.count.row(v));
  });
  forEachRow(area.height, [&](int v) {
    mismatchRow(c.deviation.around(v).data(), c.known.row(v), c.count.row(v), area.width,
                kFewestKnown, Comparison::kUnknown, c.mismatch[v]);
  });
}

}  // namespace predictive_stereo
