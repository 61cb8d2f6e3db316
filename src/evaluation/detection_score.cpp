#include "evaluation/detection_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <tuple>

namespace predictive_stereo {
namespace {

constexpr double kFarthestDemanded_m = 35, kSlowestDemanded_mps = 2, kSpeedScored_m = 25;
constexpr double kLeastVisible = 0.5;
constexpr int kSmallestSide_px = 20, kSmallestArea_px = 400;

double intersectionOverUnion(const cv::Rect2f& a, const cv::Rect2f& b) {
  const double both = (a & b).area();
  return both / std::max(static_cast<double>(a.area()) + b.area() - both, 1e-9);
}

double shareWithin(const cv::Rect2f& box, const cv::Rect2f& other) {
  return (box & other).area() / std::max(box.area(), 1e-6f);
}

std::string distanceGroup(const std::optional<double>& distance_m) {
  if (!distance_m) return "unknown";
  if (*distance_m < 15) return "0-15 m";
  if (*distance_m < 25) return "15-25 m";
  if (*distance_m < 35) return "25-35 m";
  return "35 m and more";
}

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  if (!line.empty() && line.back() == ',') fields.emplace_back();
  return fields;
}

double number(const std::string& text) {
  size_t used = 0;
  const double value = std::stod(text, &used);
  if (used != text.size() || !std::isfinite(value)) throw std::invalid_argument(text);
  return value;
}

LabelledObject labelOf(const std::vector<std::string>& fields) {
  if (fields.size() != 12) throw std::invalid_argument("not 12 fields");
  LabelledObject label;
  label.frame = static_cast<int>(number(fields[0]));
  label.track = static_cast<int>(number(fields[1]));
  label.class_name = fields[2];
  const cv::Point2f first(static_cast<float>(number(fields[3])),
                          static_cast<float>(number(fields[4])));
  const cv::Point2f last(static_cast<float>(number(fields[5])),
                         static_cast<float>(number(fields[6])));
  if (!(last.x > first.x && last.y > first.y)) throw std::invalid_argument("an empty box");
  label.box_px = cv::Rect2f(first, last);
  if (!fields[7].empty()) label.distance_m = number(fields[7]);
  label.motion = fields[10];
  if (label.class_name == "static")
    label.kind = LabelledObject::Kind::kStatic;
  else if (label.class_name == "ignore" || number(fields[11]) != 0)
    label.kind = LabelledObject::Kind::kTolerated;
  return label;
}

// Of the motion against the line of sight.
std::string directionOf(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& velocity_cam) {
  const double along = velocity_cam.dot(centre_m.normalized());
  if (std::abs(along) < 0.7 * velocity_cam.norm()) return "crossing";
  return along < 0 ? "toward" : "away";
}

void printCounts(const std::string& name, const DetectionCounts& counts, std::ostream& out) {
  out << "  " << std::left << std::setw(16) << name << std::right << std::setw(6) << counts.found
      << " of" << std::setw(6) << counts.demanded << "   recall " << counts.recall() << "  IoU "
      << counts.meanIou();
  if (!counts.distance_errors_m.empty())
    out << "  distance +-" << median(counts.distance_errors_m) << " m";
  if (!counts.speed_errors_mps.empty())
    out << "  speed +-" << median(counts.speed_errors_mps) << " m/s";
  out << "\n";
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Labels readLabels(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path + ": cannot be read");
  std::string line;
  const std::string header =
      "frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard";
  std::getline(in, line);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  if (line != header)
    throw std::runtime_error(path + ":1: '" + line + "': the first line must be '" + header + "'");
  Labels labels;
  for (int count = 2; std::getline(in, line); ++count) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    try {
      const LabelledObject label = labelOf(fieldsOf(line));
      labels[label.frame].push_back(label);
    } catch (const std::logic_error&) {
      throw std::runtime_error(path + ":" + std::to_string(count) + ": '" + line +
                               "': not a label (" + header + ")");
    }
  }
  return labels;
}

