#include "predictive_stereo/row_alignment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "matching/row_offset_sample.h"

namespace predictive_stereo {
namespace {

using Coefficients = Eigen::Matrix<double, 6, 1>;

const cv::Size kSize(1242, 375);
const DisparityRange kRange;

Coefficients coefficients(double c0, double c1, double c2, double c3, double c4, double c5) {
  Coefficients c;
  c << c0, c1, c2, c3, c4, c5;
  return c;
}

// As measured on a KITTI drive.
Coefficients kittiOffset() { return coefficients(-0.32, 0.21, -0.02, -0.49, 1.29, -0.07); }

RowOffsetModel alignmentOf(const Coefficients& c) {
  RowOffsetModel alignment;
  alignment.coefficients_px = c;
  alignment.samples = 1000;
  return alignment;
}

struct Pair {
  cv::Mat1b left, right;
  cv::Mat1b right_aligned;  // right image of a perfect rig
  cv::Mat1f coarse_disparity_px;
};

// A textured road, whose disparity grows from row to row. Every image is sampled directly from the
// scene, so that no image is an interpolation of another one.
Pair makePair(const Coefficients& offset_px, int seed = 1, cv::Size size = kSize) {
  cv::Mat1f scene(size.height + 40, size.width + 160);
  cv::RNG rng(seed);
  rng.fill(scene, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(scene, scene, {}, 1.5);
  scene = 128 + 220 * scene;

  const auto disparity = [&](double y) { return 5 + 60 * y / size.height; };
  const RowOffsetModel alignment = alignmentOf(offset_px);
  cv::Mat2f left_map(size), aligned_map(size), right_map(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const auto at = [](double x_scene, double y_scene) {
        return cv::Vec2f(static_cast<float>(x_scene + 20), static_cast<float>(y_scene + 20));
      };
      left_map(y, x) = at(x, y);
      aligned_map(y, x) = at(x + disparity(y), y);
      double row = y;  // of the left image: row + offset(x, row) = y
      for (int i = 0; i < 10; ++i) row = y - alignment.offset(x, row, size);
      right_map(y, x) = at(x + disparity(row), row);
    }
  Pair pair;
  const auto sample = [&](const cv::Mat2f& map, cv::Mat1b& image) {
    cv::Mat1f grey;
    cv::remap(scene, grey, map, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    cv::Mat1f noise(size);
    rng.fill(noise, cv::RNG::NORMAL, 0, 1.5);
    cv::Mat(grey + noise).convertTo(image, CV_8U);
  };
  sample(left_map, pair.left);
  sample(aligned_map, pair.right_aligned);
  sample(right_map, pair.right);
  pair.coarse_disparity_px.create(size / 2);
  for (int y = 0; y < size.height / 2; ++y)
    for (int x = 0; x < size.width / 2; ++x)
      pair.coarse_disparity_px(y, x) = static_cast<float>(disparity(2 * y + 0.5));
  return pair;
}

double largestError(const RowOffsetModel& alignment, const Coefficients& truth) {
  double largest = 0;
  for (int y = 0; y < kSize.height; y += 10)
    for (int x = 0; x < kSize.width; x += 10)
      largest = std::max(largest, std::abs(alignment.offset(x, y, kSize) -
                                           alignmentOf(truth).offset(x, y, kSize)));
  return largest;
}

RowOffsetModel estimate(RowAligner& aligner, const Pair& pair) {
  return aligner.estimate(pair.left, pair.right, pair.coarse_disparity_px, kRange);
}

TEST(RowAlignment, OffsetOfKnownTerms) {
  const RowOffsetModel alignment = alignmentOf(coefficients(1, 2, 3, 4, 5, 6));
  EXPECT_DOUBLE_EQ(alignment.offset(621, 187.5, kSize), 1);
  EXPECT_DOUBLE_EQ(alignment.offset(1242, 375, kSize), 21);
  EXPECT_DOUBLE_EQ(alignment.offset(0, 375, kSize), 1 - 2 + 3 + 4 - 5 + 6);
}

TEST(RowAlignment, OffsetsAlongARow) {
  const RowOffsetModel alignment = alignmentOf(coefficients(1, 2, 3, 4, 5, 6));
  const Eigen::Vector3d c = alignment.alongRow(100, kSize);
  for (double x : {-40.0, 0.0, 300.5, 1241.0})
    EXPECT_NEAR(c[0] + c[1] * x + c[2] * x * x, alignment.offset(x, 100, kSize), 1e-12) << x;
}

TEST(RowAligner, FindsTheOffsetOfARealRig) {
  RowAligner aligner({});
  const RowOffsetModel alignment = estimate(aligner, makePair(kittiOffset()));
  EXPECT_GT(alignment.samples, 500);
  EXPECT_LT(alignment.residual_px, 0.15);
  EXPECT_LT(largestError(alignment, kittiOffset()), 0.1);
  EXPECT_NEAR(alignment.largest_offset_px, 2.4, 0.1);
}

TEST(RowAligner, LeavesAPerfectPairAlone) {
  for (int seed = 1; seed <= 4; ++seed) {
    RowAligner aligner({});
    const RowOffsetModel alignment = estimate(aligner, makePair(Coefficients::Zero(), seed));
    EXPECT_FALSE(alignment.isIdentity());
    EXPECT_LT(alignment.largest_offset_px, 0.07);
    EXPECT_LT(largestError(alignment, Coefficients::Zero()), 0.07);
  }
}

TEST(RowAligner, BearsWrongDisparities) {
  Pair pair = makePair(kittiOffset());
  cv::RNG rng(7);
  for (float& disparity_px : pair.coarse_disparity_px) {
    const double kind = rng.uniform(0.0, 1.0);
    if (kind < 0.3)
      disparity_px = rng.uniform(0.f, 127.f);
    else if (kind < 0.5)
      disparity_px = kRange.invalid();
    else
      disparity_px += rng.uniform(-0.7f, 0.7f);
  }
  RowAligner aligner({});
  const RowOffsetModel alignment = estimate(aligner, pair);
  EXPECT_FALSE(alignment.isIdentity());
  EXPECT_LT(largestError(alignment, kittiOffset()), 0.12);
}

TEST(RowAligner, IdentityWhereNothingCanBeTold) {
  const Pair pair = makePair(kittiOffset());
  {
    RowAlignmentParams off;
    off.enabled = false;
    RowAligner aligner(off);
    EXPECT_TRUE(estimate(aligner, pair).isIdentity());
  }
  RowAligner aligner({});
  const cv::Mat1f none(pair.coarse_disparity_px.size(), kRange.invalid());
  EXPECT_TRUE(aligner.estimate(pair.left, pair.right, none, kRange).isIdentity());
  const cv::Mat1b grey(kSize, 100);
  EXPECT_TRUE(aligner.estimate(grey, grey, pair.coarse_disparity_px, kRange).isIdentity());
  // Images of different scenes.
  const Pair other = makePair(kittiOffset(), 2);
  const RowOffsetModel wrong =
      aligner.estimate(pair.left, other.right, pair.coarse_disparity_px, kRange);
  EXPECT_TRUE(wrong.isIdentity()) << wrong.samples;
}

TEST(RowAligner, RefusesAnOffsetBeyondItsLimit) {
  RowAlignmentParams params;
  params.max_offset_px = 1.5;
  RowAligner aligner(params);
  EXPECT_TRUE(estimate(aligner, makePair(kittiOffset())).isIdentity());
  EXPECT_FALSE(estimate(aligner, makePair(kittiOffset() * 0.5)).isIdentity());
}

TEST(RowAligner, FollowsVibrationAtOnce) {
  RowAligner aligner({});
  Coefficients shaken = kittiOffset();
  for (int frame = 0; frame < 4; ++frame) {
    shaken(0) = frame % 2 ? 0.3 : -0.5;
    EXPECT_LT(largestError(estimate(aligner, makePair(shaken, frame + 1)), shaken), 0.1) << frame;
  }
}

TEST(RowAligner, RemembersForAWhileAndForgetsOnReset) {
  const Pair pair = makePair(kittiOffset());
  const cv::Mat1b dark(kSize, 0);
  RowAligner aligner({});
  estimate(aligner, pair);
  const auto darkFrame = [&] {
    return aligner.estimate(dark, dark, pair.coarse_disparity_px, kRange);
  };
  EXPECT_LT(largestError(darkFrame(), kittiOffset()), 0.1);
  for (int frame = 0; frame < 30; ++frame) darkFrame();
  EXPECT_TRUE(darkFrame().isIdentity());

  estimate(aligner, pair);
  aligner.reset();
  EXPECT_TRUE(darkFrame().isIdentity());
}

// Rails and kerbs: the half-resolution match finds a disparity at which they fit without an offset.
TEST(RowOffsetSample, LinesTellNothing) {
  constexpr double kTrueOffsetPx = -1.1;
  constexpr int kDisparityPx = 40;
  const cv::Point centre(300, 60);
  for (const double columns_per_row : {-5.0, -3.0, -1.5, 1.5, 3.0, 5.0}) {
    SCOPED_TRACE(columns_per_row);
    cv::Mat1b left(120, 600), right(120, 600);
    cv::RNG rng(3);
    const auto draw = [&](cv::Mat1b& image, double shift_px, double down_px) {
      for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x) {
          const double row = y - down_px - centre.y - (x + shift_px - centre.x) / columns_per_row;
          image(y, x) =
              cv::saturate_cast<uchar>(60 + 90 * std::exp(-row * row / 2) + rng.gaussian(1.5));
        }
    };
    draw(left, 0, 0);
    draw(right, kDisparityPx, kTrueOffsetPx);
    double offset_px;
    EXPECT_FALSE(measureRowOffset(
        left, right, centre, cvRound(kDisparityPx - kTrueOffsetPx * columns_per_row), offset_px));
    // A spot beside the line makes the offset observable.
    for (cv::Mat1b* image : {&left, &right}) {
      const bool is_left = image == &left;
      const cv::Point2d spot(
          centre.x + 3 - (is_left ? 0 : kDisparityPx),
          centre.y + (columns_per_row > 0 ? -2 : 2) + (is_left ? 0 : kTrueOffsetPx));
      for (int y = centre.y - 12; y <= centre.y + 12; ++y)
        for (int x = cvRound(spot.x) - 8; x <= cvRound(spot.x) + 8; ++x) {
          const double squared = (x - spot.x) * (x - spot.x) + (y - spot.y) * (y - spot.y);
          (*image)(y, x) = cv::saturate_cast<uchar>((*image)(y, x) + 150 * std::exp(-squared / 3));
        }
    }
    ASSERT_TRUE(measureRowOffset(left, right, centre, kDisparityPx, offset_px));
    EXPECT_NEAR(offset_px, kTrueOffsetPx, 0.15);
  }
}

TEST(RowAligner, SameForEveryNumberOfThreads) {
  const Pair pair = makePair(kittiOffset());
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  RowAligner first({});
  const RowOffsetModel expected = estimate(first, pair);
  for (int threads : {2, 3, 7}) {
    cv::setNumThreads(threads);
    RowAligner aligner({});
    EXPECT_EQ(estimate(aligner, pair).coefficients_px, expected.coefficients_px) << threads;
  }
  cv::setNumThreads(before);
}

TEST(RowAligner, ViewsAndTinyImages) {
  const Pair pair = makePair(kittiOffset());
  cv::Mat1b large_left(kSize.height + 9, kSize.width + 13, 7), large_right = large_left.clone();
  const cv::Rect view(5, 3, kSize.width, kSize.height);
  pair.left.copyTo(large_left(view));
  pair.right.copyTo(large_right(view));
  RowAligner aligner({}), other({});
  EXPECT_EQ(aligner.estimate(large_left(view), large_right(view), pair.coarse_disparity_px, kRange)
                .coefficients_px,
            estimate(other, pair).coefficients_px);

  for (cv::Size size : {cv::Size(1, 1), cv::Size(40, 1), cv::Size(1, 40), cv::Size(17, 15)}) {
    const cv::Mat1b image(size, 3);
    RowAligner tiny({});
    EXPECT_TRUE(tiny.estimate(image, image, cv::Mat1f(size / 2, 1.f), kRange).isIdentity());
  }
}

TEST(RowAligner, RefusesWhatDoesNotFit) {
  const cv::Mat1b image(40, 60, 3);
  const cv::Mat1f coarse(20, 30, 1.f);
  RowAligner aligner({});
  EXPECT_THROW(aligner.estimate(cv::Mat1b(), image, coarse, kRange), std::invalid_argument);
  EXPECT_THROW(aligner.estimate(image, image.rowRange(1, 40), coarse, kRange),
               std::invalid_argument);
  EXPECT_THROW(aligner.estimate(image, image, coarse.rowRange(1, 20), kRange),
               std::invalid_argument);
  RowAlignmentParams params;
  params.smoothing = 1.5;
  EXPECT_THROW(RowAligner{params}, std::invalid_argument);
}

// Reference pixel by pixel, in exact arithmetic except for the weights of 1/128.
cv::Mat1b alignNaively(const cv::Mat1b& right, const RowOffsetModel& alignment, int shift_px) {
  cv::Mat1b aligned(right.size());
  for (int y = 0; y < right.rows; ++y)
    for (int x = 0; x < right.cols; ++x) {
      const int offset =
          static_cast<int>(std::floor(alignment.offset(x, y, right.size()) * 128 + 0.5));
      const int row = y + (offset >> 7), weight = offset & 127;
      const int column = std::clamp(x - shift_px, 0, right.cols - 1);
      const int a = right(std::clamp(row, 0, right.rows - 1), column);
      const int b = right(std::clamp(row + 1, 0, right.rows - 1), column);
      aligned(y, x) = static_cast<uchar>((a * (128 - weight) + b * weight + 64) / 128);
    }
  return aligned;
}

TEST(AlignRightImage, EqualsTheNaiveReference) {
  for (cv::Size size : {cv::Size(1242, 375), cv::Size(1, 1), cv::Size(63, 1), cv::Size(65, 2),
                        cv::Size(129, 37), cv::Size(1, 50)}) {
    cv::Mat1b right(size);
    cv::theRNG().state = 5;
    cv::randu(right, 0, 256);
    for (int shift : {0, 3, -7}) {
      const RowOffsetModel alignment = alignmentOf(kittiOffset() * 1.3);
      cv::Mat1b aligned;
      alignRightImage(right, alignment, shift, aligned);
      // Weights may differ by 1/128 if the offset is between two of them.
      const double largest = cv::norm(aligned, alignNaively(right, alignment, shift), cv::NORM_INF);
      EXPECT_LE(largest, 2) << size << " " << shift;
      EXPECT_LE(cv::countNonZero(aligned != alignNaively(right, alignment, shift)),
                0.001 * size.area())
          << size << " " << shift;
    }
  }
}

TEST(AlignRightImage, UndoesTheMisalignment) {
  const Pair pair = makePair(kittiOffset());
  cv::Mat1b aligned;
  alignRightImage(pair.right, alignmentOf(kittiOffset()), 0, aligned);
  const cv::Rect inside(5, 5, kSize.width - 10, kSize.height - 10);
  const auto error = [&](const cv::Mat1b& image) {
    return cv::norm(image(inside), pair.right_aligned(inside), cv::NORM_L1) / inside.area();
  };
  EXPECT_LT(error(aligned), 3);
  EXPECT_GT(error(pair.right), 8);
}

TEST(AlignRightImage, FractionalColumnShift) {
  cv::Mat1b ramp(4, 300);
  for (int x = 0; x < ramp.cols; ++x) ramp.col(x).setTo(x / 2 * 2 * 127 / 150);
  cv::Mat1b moved;
  alignRightImage(ramp, RowOffsetModel(), 2.25, moved);
  for (int x = 4; x < ramp.cols; ++x)
    EXPECT_NEAR(moved(2, x), 0.25 * ramp(2, x - 3) + 0.75 * ramp(2, x - 2), 0.51) << x;
  EXPECT_EQ(moved(2, 0), ramp(2, 0));
}

TEST(AlignRightImage, CopiesNothingWithoutNeedAndNeverWritesIntoAnImage) {
  const cv::Mat1b right(20, 30, 9);
  cv::Mat1b aligned;
  alignRightImage(right, RowOffsetModel(), 0, aligned);
  EXPECT_EQ(aligned.data, right.data);
  // The same `aligned` in the next frame, which has an offset.
  cv::Mat1b next(20, 30, 200);
  alignRightImage(next, alignmentOf(kittiOffset()), 0, aligned);
  EXPECT_EQ(cv::countNonZero(right != 9), 0);
  EXPECT_EQ(cv::countNonZero(aligned != 200), 0);
  const uchar* memory = aligned.data;
  alignRightImage(next, alignmentOf(kittiOffset()), 0, aligned);
  EXPECT_EQ(aligned.data, memory);
  // Memory that is not owned by OpenCV.
  std::vector<uchar> message(20 * 30, 50);
  const cv::Mat1b wrapped(20, 30, message.data());
  alignRightImage(wrapped, RowOffsetModel(), 0, aligned);
  alignRightImage(next, alignmentOf(kittiOffset()), 0, aligned);
  EXPECT_EQ(message, std::vector<uchar>(20 * 30, 50));
}

TEST(AlignRightImage, Views) {
  cv::Mat1b large(90, 200);
  cv::randu(large, 0, 256);
  const cv::Mat1b view = large(cv::Rect(10, 20, 150, 50));
  cv::Mat1b of_view, of_copy;
  alignRightImage(view, alignmentOf(kittiOffset()), 0, of_view);
  alignRightImage(view.clone(), alignmentOf(kittiOffset()), 0, of_copy);
  EXPECT_EQ(cv::countNonZero(of_view != of_copy), 0);
}

}  // namespace
}  // namespace predictive_stereo
