/// Runs the nodelets' processors on a bag, without roscore and player; no frame is dropped.
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <filesystem>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "nodelets/rectifier.h"
#include "nodelets/transforms.h"
#include "params/yaml_params.h"
#include "tools/bag_file.h"
#include "tools/command_line.h"
#include "tools/output_file.h"
#include "tools/pipeline_processor.h"
#include "tools/progress.h"
#include "tools/stage_table.h"
#include "tools/stereo_bag.h"

namespace predictive_stereo {
namespace {

std::set<std::string> chosenOutputs(const CommandLine& line) {
  std::set<std::string> known, chosen;
  visitOutputs([&](const std::string& topic, const auto&) { known.insert(topic); });
  std::istringstream list(line.get("topics"));
  for (std::string topic; std::getline(list, topic, ','); chosen.insert(topic))
    if (!known.count(topic))
      throw UsageError("--topics: there is no output '" + topic + "'; choose from " +
                       boost::algorithm::join(known, " "));
  return chosen.empty() ? known : chosen;
}

double seconds(const CommandLine& line, const std::string& name, double otherwise) {
  const double value = line.getDouble(name, otherwise);
  if (!(value >= 0))
    throw UsageError("--" + name + " = " + line.get(name) + ": must not be negative");
  return value;
}

class Replay {
 public:
  explicit Replay(const CommandLine& line)
      : line_(line), choice_(topicChoice(line)), outputs_(chosenOutputs(line)) {
    const double start_s = seconds(line, "start", 0),
                 duration_s = seconds(line, "duration", ros::TIME_MAX.toSec());
    setFromOptions(line, params_);
    openBag(line.get("bag"), in_);
    topics_ = findStereoTopics(in_, choice_);
    begin_ = timeAfter(rosbag::View(in_).getBeginTime(), start_s);
    end_ = timeAfter(begin_, duration_s);
  }

  void run() {
    readTf();
    chooseBase();
    fillTf();
    if (std::any_of(recorded_.begin(), recorded_.end(),
                    [&](const Recorded& recorded) { return isOurs(recorded.transform); }))
      std::cerr << "note: the bag's own transforms to '" << params_.ego_motion.base_frame
                << "' are replaced by those of the estimated ego-motion (--set "
                   "ego_motion/publish_tf=false keeps them)\n";
    BagFile out(line_.get("output"), line_.has("compress"));
    for (const rosbag::MessageInstance& message :
         rosbag::View(in_, rosbag::TopicQuery("/tf_static"), ros::TIME_MIN, begin_))
      if (message.getTime() < begin_) copyTf(message, begin_, out);
    std::vector<std::string> topics = topics_.all();
    topics.insert(topics.end(), {"/tf", "/tf_static"});
    rosbag::View view(in_, rosbag::TopicQuery(topics), begin_, end_);
    rosbag::View lefts(in_, rosbag::TopicQuery(topics_.left), begin_, end_);
    Progress progress("replay", static_cast<int>(lefts.size()));
    BagPairs pairs(topics_, params_.disparity.sync, refused_);
    for (const rosbag::MessageInstance& message : view) {
      throwIfInterrupted();
      const std::string& topic = message.getTopic();
      if (topic == "/tf" || topic == "/tf_static") {
        copyTf(message, message.getTime(), out);
        continue;
      }
      for (const BagPair& found : pairs.add(message))
        processPair(found.pair, message.getTime(), out);
      if (topic == topics_.left) progress.update(lefts_++);
    }
    if (pairs_ == 0)
      throw std::runtime_error(refused_.first().empty() ? describeMissingPairs(lefts.size(), pairs)
                                                        : refused_.first());
    out.finish();
    if (const std::string path = line_.get("csv"); !path.empty())
      writeText(path, csv(pairs.unmatched()));
    report(pairs);
  }

 private:
  struct Recorded {
    geometry_msgs::TransformStamped transform;
    bool is_static;
  };

  // All transforms: they are known before the first frame, so that no frame has to wait.
  void readTf() {
    for (const rosbag::MessageInstance& message :
         rosbag::View(in_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "/tf_static"}))) {
      const auto tf = message.instantiate<tf2_msgs::TFMessage>();
      if (!tf) continue;
      const bool is_static = message.getTopic() == "/tf_static";
      for (const geometry_msgs::TransformStamped& transform : tf->transforms)
        if (!refused_.has(message.getTopic(), transform, is_static))
          recorded_.push_back({transform, is_static});
    }
  }