std::vector<LabelledObject> labelsOf(const StreetFrame& frame) {
  std::vector<LabelledObject> labels;
  for (const StreetMover& mover : frame.movers) {
    LabelledObject label;
    label.frame = frame.index;
    label.track = mover.id;
    label.class_name = mover.kind;
    label.box_px = mover.box_px;
    label.distance_m = mover.distance_m;
    label.speed_mps = mover.velocity_mps.norm();
    label.motion =
        directionOf(mover.centre_m, frame.T_world_cam.linear().transpose() * mover.velocity_mps);
    const bool large =
        mover.visible_px >= kSmallestArea_px ||
        (mover.box_px.width >= kSmallestSide_px && mover.box_px.height >= kSmallestSide_px);
    const bool demanded =
        mover.distance_m<kFarthestDemanded_m&& * label.speed_mps> kSlowestDemanded_mps && large &&
        mover.occluded <= 1 - kLeastVisible && mover.truncated <= 1 - kLeastVisible;
    label.kind = demanded ? LabelledObject::Kind::kDemanded : LabelledObject::Kind::kTolerated;
    labels.push_back(label);
  }
  return labels;
}

void DetectionScore::startSequence() {
  frames_of_track_.clear();
  id_of_track_.clear();
}

std::vector<std::optional<bool>> DetectionScore::add(const std::vector<LabelledObject>& labels,
                                                     const std::vector<DetectedObject>& objects) {
  using Kind = LabelledObject::Kind;
  ++frames;
  std::vector<Kind> kinds;
  for (const LabelledObject& label : labels) {
    Kind kind = label.kind;
    if (kind == Kind::kDemanded && ++frames_of_track_[label.track] < params_.first_frame_of_track)
      kind = Kind::kTolerated;
    kinds.push_back(kind);
  }

  // The best pair first.
  std::vector<std::tuple<double, size_t, size_t>> pairs;
  for (size_t l = 0; l < labels.size(); ++l)
    for (size_t o = 0; o < objects.size(); ++o) {
      const double iou = intersectionOverUnion(labels[l].box_px, objects[o].box_px);
      if (kinds[l] == Kind::kDemanded && iou >= params_.min_iou) pairs.emplace_back(-iou, l, o);
    }
  std::sort(pairs.begin(), pairs.end());
  std::vector<int> object_of(labels.size(), -1);
  std::vector<std::optional<bool>> verdicts(objects.size(), false);
  for (const auto& [negative_iou, l, o] : pairs) {
    if (object_of[l] >= 0 || *verdicts[o]) continue;
    object_of[l] = static_cast<int>(o);
    verdicts[o] = true;
    ++matched;
  }

  for (size_t l = 0; l < labels.size(); ++l) {
    if (kinds[l] != Kind::kDemanded) continue;
    const LabelledObject& label = labels[l];
    for (DetectionCounts* counts :
         {&all, &by_motion[label.motion], &by_distance[distanceGroup(label.distance_m)]}) {
      ++counts->demanded;
      if (object_of[l] < 0) continue;
      const DetectedObject& object = objects[static_cast<size_t>(object_of[l])];
      ++counts->found;
      counts->sum_iou += intersectionOverUnion(label.box_px, object.box_px);
      if (label.distance_m)
        counts->distance_errors_m.push_back(std::abs(object.distance_m - *label.distance_m));
      if (label.speed_mps && label.distance_m && *label.distance_m < kSpeedScored_m)
        counts->speed_errors_mps.push_back(std::abs(object.velocity_mps.norm() - *label.speed_mps));
    }
    if (object_of[l] < 0) continue;
    const int id = objects[static_cast<size_t>(object_of[l])].id;
    const auto known = id_of_track_.find(label.track);
    if (known != id_of_track_.end() && known->second != id) ++id_switches;
    id_of_track_[label.track] = id;
  }

  for (size_t o = 0; o < objects.size(); ++o) {
    if (*verdicts[o]) continue;
    double share = 0;
    for (size_t l = 0; l < labels.size(); ++l) {
      if (kinds[l] != Kind::kTolerated) continue;
      if (intersectionOverUnion(labels[l].box_px, objects[o].box_px) >= params_.min_iou) share = 1;
      share += shareWithin(objects[o].box_px, labels[l].box_px);
    }
    if (share >= params_.tolerated_share)
      verdicts[o].reset();
    else
      ++false_boxes;
  }
  return verdicts;
}

void print(const DetectionScore& score, const std::string& title, std::ostream& out) {
  const auto flags = out.flags();
  out << std::fixed << std::setprecision(2);
  out << title << ": " << score.frames << " frames, recall " << score.all.recall() << ", precision "
      << score.precision() << ", false boxes per frame " << std::setprecision(3)
      << score.falsePerFrame() << ", id switches " << score.id_switches << "\n"
      << std::setprecision(2);
  printCounts("all", score.all, out);
  for (const auto& [name, counts] : score.by_motion) printCounts(name, counts, out);
  for (const auto& [name, counts] : score.by_distance) printCounts(name, counts, out);
  out.flags(flags);
}

}  // namespace predictive_stereo
