#include "tools/bag_check.h"

#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <stdexcept>

#include "nodelets/rectifier.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/transforms.h"
#include "tools/pipeline_processor.h"
#include "tools/tf_check.h"

namespace predictive_stereo {
namespace {

using Level = BagFinding::Level;

class Checker {
 public:
  Checker(const rosbag::Bag& bag, const StereoTopicChoice& choice) : bag_(bag), choice_(choice) {}

  BagCheck run() {
    types_ = topicTypes(bag_);
    if (types_.empty()) {
      result_.fault("the bag is empty: record the images and camera_info topics");
      return result_;
    }
    if (!chooseCamera()) return result_;
    result_.launch_file = camera_.launch_file;
    result_.arguments = camera_.arguments;
    try {
      readMessages();
    } catch (const std::invalid_argument& error) {  // an image that cannot be decoded
      result_.fault(error.what());
      return result_;
    }
    if (checkMessages() && checkCalibration()) {
      checkStamps(streams_, result_);
      checkFrames();
      checkOutputs();
    }
    return result_;
  }

 private:
  bool chooseCamera() {
    const bool chosen = !choice_.camera.empty() || !choice_.left.empty();
    const std::vector<CameraLayout> cameras = findCameras(types_);
    if (chosen) {
      camera_ = chosenCamera(choice_, types_);
      // The user gave its namespace, but the names of its image topics are others.
      for (const CameraLayout& known : cameras)
        if (!choice_.camera.empty() && !types_.count(camera_.topics.left) &&
            !known.arguments.empty() && known.arguments[0] == camera_.arguments[0])
          camera_ = known;
      return true;
    }
    if (!cameras.empty()) {
      camera_ = cameras[0];
      result_.good("layout: " + camera_.name);
      for (size_t i = 1; i < cameras.size(); ++i)
        result_.advice("the bag also has: " + cameras[i].name + " (--left " +
                       cameras[i].topics.left + " --right " + cameras[i].topics.right + ")");
      return true;
    }
    std::string images = topicsOfType(types_, "sensor_msgs/Image");
    const std::string packed = topicsOfType(types_, "sensor_msgs/CompressedImage");
    if (!packed.empty()) images += (images.empty() ? "" : ", ") + packed;
    if (!images.empty() && topicsOfType(types_, "sensor_msgs/CameraInfo").empty())
      result_.fault(
          "the bag has images (" + images +
          ") but no sensor_msgs/CameraInfo, the calibration: record the camera_info topics too");
    else if (!images.empty())
      result_.fault(
          "the bag has no stereo camera of a known layout; choose with --left and --right from the "
          "image topics " +
          images + "; each needs a camera_info topic beside it");
    else
      result_.fault(
          "no topic has type sensor_msgs/Image or sensor_msgs/CompressedImage: record the images");
    return false;
  }

  void addStamp(ros::Time stamp, ros::Time recorded, StampStream& stream) {
    if (refused_.has(stream.topic, stamp, ZeroStamp::kLegal)) return;
    stream.stamps.push_back(stamp);
    if (&stream == &streams_[0])
      image_delay_s_ = std::min(image_delay_s_, secondsBetween(stamp, recorded));
  }

  void readMessages() {
    const StereoTopics& topics = camera_.topics;
    for (const std::string& topic :
         {topics.left, topics.right, topics.left_info, topics.right_info})
      streams_.push_back({topic, {}});
    rosbag::View all(bag_);
    const ros::Time end = timeAfter(all.getBeginTime(), kLookedAt_s);
    rosbag::View view(bag_, rosbag::TopicQuery(topics.all()), all.getBeginTime(), end);
    for (const rosbag::MessageInstance& message : view) {
      const bool left_image = message.getTopic() == topics.left;
      auto& first_image = left_image ? pair_.left : pair_.right;
      StampStream& images = streams_[left_image ? 0 : 1];
      if (const auto image = message.instantiate<sensor_msgs::Image>()) {
        addStamp(image->header.stamp, message.getTime(), images);
        if (!first_image) first_image = image;
      } else if (const auto packed = message.instantiate<sensor_msgs::CompressedImage>()) {
        addStamp(packed->header.stamp, message.getTime(), images);
        if (!first_image) first_image = decodedImage(*packed);
      } else if (const auto info = message.instantiate<sensor_msgs::CameraInfo>()) {
        const bool left = message.getTopic() == topics.left_info;
        addStamp(info->header.stamp, message.getTime(), streams_[left ? 2 : 3]);
        auto& first = left ? pair_.left_info : pair_.right_info;
        if (!first) first = info;
      }
    }
    rosbag::View transforms(
        bag_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "/tf_static", "tf", "tf_static"}),
        all.getBeginTime(), end);
    for (const rosbag::MessageInstance& message : transforms)
      if (const auto tf = message.instantiate<tf2_msgs::TFMessage>())
        for (const auto& transform : tf->transforms) {
          const bool is_static = message.getTopic().find("static") != std::string::npos;
          if (refused_.has(message.getTopic(), transform, is_static)) continue;
          tf_.add(transform, is_static, message.getTime());
        }
  }

  // The cure for a missing topic.
  std::string cureForMissing(size_t stream, const char* type) const {
    const std::string& topic = streams_[stream].topic;
    const std::string others = topicsOfType(types_, type);
    const std::string text = "no messages on " + topic + "; topics of type " + type + ": " +
                             (others.empty() ? "none" : others) + ". ";
    if (others.empty())
      return text + "Record " + (stream < 2 ? "the images" : "the calibration") + " too";
    if (stream < 2)
      return text +
             "Choose with --camera, or --left and --right; or rename with rosbag play's old:=new";
    return text + "Give the image's camera_info to the launch file, as " +
           (stream == 2 ? "left_info:=" : "right_info:=") +
           "<topic>; or rename it with rosbag play's old:=new";
  }