  // Without a path from the chosen frame to the camera, the base is what the camera is fixed to.
  void chooseBase() {
    const std::string camera = cameraFrame();
    std::string& base = params_.ego_motion.base_frame;
    if (base.empty()) base = camera;
    tf2::BufferCore tf(kWholeRecording);
    FixedFrames fixed;
    for (const auto& [transform, is_static] : recorded_) {
      tf.setTransform(transform, "bag", is_static);
      if (is_static) fixed.add(transform.child_frame_id, transform.header.frame_id);
    }
    if (base == camera || camera.empty() ||
        tf.canTransform(withoutSlash(base), withoutSlash(camera), ros::Time(0)))
      return;
    std::cerr << "note: the bag's tf has no path from '" << base << "' to the left camera '"
              << camera << "': ";
    const std::string root = fixed.rootOf(camera);
    base = root == withoutSlash(camera) ? camera : root;
    std::cerr << (base == camera ? "the camera" : "'" + base + "', to which it is fixed,")
              << " is the base frame, whose odometry is written";
    if (base == withoutSlash(params_.ego_motion.odom_frame)) {
      std::cerr << ", in the frame '" << kOtherOdomFrame << "'";
      params_.ego_motion.odom_frame = kOtherOdomFrame;
      // Otherwise they follow the bag's own tf.
      if (params_.ego_motion.publish_tf)
        params_.disparity.odom_frame = params_.moving_objects.odom_frame = kOtherOdomFrame;
    }
    std::cerr << "\n";
  }

  // Of the first left image; empty: there is none.
  std::string cameraFrame() {
    for (const rosbag::MessageInstance& message :
         rosbag::View(in_, rosbag::TopicQuery(topics_.left), begin_, end_)) {
      if (const auto image = message.instantiate<sensor_msgs::Image>())
        return image->header.frame_id;
      if (const auto compressed = message.instantiate<sensor_msgs::CompressedImage>())
        return compressed->header.frame_id;
    }
    return "";
  }

  void fillTf() {
    tf_.clear();
    for (const auto& [transform, is_static] : recorded_)
      if (!isOurs(transform)) tf_.setTransform(transform, "bag", is_static);
  }

  bool isOurs(const geometry_msgs::TransformStamped& transform) const {
    return params_.ego_motion.publish_tf &&
           withoutSlash(transform.child_frame_id) == withoutSlash(params_.ego_motion.base_frame);
  }

  void processPair(StereoPair pair, ros::Time time, BagFile& out) {
    const auto rectify = [&] {
      pair.left = left_rectifier_.rectify(*pair.left, *pair.left_info);
      pair.right = right_rectifier_.rectify(*pair.right, *pair.right_info);
    };
    if (choice_.raw && refused_.refuses("pairs", rectify)) return;
    if (!processor_) {
      processor_.emplace(params_, tf_);
      if (const std::string slow = processor_->slowTargetWarning(); !slow.empty())
        std::cerr << "warning: " << slow << "\n";
    }
    // tf keeps the pose of an earlier pass, e.g. before a simulator's reset, if it has this stamp.
    const ros::Time stamp = pair.left->header.stamp;
    if (last_.toSec() - stamp.toSec() > SequenceGuard::kLargestDelay_s) fillTf();
    std::optional<PipelineProcessor::Output> frame;
    if (refused_.refuses("pairs", [&] { frame = processor_->process(pair); })) return;
    if (!frame) {
      ++ignored_;
      return;
    }
    last_ = stamp;
    count(*frame);
    if (!frame->event.empty()) std::cerr << "\npair " << pairs_ << ": " << frame->event << "\n";
    write(*frame, time, out);
  }

  void write(const PipelineProcessor::Output& frame, ros::Time time, BagFile& out) const {
    if (params_.ego_motion.publish_tf) {
      tf2_msgs::TFMessage tf;
      tf.transforms = {frame.ego_motion.transform};
      out.write("/tf", time, tf);
    }
    const std::string ns = cameraNamespace(choice_.camera);
    visitOutputs([&](const std::string& topic, const auto& make) {
      if (outputs_.count(topic)) out.write(ns + "/" + topic, time, *make(frame));
    });
  }

