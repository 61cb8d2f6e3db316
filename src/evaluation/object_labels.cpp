#include "evaluation/object_labels.h"

#include <algorithm>
#include <boost/algorithm/string/split.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace predictive_stereo {
namespace {

constexpr char kHeader[] =
    "frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard";

constexpr double kFarthestDemanded_m = 35, kLeastVisible = 0.5, kSmallestDemanded_px2 = 400;

// Near objects count though they are slow: a fifth of the distance each second.
double slowestDemanded_mps(double distance_m) { return std::min(2.0, distance_m / 5); }

double number(const std::string& text) {
  constexpr double kLargest = 1e9;  // larger ones mean nothing here, and do not fit into an int
  size_t used = 0;
  const double value = std::stod(text, &used);
  if (used != text.size() || !(std::abs(value) <= kLargest)) throw std::invalid_argument(text);
  return value;
}

int whole(const std::string& text) { return static_cast<int>(std::lround(number(text))); }

ObjectLabel parse(const std::vector<std::string>& f) {
  if (f.size() != 12) throw std::invalid_argument("fields");
  ObjectLabel label;
  label.frame = whole(f[0]);
  label.track = whole(f[1]);
  label.type = f[2];
  const cv::Point2d first(number(f[3]), number(f[4])), last(number(f[5]), number(f[6]));
  if (!(first.x < last.x && first.y < last.y)) throw std::invalid_argument("empty box");
  label.box_px = cv::Rect2d(first, last);
  if (!f[7].empty()) label.distance_m = number(f[7]);
  label.motion = f[10];
  label.hard = !f[11].empty() && whole(f[11]) != 0;
  return label;
}

}  // namespace

std::vector<ObjectLabel> readObjectLabels(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read (labels)");
  std::vector<ObjectLabel> labels;
  std::string line;
  for (int count = 1; std::getline(file, line); ++count) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (count == 1 && line != kHeader)
      throw std::runtime_error(path + ": first line must be " + kHeader);
    if (count == 1 || line.empty()) continue;
    try {
      std::vector<std::string> fields;
      labels.push_back(
          parse(boost::algorithm::split(fields, line, [](char c) { return c == ','; })));
    } catch (const std::logic_error&) {
      throw std::runtime_error(path + ": line " + std::to_string(count) + " \"" + line +
                               "\" is not a label: 12 fields, x1 < x2, y1 < y2");
    }
  }
  return labels;
}

std::vector<ObjectLabel> labelsOf(const std::vector<ObjectLabel>& labels, int frame) {
  std::vector<ObjectLabel> chosen;
  std::copy_if(labels.begin(), labels.end(), std::back_inserter(chosen),
               [&](const ObjectLabel& label) { return label.frame == frame; });
  return chosen;
}

std::string directionOf(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& velocity_cam_mps) {
  const double along = velocity_cam_mps.dot(centre_m.normalized());
  if (std::abs(along) < std::sqrt(0.5) * velocity_cam_mps.norm()) return "crossing";
  return along < 0 ? "toward" : "away";
}

ObjectLabel trueObject(int frame, int id, const std::string& type, const cv::Rect2d& box_px,
                       double distance_m, const Eigen::Vector3d& centre_m,
                       const Eigen::Vector3d& velocity_cam_mps, double visible) {
  ObjectLabel label;
  label.frame = frame;
  label.track = id;
  label.type = type;
  label.box_px = box_px;
  label.distance_m = distance_m;
  label.speed_mps = velocity_cam_mps.norm();
  label.motion = directionOf(centre_m, velocity_cam_mps);
  label.hard = distance_m >= kFarthestDemanded_m ||
               *label.speed_mps <= slowestDemanded_mps(distance_m) || visible < kLeastVisible ||
               box_px.area() < kSmallestDemanded_px2;
  return label;
}

std::vector<ObjectLabel> labelsOf(const StreetFrame& frame) {
  const Eigen::Matrix3d R_cam_world = frame.T_world_cam.linear().transpose();
  std::vector<ObjectLabel> labels;
  for (const StreetMover& mover : frame.movers)
    labels.push_back(trueObject(frame.index, mover.id, mover.kind, mover.box_px, mover.distance_m,
                                mover.centre_m, R_cam_world * mover.velocity_mps,
                                mover.visibleShare()));
  return labels;
}

cv::Mat1b movingMask(const std::vector<ObjectLabel>& labels, int frame, cv::Size size,
                     int margin_px) {
  cv::Mat1b mask = cv::Mat1b::zeros(size);
  const cv::Point margin(margin_px, margin_px);
  for (const ObjectLabel& label : labels)
    if (label.frame == frame && !label.isStatic())
      mask(cv::Rect(cv::Point(label.box_px.tl()) - margin, cv::Point(label.box_px.br()) + margin) &
           cv::Rect({0, 0}, size)) = 255;
  return mask;
}

}  // namespace predictive_stereo