  bool checkMessages() {
    bool all = true;
    const char* images = imageTopic(camera_.topics.left) == camera_.topics.left
                             ? "sensor_msgs/Image"
                             : "sensor_msgs/CompressedImage";
    const char* kinds[] = {images, images, "sensor_msgs/CameraInfo", "sensor_msgs/CameraInfo"};
    for (size_t i = 0; i < streams_.size(); ++i) {
      const std::string& topic = streams_[i].topic;
      const auto type = types_.find(topic);
      if (type == types_.end()) {
        result_.fault(cureForMissing(i, kinds[i]));
      } else if (type->second != kinds[i]) {
        result_.fault(topic + " has type " + type->second + ", not " + kinds[i]);
      } else if (streams_[i].stamps.empty()) {
        result_.fault("no messages on " + topic + " in the first " +
                      cv::format("%g s", kLookedAt_s));
      } else {
        continue;
      }
      all = false;
    }
    return all;
  }

  bool checkCalibration() {
    try {
      greyImage(*pair_.right, "right");
      checkBrightness(greyImage(*pair_.left, "left"));
      if (camera_.is_raw) {
        Rectifier().rectify(*pair_.left, *pair_.left_info);
        Rectifier().rectify(*pair_.right, *pair_.right_info);
      }
      result_.good(cv::format("images: %ux%u %s", pair_.left->width, pair_.left->height,
                              pair_.left->encoding.c_str()));
      const StereoRig rig = stereoRig(pair_);
      result_.good(
          cv::format("calibration: focal length %.1f px, baseline %.4f m; what is nearer than %.2f "
                     "m gets false "
                     "depths, unless disparity/matcher/range/count is larger than by default",
                     rig.fx_px, rig.baseline_m,
                     rig.fx_px * rig.baseline_m / DisparityRange().max_disparity()));
      if (rig.baseline_m < 0.01 || rig.baseline_m > 5)
        result_.advice(cv::format("a baseline of %g m is unusual: are the P matrices in metres?",
                                  rig.baseline_m));
      return true;
    } catch (const std::invalid_argument& error) {
      result_.fault(error.what());
      return false;
    }
  }

  void checkBrightness(const cv::Mat1b& left) {
    constexpr double kDark = 32;
    double brightest = 0;
    cv::minMaxLoc(left, nullptr, &brightest);
    if (brightest >= kDark) return;
    result_.advice(
        cv::format("the first left image is dark: no pixel is brighter than %.0f of 255",
                   brightest) +
        (pair_.left->encoding.find("16") == std::string::npos
             ? ""
             : ". The upper 8 of 16 bits are used: if the camera has fewer than 16 bits, set its "
               "driver to mono8"));
  }

  void checkFrames() {
    const std_msgs::Header& left = pair_.left->header;
    if (withoutSlash(left.frame_id).empty())
      result_.fault(camera_.topics.left + " has an empty frame_id: set it in the camera driver");
    else if (camera_.knows_tf)
      result_.good("tf: " + camera_.launch_file + " has the transforms of this layout");
    else
      tf_.check(left, image_delay_s_, topicsOfType(types_, "nav_msgs/Odometry"), result_);
  }

  // Topics on which the nodelets publish, too. The odometry may be that of another node.
  void checkOutputs() {
    using boost::algorithm::starts_with;
    const std::string prefix = "camera:=";
    std::string camera = "/kitti";
    bool estimates_odometry = true;
    for (const std::string& argument : result_.arguments) {
      if (starts_with(argument, prefix)) camera = cameraNamespace(argument.substr(prefix.size()));
      if (argument == "ego_motion:=false") estimates_odometry = false;
    }
    std::vector<std::string> outputs;
    visitOutputs([&](const std::string& name, const auto&) {
      const std::string topic = camera + "/" + name;
      if (types_.count(topic) && (estimates_odometry || !starts_with(name, "odometry")))
        outputs.push_back(topic);
    });
    if (outputs.empty()) return;
    std::string inputs;
    for (const std::string& topic : camera_.topics.all()) inputs += "'" + topic + "', ";
    if (!estimates_odometry) {
      std::string odometries;
      for (const auto& [topic, type] : types_)
        if (type == "nav_msgs/Odometry") odometries += "'" + topic + "', ";
      inputs += odometries.empty() ? "'" + camera + "/odometry', " : odometries;
    }
    result_.advice(
        cv::format("the bag has %zu outputs of the nodelets, e.g. %s: they mix with the new ones. "
                   "Make a bag of the inputs by rosbag filter IN.bag OUT.bag ",
                   outputs.size(), outputs.front().c_str()) +
        "\"topic in (" + inputs + "'/tf', '/tf_static')\"");
  }

  const rosbag::Bag& bag_;
  const StereoTopicChoice choice_;
  BagCheck result_;
  TopicTypes types_;
  CameraLayout camera_;
  StereoPair pair_;                   // first message of each topic
  std::vector<StampStream> streams_;  // left, right, left_info, right_info
  RefusedMessages refused_{[this](const std::string& text) { result_.advice(text); }};
  TfCheck tf_;
  double image_delay_s_ = kNoDelay_s;  // the least one of a left image until it was recorded
};

}  // namespace

bool BagCheck::isUsable() const {
  return !launch_file.empty() &&
         std::none_of(findings.begin(), findings.end(),
                      [](const BagFinding& f) { return f.level == Level::kFault; });
}

BagCheck checkBag(const rosbag::Bag& bag, const StereoTopicChoice& choice) {
  return Checker(bag, choice).run();
}

}  // namespace predictive_stereo
