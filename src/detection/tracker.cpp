#include "detection/tracker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>

#include "detection/constants.h"

namespace predictive_stereo {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

// Kalman update with a measurement of one half of the state, which `h` selects.
void kalmanUpdate(const Matrix36& h, const Eigen::Vector3d& measured, const Eigen::Matrix3d& noise,
                  Eigen::Matrix<double, 6, 1>& state, Matrix6& covariance) {
  const Eigen::Matrix3d s = h * covariance * h.transpose() + noise;
  const Eigen::Matrix<double, 6, 3> gain = covariance * h.transpose() * s.inverse();
  state += gain * (measured - h * state);
  const Matrix6 rest = Matrix6::Identity() - gain * h;
  covariance = rest * covariance * rest.transpose() + gain * noise * gain.transpose();
}

// The three elements of the state from `first` on.
Matrix36 partOfState(int first) {
  Matrix36 h = Matrix36::Zero();
  h.middleCols<3>(first).setIdentity();
  return h;
}

// Natural logarithm of the odds that an observation is right. They grow with its score, and with
// its pixels: many pixels agree less often by chance.
double evidenceOf(const Observation& seen) {
  const double score = std::clamp(seen.score, 1 - kMostCertain, kMostCertain);
  return std::log(score / (1 - score) * std::max(seen.box_px.area(), 1) / kPixelsOfOdds);
}

// The image box of an object whose centre has moved in space.
cv::Rect movedBox(const StereoRig& rig, const cv::Rect& box, const Eigen::Vector3d& before,
                  const Eigen::Vector3d& now) {
  const double scale = before.z() / now.z();
  const Eigen::Vector3d from = rig.disparityFromPoint(before), to = rig.disparityFromPoint(now);
  const double x = to.x() + scale * (box.x - from.x()), y = to.y() + scale * (box.y - from.y());
  return {cv::Point(cvRound(x), cvRound(y)),
          cv::Size(cvRound(scale * box.width), cvRound(scale * box.height))};
}

}  // namespace

void ObjectTracker::predict(double stamp_s, const StereoRig& rig,
                            const std::optional<Eigen::Isometry3d>& T_odom_cam) {
  rig_ = rig;
  now_s_ = stamp_s;
  T_odom_cam_ = T_odom_cam;
  for (ObjectTrack& track : tracks_) {
    track.observation = -1;
    ++track.age;
    ++track.unseen_frames;
  }
  if (!T_odom_cam) return;
  const double dt = located_s_ ? stamp_s - *located_s_ : 0;
  interval_s_ = dt;
  located_s_ = stamp_s;
  Matrix6 transition = Matrix6::Identity();
  transition.topRightCorner<3, 3>() = dt * Eigen::Matrix3d::Identity();
  // White-noise acceleration.
  const double q = params_.acceleration_mps2 * params_.acceleration_mps2;
  Matrix6 noise = Matrix6::Zero();
  noise.topLeftCorner<3, 3>().diagonal().setConstant(q * dt * dt * dt * dt / 4);
  noise.topRightCorner<3, 3>().diagonal().setConstant(q * dt * dt * dt / 2);
  noise.bottomLeftCorner<3, 3>().diagonal().setConstant(q * dt * dt * dt / 2);
  noise.bottomRightCorner<3, 3>().diagonal().setConstant(q * dt * dt);
  // Whether it is still in view.
  const auto move = [&](ObjectTrack& track) {
    if (!track.located) return true;
    track.state = transition * track.state;
    track.covariance = transition * track.covariance * transition.transpose() + noise;
    const Eigen::Vector3d centre = T_odom_cam->inverse() * track.state.head<3>();
    if (!(centre.z() > 0.5)) return false;
    track.last.box_px = movedBox(rig, track.last.box_px, track.last.centre_m, centre);
    track.last.distance_m += centre.z() - track.last.centre_m.z();
    track.last.centre_m = centre;
    return true;
  };
  for (auto track = tracks_.begin(); track != tracks_.end();)
    track = move(*track) ? std::next(track) : tracks_.erase(track);
}

void ObjectTracker::update(const std::vector<Observation>& observations, bool sought) {
  // The best pair is assigned first: the result does not depend on the order of objects.
  std::vector<std::tuple<double, size_t, size_t>> pairs;
  for (size_t t = 0; t < tracks_.size(); ++t)
    for (size_t o = 0; o < observations.size(); ++o) {
      const Observation& seen = observations[o];
      const Observation& last = tracks_[t].last;
      // Until its velocity is known, an object may as well move with the camera.
      double iou = intersectionOverUnion(seen.box_px, last.box_px);
      if (!tracks_[t].confirmed && !last.has_velocity)
        iou = std::max(iou, intersectionOverUnion(seen.box_px, tracks_[t].seen_box_px));
      if (iou > 0 && iou >= params_.min_iou) pairs.emplace_back(-iou, t, o);
    }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> taken(observations.size(), false);
  for (const auto& [cost, t, o] : pairs) {
    if (taken[o] || tracks_[t].observation >= 0) continue;
    taken[o] = true;
    tracks_[t].observation = static_cast<int>(o);
    correct(observations[o], tracks_[t]);
  }

  for (auto track = tracks_.begin(); track != tracks_.end();)
    track = goesOn(*track, sought) ? std::next(track) : tracks_.erase(track);
  for (size_t o = 0; o < observations.size(); ++o)
    if (!taken[o]) {
      tracks_.push_back(start(observations[o]));
      tracks_.back().observation = static_cast<int>(o);
    }
}

