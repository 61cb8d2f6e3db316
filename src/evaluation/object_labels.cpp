#include "evaluation/object_labels.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace predictive_stereo {
namespace {

constexpr char kHeader[] =
    "frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard";

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> parts;
  std::string part;
  std::istringstream text(line);
  while (std::getline(text, part, ',')) parts.push_back(part);
  if (!line.empty() && line.back() == ',') parts.emplace_back();
  return parts;
}

double number(const std::string& text) {
  size_t used = 0;
  const double value = std::stod(text, &used);
  if (used != text.size()) throw std::invalid_argument(text);
  return value;
}

int whole(const std::string& text) { return static_cast<int>(std::lround(number(text))); }

ObjectLabel parse(const std::vector<std::string>& f) {
  if (f.size() != 12) throw std::invalid_argument("fields");
  ObjectLabel label;
  label.frame = whole(f[0]);
  label.track = whole(f[1]);
  label.type = f[2];
  label.box_px = {cv::Point(whole(f[3]), whole(f[4])), cv::Point(whole(f[5]), whole(f[6]))};
  label.distance_m = f[7].empty() ? std::numeric_limits<double>::quiet_NaN() : number(f[7]);
  label.truncated = whole(f[8]) != 0;
  label.occluded = whole(f[9]);
  label.motion = f[10];
  label.hard = whole(f[11]) != 0;
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
      labels.push_back(parse(fields(line)));
    } catch (const std::logic_error&) {
      throw std::runtime_error(path + ": line " + std::to_string(count) + " \"" + line +
                               "\" is no label");
    }
  }
  return labels;
}

cv::Mat1b movingMask(const std::vector<ObjectLabel>& labels, int frame, cv::Size size,
                     int margin_px) {
  cv::Mat1b mask = cv::Mat1b::zeros(size);
  const cv::Point margin(margin_px, margin_px);
  for (const ObjectLabel& label : labels)
    if (label.frame == frame && !label.isStatic())
      mask(cv::Rect(label.box_px.tl() - margin, label.box_px.br() + margin) &
           cv::Rect({0, 0}, size)) = 255;
  return mask;
}

}  // namespace predictive_stereo
