/// Rows of every length beside a guard page (guarded_memory.h), on every SIMD target: the loops of
/// the detection read and write only the memory that their headers document.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "detection/displacement_search.h"
#include "detection/frame_comparison.h"
#include "detection/free_space.h"
#include "detection/level_ground.h"
#include "detection/long_residual.h"
#include "detection/patches.h"
#include "detection/segmentation.h"
#include "detection/suspicion.h"
#include "guarded_memory.h"
#include "imaging/image_pyramid.h"

namespace predictive_stereo {
namespace {

using testing::forEveryGuardAndTarget;
using testing::Guard;
using testing::GuardedRow;
using testing::GuardEveryMat;
using testing::kMostGuarded;

using Floats = GuardedRow<float>;
using Bytes = GuardedRow<uint8_t>;

// Number of floats from the first to the last of `points` points that are `step` apart.
int span(int points, int step) { return step * (points - 1) + 1; }

Floats floats(Guard guard, double low, double high, int most = kMostGuarded) {
  return Floats(most, guard, low, high);
}

// Calls body(width) for every width, with the same rows.
template <class MakeBody>
void forEveryRow(const MakeBody& make_body) {
  forEveryGuardAndTarget([&](Guard guard) {
    make_body(guard, [](const auto& body) {
      for (int width = 1; width <= kMostGuarded; ++width) body(width);
    });
  });
}

// Motion of static points by some columns and a row; those at borders leave the image.
constexpr float kMoved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, -1, 0, 1};

TEST(BorderReads, OfSegments) {
  forEveryRow([](Guard guard, const auto& for_every_width) {
    const Floats disparity = floats(guard, -1, 30, span(kMostGuarded, 2)),
                 below = floats(guard, 0, 2), support = floats(guard, -2, 2),
                 by_static = floats(guard, -1, 5), by_object = floats(guard, -1, 5);
    const Bytes layer(kMostGuarded, guard, 0, 2);
    for_every_width([&](int n) {
      layerRow(disparity(span(n, 2)), below(n), n, 5, 20, 1, layer(n));
      supportRow(by_static(n), by_object(n), n, 3, support(n));
    });
  });
}

TEST(BorderReads, OfFreeSpace) {
  forEveryRow([](Guard guard, const auto& for_every_width) {
    const Floats disparity = floats(guard, -1, 30), variance = floats(guard, 0, 1),
                 width = floats(guard, 0, 40);
    const Bytes through_by(kMostGuarded, guard), fixed(kMostGuarded, guard);
    for_every_width([&](int n) {
      constexpr int kRows = 3;
      const Floats nearest = floats(guard, -1, 30, n * kRows),
                   farthest = floats(guard, -1, 30, n * kRows);
      const PastSight past{kMoved, nearest(n * kRows), farthest(n * kRows), n, n, kRows, {}};
      sightsRow({disparity(n), variance(n), width(n), n, 0, 2, 4, 2, 10, 100, 50}, &past, 1, 1,
                through_by(n), fixed(n));
    });
  });
}

template <class T>
cv::Mat_<T> noise(cv::Size size, double low, double high) {
  cv::Mat_<T> map(size);
  cv::theRNG().fill(map, cv::RNG::UNIFORM, low, high);
  return map;
}

// Calls body(size) for maps of every width that are beside a guard page.
template <class Body>
void forEverySize(int rows, const Body& body) {
  forEveryGuardAndTarget([&](Guard guard) {
    const GuardEveryMat guards(guard);
    for (int width = 1; width <= kMostGuarded; ++width) body(cv::Size(width, rows));
  });
}

TEST(BorderReads, OfComparedFrames) {
  const SourceOf moved(Eigen::Matrix4f(kMoved).cast<double>());
  for (const int rows : {2, 3, 4, 5, 12})
    forEverySize(rows, [&](cv::Size size) {
      ImagePyramid current, previous;
      current.build(noise<uchar>(size, 0, 256), 2);
      previous.build(noise<uchar>(size, 0, 256), 2);
      Comparison comparison;
      compareFrames(current, noise<float>(size, -1, 30), DisparityRange(), previous, moved,
                    cv::Rect(cv::Point(), current.level(1).size()), comparison);
    });
}

TEST(BorderReads, OfLevelGround) {
  forEverySize(40, [](cv::Size size) {
    StereoRig rig;
    rig.size = size;
    rig.baseline_m = 0.5;
    LevelGround().setFrame(rig, DisparityRange(), noise<float>(size, -1, 30));
  });
}

TEST(BorderReads, OfPastDisparities) {
  forEverySize(7, [](cv::Size size) {
    StereoRig rig;
    rig.size = size;
    rig.fx_px = rig.fy_px = 100;
    rig.baseline_m = 0.5;
    RememberedFrame frame;
    frame.disparity_px = noise<float>(size, -1, 30);
    PastFrame past;
    past.frame = &frame;
    past.seconds = 0.1;
    past.T_past_cam.translation() << 0.1, 0.05, 0.1;
    cv::Mat1f residual_px;
    cv::Mat1b pair;
    longResidual(rig, noise<float>(size, -1, 30), DisparityRange(), {{past, past}}, 100,
                 (size + cv::Size(1, 1)) / 2, residual_px, pair);
  });
}

TEST(BorderReads, OfTexture) {
  forEverySize(15, [](cv::Size lattice) {
    cv::Mat1w deviation;
    greyDeviation(noise<uchar>(lattice, 0, 256), deviation);
    Suspicion().find(deviation, noise<float>(lattice, -1, 9), noise<float>(lattice * 2, -1, 30),
                     DisparityRange(), LevelGround(), MotionDetectionParams());
  });
}

TEST(BorderReads, OfPatches) {
  forEveryGuardAndTarget([](Guard guard) {
    for (std::ptrdiff_t stride = kPatchColumns; stride < 40; ++stride) {
      const int size = static_cast<int>((kPatchRows - 1) * stride + kPatchColumns);
      const Bytes image(size, guard, 0, 256);
      GreyPatch patch;
      patchBetween(image(size), stride, 0.3f, 0.6f, patch);
      patchDifference(patch, image(size), stride, 0.2f, 0.7f);
    }
  });
}

TEST(BorderReads, OfShifts) {
  forEveryGuardAndTarget([](Guard guard) {
    for (int trials = 1; trials <= 41; ++trials) {
      const int blocks = (trials + kShiftBlock - 1) / kShiftBlock * kShiftBlock;
      const Bytes image(2 * blocks, guard, 0, 256), grey(kMostShiftedSamples, guard, 0, 256);
      const GuardedRow<int32_t> total(blocks, guard);
      const std::vector<const uint8_t*> before(kMostShiftedSamples, image(2 * blocks));
      for (const int samples : {1, 2, kMostShiftedSamples})
        totalsOfShifts(grey(samples), before.data(), samples, trials, total(blocks));
    }
  });
}

// Groups of points at every border, that have moved up to the reach of the search.
TEST(BorderReads, OfGroupsThatAreSearched) {
  const cv::Size size(150, 70);  // of the lattice
  const SourceOf still(Eigen::Matrix4d::Identity());
  const auto search = [&](cv::Point first) {
    cv::Mat1b image(size * 2);
    cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
    ImagePyramid current, previous;
    current.build(image, 2);
    previous.build(image, 2);
    const cv::Mat1f disparity_px(image.size(), 5.0f);
    std::vector<cv::Point> points;
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x) points.push_back(first + cv::Point(x, y));
    float sum = 0;
    for (const int reach : {2, 15, 31, kSearchReach}) {
      const auto found = searchShift(current, previous, still, disparity_px, points, reach);
      if (found) sum += found->shift_px.x + 100 * found->shift_px.y + found->gain;
    }
    return sum;
  };
  for (int y : {0, 3, 30, 52, 55, 57, 58, 60, 63})
    for (int x : {0, 20, 41, 70, 80, 90, 100, 104, 110, 120, 130, 143}) {
      const float expected = search({x, y});
      forEveryGuardAndTarget([&](Guard guard) {
        const GuardEveryMat guards(guard);
        EXPECT_EQ(search({x, y}), expected) << x << ' ' << y;
      });
    }
}

}  // namespace
}  // namespace predictive_stereo
