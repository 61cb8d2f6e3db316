/// Rows of every length beside a guard page (guarded_memory.h), on every SIMD target: the loops of
/// the detection read and write only the memory that their headers document.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "detection/displacement_search.h"
#include "detection/frame_comparison.h"
#include "detection/free_space.h"
#include "detection/long_residual.h"
#include "detection/suspicion.h"
#include "frame_parts.h"
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

TEST(BorderReads, OfFreeSpace) {
  forEveryRow([](Guard guard, const auto& for_every_width) {
    const Floats disparity = floats(guard, -1, 30), variance = floats(guard, 0, 1),
                 width = floats(guard, 0, 40);
    const Bytes through_by(kMostGuarded, guard), fixed(kMostGuarded, guard);
    for_every_width([&](int n) {
      constexpr int kRows = 3;
      const Floats nearest = floats(guard, -1, 30, n * kRows),
                   farthest = floats(guard, -1, 30, n * kRows);
      const PastSight past{{kMoved, n, n, kRows}, nearest(n * kRows), farthest(n * kRows), {}};
      sightsRow({disparity(n), variance(n), width(n), n, 4, 10, 100, 50}, &past, 1, through_by(n),
                fixed(n));
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
      cv::Mat1f mismatch;
      compareFrames(current, noise<float>(current.level(1).size(), 0, 30), previous, moved,
                    cv::Rect(cv::Point(), current.level(1).size()), mismatch);
    });
}

TEST(BorderReads, OfPastDisparities) {
  forEverySize(7, [](cv::Size size) {
    StereoRig rig;
    rig.size = size * kCellSide_px;
    rig.fx_px = rig.fy_px = 100;
    rig.baseline_m = 0.5;
    RememberedFrame frame;
    frame.disparity_px = noise<float>(rig.size, -1, 30);
    PastFrame past;
    past.frame = &frame;
    past.seconds = 0.1;
    past.T_past_cam.translation() << 0.1, 0.05, 0.1;
    cv::Mat1f residual_px;
    cv::Mat1b pair;
    longResidual(rig, noise<float>(size, -1, 30), DisparityRange(), {{past, past}}, 100,
                 residual_px, pair);
  });
}

TEST(BorderReads, OfTexture) {
  forEverySize(15, [](cv::Size lattice) {
    cv::Mat1f texture;
    greyTexture(noise<uchar>(lattice, 0, 256), texture);
    FrameParts parts;
    parts.input.measured_disparity_px = noise<float>(lattice * 2, -1, 30);
    parts.obstacles.standing = cv::Mat1b(lattice, uchar{255});
    findSuspects(parts.frame, texture, noise<float>(lattice, -1, 9));
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
  const auto search = [&](cv::Point first) {
    FrameParts parts;
    RememberedFrame before;
    cv::Mat1b image(size * 2);
    cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
    parts.current.pyramid.build(image, 2);
    before.pyramid.build(image, 2);
    parts.input.measured_disparity_px = cv::Mat1f(image.size(), 5.0f);
    PastFrame past;
    past.frame = &before;
    const PastView view{parts.frame, past, SourceOf(Eigen::Matrix4d::Identity())};
    std::vector<cv::Point> points;
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x) points.push_back(first + cv::Point(x, y));
    float sum = 0;
    for (const int reach : {2, 15, 31, kSearchReach}) {
      const auto found = searchShift(view, points, reach);
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