// Notes whether a track was observed in this frame. False if it was missed for too long.
bool ObjectTracker::goesOn(ObjectTrack& track, bool sought) const {
  if (sought || track.observation >= 0)
    track.history = track.history << 1 | (track.observation >= 0 ? 1 : 0);
  else if (now_s_ - track.seen_s > kLongestGap_s)
    return false;
  const unsigned recent = (2u << params_.max_missed_frames) - 1;
  return (track.history & recent) != 0;
}

void ObjectTracker::correct(const Observation& observation, ObjectTrack& track) const {
  track.last = observation;
  ++track.observations;
  track.evidence += evidenceOf(observation);
  if (track.observations >= params_.confirm_frames && track.evidence >= params_.confirm_evidence)
    track.confirmed = true;
  track.seen_box_px = observation.box_px;
  track.unseen_frames = 0;
  track.seen_s = now_s_;
  if (!T_odom_cam_) return;
  if (!track.located) return locate(observation, track);
  const Eigen::Matrix3d R = T_odom_cam_->linear();
  kalmanUpdate(partOfState(0), Eigen::Vector3d(*T_odom_cam_ * observation.centre_m),
               Eigen::Matrix3d(R * observation.centre_covariance * R.transpose()), track.state,
               track.covariance);
  correctVelocity(observation, track);
}

// White-noise acceleration: by such a variance the velocity has changed since it was the mean.
void ObjectTracker::correctVelocity(const Observation& observation, ObjectTrack& track) const {
  if (!observation.has_velocity) return;
  const double q = params_.acceleration_mps2 * params_.acceleration_mps2;
  const double changed = q * interval_s_ * observation.velocity_span_s / 3;
  kalmanUpdate(partOfState(3), observation.velocity_mps,
               observation.velocity_covariance + changed * Eigen::Matrix3d::Identity(), track.state,
               track.covariance);
}

// Its first position and velocity in the odom frame.
void ObjectTracker::locate(const Observation& observation, ObjectTrack& track) const {
  track.located = true;
  const Eigen::Matrix3d R = T_odom_cam_->linear();
  const double speed = largest_speed_mps_;
  track.state << *T_odom_cam_ * observation.centre_m, Eigen::Vector3d::Zero();
  track.covariance.setZero();
  track.covariance.topLeftCorner<3, 3>() = R * observation.centre_covariance * R.transpose();
  track.covariance.bottomRightCorner<3, 3>().diagonal().setConstant(speed * speed / 9);
  correctVelocity(observation, track);
}

ObjectTrack ObjectTracker::start(const Observation& observation) {
  ObjectTrack track;
  track.id = next_id_++;
  track.history = 1;
  track.age = 1;
  track.state.setZero();
  track.covariance.setZero();
  correct(observation, track);
  return track;
}

DetectedObject ObjectTracker::describe(const ObjectTrack& track) const {
  DetectedObject object;
  object.id = track.id;
  object.age = track.age;
  object.box_px = track.last.box_px & cv::Rect(cv::Point(), rig_.size);
  object.centre_m = track.last.centre_m;
  object.size_m = track.last.size_m;
  object.distance_m = track.last.distance_m;
  object.velocity_mps = track.state.tail<3>();
  object.velocity_covariance = track.covariance.bottomRightCorner<3, 3>();
  object.score = track.last.score;
  return object;
}

void ObjectTracker::reset() {
  tracks_.clear();
  located_s_.reset();
}

bool isStillThere(const DetectionInput& input, const DisparityRange& range,
                  const Observation& moved_along, double margin_m, cv::Mat1b& mask) {
  const cv::Rect box = moved_along.box_px & cv::Rect(cv::Point(), input.rig.size);
  const double nearest_m = moved_along.distance_m - margin_m,
               farthest_m = moved_along.distance_m + moved_along.size_m.z() + margin_m;
  if (box.empty()) return false;
  const auto disparityAt = [&](double depth_m) {
    return depth_m > 0 ? static_cast<float>(input.rig.disparityTimesDepth() / depth_m)
                       : std::numeric_limits<float>::infinity();
  };
  const float nearest_px = disparityAt(nearest_m) + kDisparityError_px;
  const float farthest_px = disparityAt(farthest_m) - kDisparityError_px;
  mask.create(box.size());
  int inside = 0;
  for (int y = 0; y < box.height; ++y) {
    const float* const disparity = input.measured_disparity_px[box.y + y] + box.x;
    uchar* const of_row = mask[y];
    for (int x = 0; x < box.width; ++x) {
      const bool is_inside =
          range.isValid(disparity[x]) && disparity[x] >= farthest_px && disparity[x] <= nearest_px;
      of_row[x] = is_inside ? 255 : 0;
      inside += is_inside;
    }
  }
  return 2 * inside > box.area();
}

}  // namespace predictive_stereo