  // Copies the bag's transforms, so that OUT is complete without the input bag.
  void copyTf(const rosbag::MessageInstance& message, ros::Time time, BagFile& out) const {
    const auto tf = message.instantiate<tf2_msgs::TFMessage>();
    if (!tf) return;
    auto& transforms = tf->transforms;
    transforms.erase(std::remove_if(transforms.begin(), transforms.end(),
                                    [&](const auto& transform) { return isOurs(transform); }),
                     transforms.end());
    if (!transforms.empty())
      out.write(message.getTopic(), time, *tf, message.getConnectionHeader());
  }

  void count(const PipelineProcessor::Output& frame) {
    ++pairs_;
    lost_ += frame.ego_motion.pose_state != PoseState::kKnown;
    unpredicted_ += !frame.disparity.predicted;
    objects_ += frame.moving_objects.objects->objects.size();
    const stereo_msgs::DisparityImage& disparity = *frame.disparity.disparity;
    const cv::Mat1f map = floatView(disparity.image, "disparity");
    density_ += cv::countNonZero(map >= disparity.min_disparity) / double(map.total());
    table_.add(frame.times);
  }

  // Quality figures that need no ground truth.
  std::string csv(size_t unmatched) const {
    const double frames = static_cast<double>(pairs_);
    std::ostringstream text;
    text << "recording,pairs,unmatched,duplicates,lost_percent,unpredicted_percent,"
            "density_percent,objects_per_frame,median_ms,p95_ms\n"
         << csvCell(std::filesystem::path(line_.get("bag")).stem().string()) << ',' << pairs_ << ','
         << unmatched << ',' << ignored_ << ',' << 100 * lost_ / frames << ','
         << 100 * unpredicted_ / frames << ',' << 100 * density_ / frames << ','
         << objects_ / frames << ',' << table_.quantileOf("whole frame", 0.5) << ','
         << table_.quantileOf("whole frame", 0.95) << '\n';
    return text.str();
  }

  std::string describeMissingPairs(size_t lefts, const BagPairs& pairs) const {
    if (lefts == 0)
      return line_.get("bag") + ": has no left image between --start and --start plus --duration";
    const std::string mismatch = pairs.describeMismatch();
    return line_.get("bag") + ": has " + std::to_string(lefts) +
           " left images but not one stereo pair; run check_bag" +
           (mismatch.empty() ? "" : ": " + mismatch);
  }

  void report(const BagPairs& pairs) const {
    std::cout << pairs_ << " pairs";
    if (pairs.unmatched()) std::cout << ", " << pairs.unmatched() << " left images unmatched";
    if (ignored_) std::cout << ", " << ignored_ << " duplicate or late pairs ignored";
    for (const auto& [topic, count] : refused_.counts())
      std::cout << ", " << count << " of " << topic << " refused";
    std::cout << "; " << cv::getNumThreads() << " threads\n";
    table_.print(std::cout);
  }

  const CommandLine& line_;
  const StereoTopicChoice choice_;
  const std::set<std::string> outputs_;
  AllNodeletParams params_;
  rosbag::Bag in_;
  StereoTopics topics_;
  ros::Time begin_, end_;
  static inline const ros::Duration kWholeRecording{24 * 3600.0};
  std::vector<Recorded> recorded_;
  tf2::BufferCore tf_{kWholeRecording};
  ros::Time last_;  // stamp of the last frame
  Rectifier left_rectifier_, right_rectifier_;
  std::optional<PipelineProcessor> processor_;
  StageTable table_;
  int lefts_ = 0;
  size_t ignored_ = 0, pairs_ = 0, lost_ = 0, unpredicted_ = 0, objects_ = 0;
  double density_ = 0;
  RefusedMessages refused_{
      [](const std::string& text) { std::cerr << "\nwarning: " << text << "\n"; }};
};

}  // namespace

int runProgram(const CommandLine& line) {
  if (line.has("parameters")) {
    AllNodeletParams params;
    std::cout << toYaml(ParamTable(params));
    return 0;
  }
  for (const char* option : {"bag", "output"})
    if (line.get(option).empty()) throw UsageError("--" + std::string(option) + " is missing");
  if (!line.positional().empty()) throw UsageError("unexpected argument " + line.positional()[0]);
  catchInterruptions();
  Replay(line).run();
  return 0;
}

}  // namespace predictive_stereo
