#include "detection/frame_comparison.h"

#include <algorithm>

#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr float kNearestDisparity = 0.5f;  // points with smaller disparities do not show motion

// The last kComparedSide rows of a map, with a border of kComparedReach zeros on both sides.
class LastRows {
 public:
  explicit LastRows(int width)
      : stride_(static_cast<size_t>(width + 2 * kComparedReach)), values_(kComparedSide * stride_) {
    std::fill_n(values_.data(), values_.size(), 0.0f);
  }
  float* row(int v) { return withBorder(v) + kComparedReach; }
  void clear(int v) { std::fill_n(withBorder(v), stride_, 0.0f); }
  /// From v - kComparedReach to v + kComparedReach, with their borders.
  std::array<const float*, kComparedSide> around(int v) {
    std::array<const float*, kComparedSide> rows;
    for (int k = 0; k < kComparedSide; ++k) rows[k] = withBorder(v + k - kComparedReach);
    return rows;
  }

 private:
  float* withBorder(int v) { return &values_[stride_ * ((v + 2 * kComparedSide) % kComparedSide)]; }

  size_t stride_;
  cv::AutoBuffer<float, kComparedSide * 1024> values_;  // on the stack except for wide images
};

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

void compareFrames(const ImagePyramid& current, const cv::Mat1f& disparity_px,
                   const DisparityRange& range, const ImagePyramid& previous,
                   const SourceOf& source_of, const cv::Rect& area, Comparison& comparison) {
  const cv::Mat1b& now = current.level(1);
  const cv::Mat1b& before = previous.level(1);
  CV_Assert(before.isContinuous());
  comparison.area = area;
  comparison.mismatch = comparison.memory.map(area.size());
  const int rows = area.height;
  const auto exists = [rows](int v) { return v >= 0 && v < rows; };
  // One pass over the rows of a band; rows that are needed again are kept.
  const auto compareBand = [&](const cv::Range& band) {
    LastRows difference(area.width), known(area.width), deviation(area.width), count(area.width);
    const auto compare = [&](int v) {
      if (!exists(v)) return difference.clear(v), known.clear(v);
      const int y = area.y + v;
      const LatticeRow row = latticeRow(source_of, disparity_px, range, before.size(), area, y);
      RowSources sources(area.width);
      projectRow(row, sources);
      compareRow(row, sources, now[y] + area.x, before.data, difference.row(v), known.row(v));
    };
    const auto deviate = [&](int v) {
      if (!exists(v)) return deviation.clear(v);
      deviationRow(difference.around(v).data(), known.around(v).data(), area.width,
                   deviation.row(v), count.row(v));
    };
    for (int v = band.start - 2 * kComparedReach; v < band.start + 2 * kComparedReach; ++v) {
      compare(v);
      if (v >= band.start) deviate(v - kComparedReach);
    }
    for (int v = band.start; v < band.end; ++v) {
      compare(v + 2 * kComparedReach);
      deviate(v + kComparedReach);
      mismatchRow(deviation.around(v).data(), known.row(v), count.row(v), area.width,
                  comparison.mismatch[v]);
    }
  };
  parallelFor(cv::Range(0, rows), compareBand, cv::getNumThreads());
}

}  // namespace predictive_stereo
