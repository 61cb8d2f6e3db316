/// Counts of hand-made cases.
#include "evaluation/detection_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/statistics.h"

namespace predictive_stereo {
namespace {

ObjectLabel label(int track, const cv::Rect2d& box_px, const std::string& type = "car") {
  ObjectLabel label;
  label.track = track;
  label.type = type;
  label.box_px = box_px;
  label.distance_m = 20;
  label.speed_mps = 5;
  label.motion = "toward";
  return label;
}

DetectedObject object(int id, const cv::Rect2d& box_px, double distance_m = 20) {
  DetectedObject object;
  object.id = id;
  object.box_px = box_px;
  object.distance_m = distance_m;
  object.velocity_mps = Eigen::Vector3d(3, 0, -4);
  return object;
}

const cv::Rect2d kHere(100, 100, 40, 40), kThere(300, 100, 40, 40);

// Objects are demanded from their first frame on.
DetectionScore scoreFromFirstFrame() {
  DetectionScoreParams params;
  params.first_visible_frame = 1;
  return DetectionScore(params);
}

TEST(DetectionScore, HasNoRatesWithoutCounts) {
  DetectionScore score;
  EXPECT_TRUE(std::isnan(score.falsePerFrame()));
  score.add({}, {});
  EXPECT_TRUE(std::isnan(score.all().recall()));
  EXPECT_TRUE(std::isnan(score.all().precision()));
  EXPECT_TRUE(std::isnan(score.all().meanIou()));
  EXPECT_TRUE(std::isnan(median({})));
  EXPECT_EQ(score.falsePerFrame(), 0);
  EXPECT_EQ(score.frames(), 1);
}

TEST(DetectionScore, CountsWhatIsFoundMissedAndFalse) {
  DetectionScore score = scoreFromFirstFrame();
  const FrameVerdict verdict =
      score.add({label(1, kHere), label(2, kThere)},
                {object(7, {500, 100, 30, 30}, 12), object(8, kThere, 21)});
  EXPECT_EQ(verdict.demanded, std::vector<bool>({true, true}));
  EXPECT_EQ(verdict.found_by, std::vector<int>({-1, 1}));
  EXPECT_EQ(verdict.boxes,
            std::vector<FrameVerdict::Box>({FrameVerdict::kFalse, FrameVerdict::kRight}));
  EXPECT_EQ(score.all().demanded, 2);
  EXPECT_EQ(score.all().recall(), 0.5);
  EXPECT_EQ(score.all().precision(), 0.5);
  EXPECT_EQ(score.all().meanIou(), 1);
  EXPECT_EQ(score.falsePerFrame(), 1);
  EXPECT_EQ(score.byMotion().at("toward").found, 1);
  EXPECT_EQ(score.byDistance().at("15-25 m").demanded, 2);
  EXPECT_EQ(score.byDistance().at("0-15 m").false_boxes, 1);
}

TEST(DetectionScore, AMatchNeedsTheIouThreshold) {
  // Shifted by s of 40 px: IoU (40 - s) / (40 + s), 0.3 at s = 21.54.
  for (const auto& [shift, found] : {std::pair(21.5, 1), std::pair(21.6, 0)}) {
    DetectionScore score = scoreFromFirstFrame();
    score.add({label(1, kHere)}, {object(1, {100 + shift, 100, 40, 40})});
    EXPECT_EQ(score.all().found, found) << shift;
    EXPECT_EQ(score.all().false_boxes, 1 - found) << shift;
  }
}

TEST(DetectionScore, ASecondBoxOnAnObjectIsFalse) {
  DetectionScore score = scoreFromFirstFrame();
  const FrameVerdict verdict =
      score.add({label(1, kHere)}, {object(1, {105, 100, 40, 40}), object(2, kHere)});
  EXPECT_EQ(verdict.found_by, std::vector<int>({1})) << "the better one counts";
  EXPECT_EQ(score.all().found, 1);
  EXPECT_EQ(score.all().false_boxes, 1);
}

TEST(DetectionScore, OneBoxFindsOneObject) {
  DetectionScore score = scoreFromFirstFrame();
  score.add({label(1, {100, 100, 40, 40}), label(2, {120, 100, 40, 40})},
            {object(1, {108, 100, 40, 40})});
  EXPECT_EQ(score.all().found, 1);
  EXPECT_EQ(score.all().false_boxes, 0);
}

TEST(DetectionScore, TheBestPairsComeFirst) {
  // The first box fits both objects, the first one better; the second box fits only the first one.
  DetectionScore score = scoreFromFirstFrame();
  const FrameVerdict verdict =
      score.add({label(1, {100, 100, 40, 40}), label(2, {115, 100, 40, 40})},
                {object(1, {104, 100, 40, 40}), object(2, {114, 100, 40, 40})});
  EXPECT_EQ(verdict.found_by, std::vector<int>({0, 1}));
}

TEST(DetectionScore, WhatIsHardOrIgnoredNeitherCountsNorHarms) {
  ObjectLabel hard = label(1, kHere);
  hard.hard = true;
  const ObjectLabel ignored = label(2, kThere, "ignore");
  DetectionScore score = scoreFromFirstFrame();
  score.add({hard, ignored}, {});
  EXPECT_EQ(score.all().demanded, 0);
  // Equal to its box, matched by IoU, and mostly inside it.
  const FrameVerdict verdict =
      score.add({hard, ignored},
                {object(1, kHere), object(2, {90, 90, 60, 60}), object(3, {310, 110, 30, 10})});
  EXPECT_EQ(verdict.boxes, std::vector<FrameVerdict::Box>(3, FrameVerdict::kTolerated));
  EXPECT_EQ(score.all().found, 0);
  EXPECT_EQ(score.all().false_boxes, 0);
  // A box that only touches it is a false positive.
  score.add({hard}, {object(4, {130, 130, 60, 60})});
  EXPECT_EQ(score.all().false_boxes, 1);
}

TEST(DetectionScore, ABoxOnAParkedCarIsFalse) {
  DetectionScore score = scoreFromFirstFrame();
  score.add({label(1, kHere, "static")}, {object(1, kHere)});
  EXPECT_EQ(score.all().demanded, 0);
  EXPECT_EQ(score.all().false_boxes, 1);
}

TEST(DetectionScore, FramesWithoutMoversCountForFalseBoxes) {
  DetectionScore score;
  for (int i = 0; i < 4; ++i) score.add({}, {});
  score.add({}, {object(1, kHere)});
  EXPECT_EQ(score.falsePerFrame(), 0.2);
}

TEST(DetectionScore, DemandsFromTheThirdFrameOfVisibilityOn) {
  DetectionScore score;
  ObjectLabel hard = label(1, kHere);
  hard.hard = true;
  score.add({hard}, {});
  score.add({label(1, kHere)}, {object(1, kHere)});
  EXPECT_EQ(score.all().demanded, 0);
  EXPECT_EQ(score.all().false_boxes, 0) << "found early is no harm";
  score.add({label(1, kHere)}, {});
  EXPECT_EQ(score.all().demanded, 1) << "it was visible while it was hard";
  score.add({}, {});
  score.add({label(1, kHere)}, {});
  score.add({label(1, kHere)}, {});
  EXPECT_EQ(score.all().demanded, 1) << "it was hidden in between";
  score.add({label(1, kHere)}, {});
  EXPECT_EQ(score.all().demanded, 2);
  score.startSequence();
  score.add({label(1, kHere)}, {});
  EXPECT_EQ(score.all().demanded, 2) << "another sequence";
}

TEST(DetectionScore, CountsIdSwitches) {
  DetectionScore score = scoreFromFirstFrame();
  const auto see = [&](int id) {
    score.add({label(1, kHere)},
              id ? std::vector<DetectedObject>{object(id, kHere)} : std::vector<DetectedObject>());
    return score.idSwitches();
  };
  EXPECT_EQ(see(5), 0);
  EXPECT_EQ(see(5), 0);
  EXPECT_EQ(see(0), 0) << "missed";
  EXPECT_EQ(see(5), 0);
  EXPECT_EQ(see(0), 0);
  EXPECT_EQ(see(6), 1) << "found again under another id";
  EXPECT_EQ(see(6), 1);
  EXPECT_EQ(see(5), 2);
  score.startSequence();
  EXPECT_EQ(see(9), 2);
}

TEST(DetectionScore, ErrorsAreThoseOfMatches) {
  DetectionScore score = scoreFromFirstFrame();
  ObjectLabel far = label(2, kThere);
  far.distance_m = 30;
  far.speed_mps = 9;
  ObjectLabel unknown = label(3, {500, 100, 40, 40});
  unknown.distance_m.reset();
  unknown.speed_mps.reset();
  ObjectLabel near = label(1, kHere);
  near.speed_mps = 5.5;
  score.add({near, far, unknown},
            {object(1, kHere, 20.4), object(2, kThere, 29), object(3, {500, 100, 40, 40})});
  ASSERT_EQ(score.all().distance_errors_m.size(), 2u);
  EXPECT_NEAR(score.all().distance_errors_m[0], 0.4, 1e-9);
  EXPECT_NEAR(score.all().distance_errors_m[1], 1.0, 1e-9);
  ASSERT_EQ(score.all().speed_errors_mps.size(), 1u) << "up to 25 m";
  EXPECT_NEAR(score.all().speed_errors_mps[0], 0.5, 1e-9);
  EXPECT_EQ(score.byDistance().at("unknown").found, 1);
  EXPECT_EQ(median({3, 1, 2}), 2);
}

TEST(ObjectLabels, DirectionsAreAgainstTheLineOfSight) {
  EXPECT_EQ(directionOf({0, 0, 20}, {0.5, 0, -3}), "toward");
  EXPECT_EQ(directionOf({0, 0, 20}, {0.5, 0, 3}), "away");
  EXPECT_EQ(directionOf({0, 0, 20}, {3, 0, 1}), "crossing");
  EXPECT_EQ(directionOf({-10, 0, 10}, {5, 0, 5}), "crossing");
  EXPECT_EQ(directionOf({-10, 0, 10}, {5, 0, -5}), "toward");
}

TEST(ObjectLabels, TheStreetDemandsWhatCanBeSeenToMove) {
  const auto demanded = [](double distance_m, double speed_mps, double visible, double side_px) {
    return trueObject(3, 1, "car", {0, 0, side_px, side_px}, distance_m, {0, 0, distance_m},
                      {0, 0, speed_mps}, visible)
        .isDemanded();
  };
  EXPECT_TRUE(demanded(34, 2.1, 0.5, 20));
  EXPECT_FALSE(demanded(36, 2.1, 0.5, 20));
  EXPECT_FALSE(demanded(34, 1.9, 0.5, 20));
  EXPECT_FALSE(demanded(34, 2.1, 0.4, 20));
  EXPECT_FALSE(demanded(34, 2.1, 0.5, 19));
  // Nearer than 10 m: a fifth of the distance each second.
  EXPECT_TRUE(demanded(5, 1.1, 0.5, 20));
  EXPECT_FALSE(demanded(5, 0.9, 0.5, 20));
  EXPECT_FALSE(demanded(11, 1.9, 0.5, 20));
}

}  // namespace
}  // namespace predictive_stereo
