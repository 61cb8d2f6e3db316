#include <boost/algorithm/string/predicate.hpp>
#include <set>
#include <utility>

#include "tools/bag_check.h"

namespace predictive_stereo {
namespace {

constexpr char kRobot[] = "predictive_stereo.launch", kKitti[] = "kitti.launch";

// Folders of left and right images within a camera's, and their name, in order of preference. The
// last is RealSense's infrared pair, which is rectified, although its name does not say so.
constexpr const char* kNames[][3] = {{"/left", "/right", "image_rect"},
                                     {"/left", "/right", "image_rect_color"},
                                     {"/left", "/right", "image_raw"},
                                     {"/infra1", "/infra2", "image_rect_raw"}};

StereoTopics topicsOf(const std::string& left_folder, const std::string& right_folder,
                      const std::string& image) {
  return StereoTopics::ofImages(left_folder + "/" + image, right_folder + "/" + image);
}

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

std::string folderOf(const std::string& topic) { return topic.substr(0, topic.rfind('/')); }

std::string nameOf(const std::string& topic) { return topic.substr(topic.rfind('/') + 1); }

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
                         const std::string& left, const std::string& right, const char* image) {
      layouts.push_back({name + ", " + cameras,
                         topicsOf(left, right, image),
                         kKitti,
                         {"profile:=" + profile, "cameras:=" + cameras},
                         true});
    };
    const std::string left = "/kitti/camera_" + cameras + "_left",
                      right = "/kitti/camera_" + cameras + "_right";
    const bool gray = cameras == "gray";
    add("kitti2bag raw_synced", "raw", left, right, "image_raw");
    add("kitti2bag odom", "odom", left, right, "image_rect");
    add("kitti_to_rosbag (ETH)", "eth", gray ? "/cam00" : "/cam02", gray ? "/cam01" : "/cam03",
        "image_raw");
  }
  return layouts;
}

}  // namespace

std::vector<CameraLayout> findCameras(const TopicTypes& types) {
  std::vector<CameraLayout> found;
  for (const CameraLayout& layout : kittiLayouts()) addIfThere(types, layout, found);

  const std::set<std::string> lefts = imageTopics(types);
  for (const auto& [left_folder, right_folder, image] : kNames)
    for (const std::string& left : lefts) {
      if (nameOf(left) != image || !boost::algorithm::ends_with(folderOf(left), left_folder))
        continue;
      const std::string camera = folderOf(folderOf(left)), ns = camera.empty() ? "/" : camera;
      const StereoTopics topics = topicsOf(camera + left_folder, camera + right_folder, image);
      CameraLayout layout{"stereo camera " + ns, topics, kRobot, {"camera:=" + ns}};
      if (nameOf(left) == "image_raw") {
        layout.name += ", raw";
        layout.arguments.push_back("rectify:=true");
      } else if (nameOf(left) == "image_rect_color") {
        layout = remapped(layout.name + ", colour", ns, topics);
      } else if (nameOf(left) == "image_rect_raw") {
        layout = remapped("infrared pair of " + camera, camera, topics);
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
              topicsOf(camera + "/left", camera + "/right", "image_rect"),
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
