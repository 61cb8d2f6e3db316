#include "imaging/tracking.h"

#include "imaging/patch.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

constexpr int kCoarseIterations = 6;
constexpr float kCoarseStopPx = 0.1f;  // only a start for the next finer level
constexpr int kFineIterations = 12;
constexpr float kSmallestCorrelation = 0.8f;

void trackPoint(const ImagePyramid& from, const ImagePyramid& to, Track& track) {
  track.found = false;
  Patch fine, coarse;
  // First: where this fails, coarse levels are of no use.
  if (!fine.sample(from.level(0), track.origin, track.scale)) return;
  for (int k = from.levels() - 1; k > 0; --k) {
    const float shrink = 1.f / static_cast<float>(1 << k);
    // The scale matters on the finest levels only.
    if (!coarse.sample(from.level(k), track.origin * shrink, k > 1 ? 1.f : track.scale)) continue;
    const Patch::Match match =
        coarse.align(to.level(k), track.position * shrink, kCoarseIterations, kCoarseStopPx);
    // A coarse level that fails is skipped, as for small foreground structures.
    if (match.correlation > 0.5f) track.position = match.position / shrink;
  }
  const Patch::Match match = fine.align(to.level(0), track.position, kFineIterations);
  track.position = match.position;
  track.found = match.converged && match.correlation > kSmallestCorrelation;
  track.variance_px2 = {fine.covariance()(0, 0), fine.covariance()(1, 1)};
}

// Most points are not in the cache.
void prefetch(const ImagePyramid& from, const ImagePyramid& to, const Track& track) {
  for (int k = 0; k < from.levels(); ++k) {
    const float shrink = 1.f / static_cast<float>(1 << k);
    Patch::prefetch(from.level(k), track.origin * shrink);
    Patch::prefetch(to.level(k), track.position * shrink);
  }
}

}  // namespace

void trackPoints(const ImagePyramid& from, const ImagePyramid& to, std::vector<Track>& tracks) {
  parallelFor(cv::Range(0, static_cast<int>(tracks.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      if (i + 1 < range.end) prefetch(from, to, tracks[i + 1]);
      trackPoint(from, to, tracks[i]);
    }
  });
}

}  // namespace predictive_stereo
