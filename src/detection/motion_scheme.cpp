#include "detection/motion_scheme.h"

#include <optional>

#include "detection/constants.h"
#include "parallel/tasks.h"

namespace predictive_stereo {
namespace {

// Removes the last frame of a fast camera, as little has moved since then. Returns the other frame
// to compare with: the removed one if near objects have moved enough, otherwise past[1].
std::optional<PastFrame> takeOther(std::vector<PastFrame>& past) {
  if (past.size() >= 3 && past[0].seconds < kLeastApart_s) {
    const PastFrame last = past[0];
    past.erase(past.begin());
    if (last.seconds >= kLeastApart_s / 2) return last;
  }
  if (past.size() < 2) return std::nullopt;
  return past[1];
}

}  // namespace

const std::vector<Observation>& MotionScheme::observe(const DetectionInput& input,
                                                      float camera_pixel_px,
                                                      const ObjectTracker& known) {
  runTogether(
      [&] {
        cells_.setFrame(range_, input.measured_disparity_px, input.measured_variance_px2);
        ground_.setFrame(input.rig, cells_);
        obstacles_ = findObstacles(input.rig, cells_, ground_.plane(), camera_pixel_px);
      },
      [&] {
        frames_.remember(input);
        greyTexture(frames_.current().pyramid.level(1), texture_);
      });
  verification_.forgetObjects();
  objects_.clear();
  sought_known_ = false;
  if (input.pose_state != PoseState::kKnown) return objects_;
  std::vector<PastFrame> past = frames_.past();
  const std::optional<PastFrame> other = takeOther(past);
  const FrameView frame{input,  range_,          params_,   frames_.current(),
                        cells_, ground_.plane(), obstacles_};
  if (!past.empty()) {
    runTogether([&] { since_last_.compare(frame.since(past[0]), texture_); },
                [&] {
                  if (other) since_other_.compare(frame.since(*other), texture_);
                  along_.compare(frame, past);
                });
    const double contradicting = since_last_.suspects.share;
    frames_.setFollows(pose_check_.agreesWithMotion(contradicting));
    if (PoseCheck::contradictsMost(contradicting)) free_space_.reset();
    sought_known_ = frames_.current().follows;
  }
  runTogether([&] { objects_ = free_space_.find(frame, cells_); },
              [&] {
                if (sought_known_) findByMotion(frame, past, other, known);
              });
  addMoving(frame, verification_.objects());
  return objects_;
}

void MotionScheme::findByMotion(const FrameView& frame, const std::vector<PastFrame>& past,
                                const std::optional<PastFrame>& other, const ObjectTracker& known) {
  verification_.setFrame(frame, along_.residual_px);
  const PastView since_last = frame.since(past[0]);
  since_last_.find(since_last, verification_);
  // Since that frame, near or fast objects may have moved too much, far or slow ones too little.
  if (other) since_other_.find(frame.since(*other), verification_);
  along_.find(frame, verification_);
  // The known objects at their predicted positions.
  verification_.addAll(
      frame, known.tracks(), [&](const ObjectTrack& track) -> std::optional<VerifiedObject> {
        if (!track.confirmed) return std::nullopt;
        const auto hypothesis = hypothesisOf(since_last, track);
        if (!hypothesis) return std::nullopt;
        return verification_.verify(since_last, since_last_.static_world, *hypothesis);
      });
}

// What free space and motion have both found gets the pixels of both; free space may show several
// parts of what moves as one.
void MotionScheme::addMoving(const FrameView& frame, const std::vector<Observation>& moving) {
  for (const Observation& object : moving) {
    const cv::Rect2d box = object.box_px;
    Observation whole = object;
    bool is_found = false;
    for (auto part = objects_.begin(); part != objects_.end();) {
      const cv::Rect2d of_part = part->box_px;
      const bool is_within = (box & of_part).area() > kMostOfPart * of_part.area();
      if (overlaps(params_, object, *part) && (is_within || !is_found)) {
        Observation both = joined(whole, *part);
        if (measureShape(frame.input, range_, both)) whole = std::move(both);
        is_found = true;
        part = objects_.erase(part);
      } else {
        ++part;
      }
    }
    objects_.push_back(std::move(whole));
  }
}

void MotionScheme::reset() {
  frames_.reset();
  pose_check_.reset();
  free_space_.reset();
  ground_.reset();
}

}  // namespace predictive_stereo
