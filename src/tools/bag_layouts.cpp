#include "tools/bag_layouts.h"

#include <boost/algorithm/string/predicate.hpp>
#include <set>
#include <utility>

namespace predictive_stereo {
namespace {

constexpr char kRobot[] = "predictive_stereo.launch", kKitti[] = "kitti.launch";

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
    const std::string left = "/kitti/camera_" + cameras + "_left",
                      right = "/kitti/camera_" + cameras + "_right";
    layouts.push_back({"kitti2bag raw_synced, " + cameras,
                       topicsOf(left, right, "image_raw"),
                       kKitti,
                       {"profile:=raw", "cameras:=" + cameras},
                       true});
    layouts.push_back({"kitti2bag odom, " + cameras,
                       topicsOf(left, right, "image_rect"),
                       kKitti,
                       {"profile:=odom", "cameras:=" + cameras},
                       true});
    const bool gray = cameras == "gray";
    layouts.push_back(
        {"kitti_to_rosbag (ETH), " + cameras,
         topicsOf(gray ? "/cam00" : "/cam02", gray ? "/cam01" : "/cam03", "image_raw"),
         kKitti,
         {"profile:=eth", "cameras:=" + cameras},
         true});
  }
  return layouts;
}

}  // namespace

std::vector<CameraLayout> findCameras(const TopicTypes& types) {
  std::vector<CameraLayout> found;
  for (const CameraLayout& layout : kittiLayouts()) addIfThere(types, layout, found);

  const std::set<std::string> lefts = imageTopics(types);
  for (const std::string image : {"image_rect", "image_rect_color", "image_raw"})
    for (const std::string& left : lefts) {
      if (nameOf(left) != image || !boost::algorithm::ends_with(folderOf(left), "/left")) continue;
      const std::string camera = folderOf(folderOf(left));
      const StereoTopics topics = topicsOf(camera + "/left", camera + "/right", image);
      const std::string ns = camera.empty() ? "/" : camera;
      if (image == "image_rect")
        addIfThere(types, {"stereo camera " + ns, topics, kRobot, {"camera:=" + ns}}, found);
      else if (image == "image_raw")
        addIfThere(
            types,
            {"stereo camera " + ns + ", raw", topics, kRobot, {"camera:=" + ns, "rectify:=true"}},
            found);
      else
        addIfThere(types, remapped("stereo camera " + ns + ", colour", ns, topics), found);
    }

  // RealSense: the infrared pair is rectified, although its name does not say so.
  for (const std::string& left : lefts) {
    if (nameOf(left) != "image_rect_raw" || !boost::algorithm::ends_with(folderOf(left), "/infra1"))
      continue;
    const std::string camera = folderOf(folderOf(left));
    const StereoTopics topics = topicsOf(camera + "/infra1", camera + "/infra2", "image_rect_raw");
    addIfThere(types, remapped("infrared pair of " + camera, camera, topics), found);
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
