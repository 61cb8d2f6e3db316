#include "detection/verification.h"

#include <algorithm>

namespace predictive_stereo {
namespace {

using Source = Hypothesis::Source;

// The object of a segment in full resolution: pixels of its lattice cells within the layer.
Observation observedObject(const DetectionInput& input, const Segment& segment, float nearest,
                           float farthest) {
  Observation object;
  const cv::Rect image(cv::Point(), input.rig.size);
  const cv::Rect box = cv::Rect(2 * segment.area.x, 2 * segment.area.y, 2 * segment.area.width,
                                2 * segment.area.height) &
                       image;
  object.box_px = box;
  object.mask.create(box.size());
  for (int y = 0; y < box.height; ++y) {
    const float* disparity = input.measured_disparity_px[box.y + y] + box.x;
    const uchar* cell = segment.mask[y / 2];
    uchar* pixel = object.mask[y];
    for (int x = 0; x < box.width; ++x)
      pixel[x] =
          cell[x / 2] & -static_cast<int>((disparity[x] >= farthest) & (disparity[x] <= nearest));
  }
  return object;
}

Extent extentOf(const FrameView& frame, const Observation& seen, float disparity_px) {
  const cv::Rect& box = seen.box_px;
  const StereoRig& rig = frame.input.rig;
  Extent extent{
      box.width * seen.centre_m.z() / rig.fx_px, box.height * seen.centre_m.z() / rig.fy_px, {}};
  if (!frame.ground) return extent;
  const auto heightAt = [&](int y) {
    return frame.ground->heightAt(box.x + box.width / 2, y, disparity_px);
  };
  extent.above_ground = {heightAt(box.br().y), heightAt(box.y)};
  return extent;
}

// Whether the object's motion explains the images.
bool explainsImages(const MotionDetectionParams& params, const Segment& segment) {
  return segment.decisive > 0 && segment.explained >= params.min_explained;
}

// Whether disparity residuals show motion along the line of sight, and the images do not refute it.
bool showsInResiduals(const MotionDetectionParams& params, const Segment& segment) {
  return segment.dense >= params.min_explained &&
         (segment.explained >= 0.5 || segment.decisive == 0);
}

}  // namespace

void Verification::setFrame(const FrameView& frame, const cv::Mat1f& residual_px) {
  residual_px_ = residual_px;
  taken_.create(frame.lattice());
  taken_.setTo(0);
}

bool Verification::isFree(const Hypothesis& hypothesis) const {
  int free = 0;
  for (cv::Point p : hypothesis.seeds) free += !taken_(p);
  return 2 * free >= static_cast<int>(hypothesis.seeds.size());
}

std::optional<VerifiedObject> Verification::verify(const PastView& view,
                                                   const cv::Mat1f& static_world,
                                                   const Hypothesis& hypothesis) const {
  const FrameView& frame = view.frame;
  const DetectionInput& input = frame.input;
  const PastFrame& past = view.past;
  if (hypothesis.moved_m.norm() > frame.params.largest_speed_mps * past.seconds)
    return std::nullopt;
  if (!isFree(hypothesis)) return std::nullopt;
  auto found = segment(view, static_world, residual_px_, hypothesis);
  if (!found) return std::nullopt;
  const bool by_images = explainsImages(frame.params, *found);
  if (!by_images &&
      (hypothesis.source == Source::kAcross || !showsInResiduals(frame.params, *found)))
    return std::nullopt;

  Observation seen = observedObject(input, *found, hypothesis.nearest_px, hypothesis.farthest_px);
  if (!measureShape(input, frame.range, seen)) return std::nullopt;
  const LowerEnd lower_end =
      lowerEndOf(frame.cells, frame.ground, seen.box_px, hypothesis.nearest_px);
  if (!isPlausible(frame.params, extentOf(frame, seen, hypothesis.disparity_px), lower_end))
    return std::nullopt;
  seen.centre_covariance = centreCovariance(input.rig, hypothesis.disparity_px);
  const Eigen::Matrix3d R = past.frame->T_odom_cam.linear();
  seen.has_velocity = hypothesis.source != Source::kKnown;
  seen.velocity_span_s = past.seconds;
  seen.velocity_mps = R * hypothesis.moved_m / past.seconds;
  seen.velocity_covariance =
      R * hypothesis.covariance * R.transpose() / (past.seconds * past.seconds);
  seen.score = std::clamp(by_images ? found->explained : found->dense, 0.0, 1.0);
  return VerifiedObject{std::move(seen), hypothesis, std::move(*found)};
}

// Joins an object with another one if they move as one. Otherwise adds it instead of its parts,
// unless it was found already, or is a part of another one.
void Verification::add(const FrameView& frame, VerifiedObject&& verified) {
  const Observation& seen = verified.object;
  if (!isFree(verified.hypothesis)) return;
  const auto take = [&] { taken_(verified.segment.area).setTo(255, verified.segment.mask); };
  const auto dropPartsOf = [&](const Observation& whole) {
    objects_.erase(std::remove_if(objects_.begin(), objects_.end(),
                                  [&](const Observation& other) {
                                    return belongsTo(frame.params, other, whole);
                                  }),
                   objects_.end());
  };
  for (Observation& other : objects_) {
    if (!moveAsOne(frame.input, frame.params, other, seen)) continue;
    Observation whole = joined(other, seen);
    if (!measureShape(frame.input, frame.range, whole) ||
        whole.size_m.x() > frame.params.max_width_m)
      continue;
    other = whole;
    dropPartsOf(whole);
    return take();
  }
  // Which of them was found first does not matter.
  for (const Observation& other : objects_)
    if (belongsTo(frame.params, seen, other) ||
        (overlaps(frame.params, seen, other) && !belongsTo(frame.params, other, seen)))
      return;
  dropPartsOf(seen);
  take();
  objects_.push_back(std::move(verified.object));
}

}  // namespace predictive_stereo
