/// Row alignment with the half-resolution match of the pipeline, on whole scenes.
#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "evaluation/disparity_metrics.h"
#include "evaluation/sequence.h"
#include "evaluation/simulation/street.h"
#include "predictive_stereo/coarse_matcher.h"
#include "predictive_stereo/matcher.h"
#include "predictive_stereo/post_filter.h"
#include "predictive_stereo/row_alignment.h"

namespace predictive_stereo {
namespace {

struct Alignments {
  RowOffsetModel first;   ///< of the pair as given
  RowOffsetModel second;  ///< of the pair after alignment with the first model
};

Alignments alignTwice(const cv::Mat1b& left, const cv::Mat1b& right) {
  const MatcherParams params;
  CoarseMatcher coarse_matcher(params);
  cv::Mat1f coarse_px;
  Alignments alignments;
  RowAligner aligner({}), other({});
  coarse_matcher.match(left, right, coarse_px);
  alignments.first = aligner.estimate(left, right, coarse_px, params.range);
  cv::Mat1b aligned;
  alignRightImage(right, alignments.first, 0, aligned);
  coarse_matcher.match(left, aligned, coarse_px);
  alignments.second = other.estimate(left, aligned, coarse_px, params.range);
  return alignments;
}

double largestError(const RowOffsetModel& alignment, const Street& street) {
  const cv::Size size = street.rig().size;
  double largest = 0;
  for (int y = 0; y < size.height; y += 10)
    for (int x = 0; x < size.width; x += 10)
      largest =
          std::max(largest, std::abs(alignment.offset(x, y, size) - street.rightRowOffset(x, y)));
  return largest;
}

TEST(RowAlignmentOfScenes, StreetOfAMisalignedRig) {
  StreetParams params;
  params.scene = "misaligned";
  params.frames = 30;
  const Street street(params);
  ASSERT_GT(std::abs(street.rightRowOffset(0, 374)), 1.0);
  for (int index : {0, 29}) {
    const StreetFrame frame = street.render(index);
    const Alignments alignments = alignTwice(frame.left, frame.right);
    EXPECT_LT(largestError(alignments.first, street), 0.25) << index;
    EXPECT_LT(alignments.first.residual_px, 0.25);
    EXPECT_LT(alignments.second.largest_offset_px, 0.25);
  }
}

TEST(RowAlignmentOfScenes, StreetOfAPerfectRig) {
  StreetParams params;
  params.scene = "straight";
  params.frames = 30;
  const Street street(params);
  for (int index : {0, 29}) {
    const StreetFrame frame = street.render(index);
    const Alignments alignments = alignTwice(frame.left, frame.right);
    EXPECT_FALSE(alignments.first.isIdentity());
    EXPECT_LT(alignments.first.largest_offset_px, 0.07);
  }
}

TEST(RowAlignmentOfScenes, CostsAPerfectRigNoAccuracy) {
  StreetParams params;
  params.scene = "straight";
  params.frames = 30;
  const auto street = streetSequence(params);
  const MatcherParams matcher_params;
  StereoMatcher matcher(matcher_params);
  CoarseMatcher coarse_matcher(matcher_params);
  RowAligner aligner({});
  MeanDisparityScore as_given, as_aligned;
  for (int index = 9; index < params.frames; index += 10) {
    const SequenceFrame frame = street->frame(index);
    const auto scoreWith = [&](const cv::Mat1b& right) {
      Match match;
      cv::Mat1f supported_px, filtered_px;
      matcher.match(frame.left, right, match);
      filterBySupport(matcher_params.range, 10, match.disparity_px, supported_px);
      median3x3(matcher_params.range, 5, supported_px, filtered_px);
      return scoreDisparity(filtered_px, matcher_params.range, frame.truth_px);
    };
    cv::Mat1f coarse_px;
    cv::Mat1b aligned;
    coarse_matcher.match(frame.left, frame.right, coarse_px);
    alignRightImage(frame.right,
                    aligner.estimate(frame.left, frame.right, coarse_px, matcher_params.range), 0,
                    aligned);
    as_given.add(scoreWith(frame.right));
    as_aligned.add(scoreWith(aligned));
  }
  EXPECT_NEAR(as_aligned.d1_percent, as_given.d1_percent, 0.05);
  EXPECT_NEAR(as_aligned.d1_filled_percent, as_given.d1_filled_percent, 0.05);
}

TEST(RowAlignmentOfScenes, Kitti) {
  const char* excerpts = std::getenv("KITTI_EXCERPTS");
  if (!excerpts) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
  const std::string date_dir = std::string(excerpts) + "/2011_09_26/";
  double left_over_px = 0;
  int pairs = 0;
  for (const char* drive : {"2011_09_26_drive_0002_sync", "2011_09_26_drive_0009_sync"}) {
    std::vector<cv::String> left_files, right_files;
    cv::glob(date_dir + drive + "/image_00/data/*.png", left_files);
    cv::glob(date_dir + drive + "/image_01/data/*.png", right_files);
    for (size_t i = 0; i < left_files.size(); ++i) {
      SCOPED_TRACE(left_files[i]);
      const Alignments alignments = alignTwice(cv::imread(left_files[i], cv::IMREAD_GRAYSCALE),
                                               cv::imread(right_files[i], cv::IMREAD_GRAYSCALE));
      EXPECT_GT(alignments.first.samples, 250);
      EXPECT_LT(alignments.first.residual_px, 0.2);
      EXPECT_GT(alignments.first.largest_offset_px, 1.5);
      EXPECT_LT(alignments.first.largest_offset_px, 2.8);
      // Of a single frame, in a corner that may have no texture.
      EXPECT_LT(alignments.second.largest_offset_px, 0.8);
      left_over_px += alignments.second.largest_offset_px;
      ++pairs;
    }
  }
  ASSERT_GT(pairs, 0);
  EXPECT_LT(left_over_px / pairs, 0.25);
}

}  // namespace
}  // namespace predictive_stereo
