#include "detection/pose_check.h"

namespace predictive_stereo {
namespace {

constexpr double kMostOfTheImage = 0.8, kSuddenShare = 0.2;
constexpr int kMostOddFrames = 2;

}  // namespace

bool PoseCheck::contradictsMost(double contradicting) { return contradicting > kMostOfTheImage; }

bool PoseCheck::agreesWithMotion(double contradicting) {
  const bool odd =
      contradictsMost(contradicting) || (usual_ && contradicting > *usual_ + kSuddenShare);
  if (odd && odd_frames_ < kMostOddFrames) {
    ++odd_frames_;
    return false;
  }
  odd_frames_ = 0;
  usual_ = contradicting;
  return true;
}

}  // namespace predictive_stereo
