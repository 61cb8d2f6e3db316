#include <boost/algorithm/string/predicate.hpp>
#include <cstring>
#include <set>
#include <utility>

#include "tools/bag_check.h"

namespace predictive_stereo {
namespace {

using boost::algorithm::ends_with;

constexpr char kRobot[] = "predictive_stereo.launch", kKitti[] = "kitti.launch";

// Left and right image topics within a camera's namespace, in order of preference. The last are
// RealSense's infrared pair, which is rectified, although its name does not say so.
constexpr const char* kNames[][2] = {{"/left/image_rect", "/right/image_rect"},
                                     {"/left/image_rect_gray", "/right/image_rect_gray"},
                                     {"/left/image_rect_color", "/right/image_rect_color"},
                                     {"/left/image_raw", "/right/image_raw"},
                                     {"/infra1/image_rect_raw", "/infra2/image_rect_raw"}};

// Selects the compressed images if there are no raw ones.
void takeAsRecorded(const TopicTypes& types, CameraLayout& layout) {
  StereoTopics& topics = layout.topics;
  const std::string left = asRecorded(types, topics.left), right = asRecorded(types, topics.right);
  if (left == topics.left || right == topics.right) return;
  topics.left = left;
  topics.right = right;
  layout.arguments.push_back("image_transport:=compressed");
}

void addIfThere(const TopicTypes& types, CameraLayout layout, std::vector<CameraLayout>& found) {
  takeAsRecorded(types, layout);
  if (layout.topics.areIn(types)) found.push_back(std::move(layout));
}

// Image topics of any transport, without the suffix of the transport.
std::set<std::string> imageTopics(const TopicTypes& types) {
  std::set<std::string> topics;
  for (const auto& known : types) topics.insert(imageTopic(known.first));
  return topics;
}

// A layout whose topics differ from the nodelets' default names.
CameraLayout remapped(const std::string& name, const std::string& camera,
                      const StereoTopics& topics) {
  return {name,
          topics,
          kRobot,
          {"camera:=" + camera, "left_image:=" + topics.left, "left_info:=" + topics.left_info,
           "right_image:=" + topics.right, "right_info:=" + topics.right_info}};
}

std::vector<CameraLayout> kittiLayouts() {
  std::vector<CameraLayout> layouts;
  for (const std::string cameras : {"gray", "color"}) {
    const auto add = [&](const std::string& name, const std::string& profile,
                         const std::string& left, const std::string& right) {
      layouts.push_back({name + ", " + cameras,
                         StereoTopics::ofImages(left, right),
                         kKitti,
                         {"profile:=" + profile, "cameras:=" + cameras},
                         true});
    };
    const std::string left = "/kitti/camera_" + cameras + "_left",
                      right = "/kitti/camera_" + cameras + "_right";
    const bool gray = cameras == "gray";
    add("kitti2bag raw_synced", "raw", left + "/image_raw", right + "/image_raw");
    add("kitti2bag odom", "odom", left + "/image_rect", right + "/image_rect");
    add("kitti_to_rosbag (ETH)", "eth", gray ? "/cam00/image_raw" : "/cam02/image_raw",
        gray ? "/cam01/image_raw" : "/cam03/image_raw");
  }
  return layouts;
}

}  // namespace

std::vector<CameraLayout> findCameras(const TopicTypes& types) {
  std::vector<CameraLayout> found;
  for (const CameraLayout& layout : kittiLayouts()) addIfThere(types, layout, found);

  const std::set<std::string> images = imageTopics(types);
  for (const auto& [left, right] : kNames)
    for (const std::string& topic : images) {
      if (!ends_with(topic, left)) continue;
      const std::string camera = topic.substr(0, topic.size() - std::strlen(left));
      const std::string ns = camera.empty() ? "/" : camera;
      const StereoTopics topics = StereoTopics::ofImages(camera + left, camera + right);
      CameraLayout layout{"stereo camera " + ns, topics, kRobot, {"camera:=" + ns}};
      if (ends_with(left, "image_raw")) {
        layout.name += ", raw";
        layout.arguments.push_back("rectify:=true");
        layout.is_raw = true;
      } else if (ends_with(left, "image_rect_raw")) {
        layout = remapped("infrared pair of " + ns, ns, topics);
      } else if (!ends_with(left, "image_rect")) {
        layout = remapped(layout.name + ", " + (std::strrchr(left, '/') + 1), ns, topics);
      }
      addIfThere(types, layout, found);
    }
  return found;
}

CameraLayout chosenCamera(const StereoTopicChoice& choice, const TopicTypes& types) {
  CameraLayout layout;
  if (!choice.camera.empty()) {
    const std::string camera = cameraNamespace(choice.camera);
    const std::string ns = camera.empty() ? "/" : camera;
    layout = {"stereo camera " + ns,
              StereoTopics::ofImages(camera + "/left/image_rect", camera + "/right/image_rect"),
              kRobot,
              {"camera:=" + ns}};
  } else {
    layout = remapped("chosen topics", "/stereo",
                      StereoTopics::ofImages(imageTopic(choice.left), imageTopic(choice.right)));
  }
  takeAsRecorded(types, layout);
  return layout;
}

}  // namespace predictive_stereo
