/// Runs the nodelets' processors on a bag, without roscore and player; no frame is dropped.
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <iostream>
#include <opencv2/core/utility.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "nodelets/pipeline_processor.h"
#include "nodelets/rectifier.h"
#include "params/yaml_params.h"
#include "tools/bag_file.h"
#include "tools/command_line.h"
#include "tools/output_file.h"
#include "tools/progress.h"
#include "tools/replay_output.h"
#include "tools/stereo_bag.h"

namespace predictive_stereo {
namespace {

constexpr char kHelp[] = R"(replay --bag IN --output OUT [options]

Estimates ego-motion, disparity and moving objects for every stereo pair of the bag IN, in order and
without dropping one. Writes the topics that the nodelets publish to the bag OUT. The results do not
depend on the number of threads.

  --bag IN              bag with a rectified stereo pair
  --output OUT          bag to write; it exists only when it is complete
  --camera NS           topics NS/{left,right}/{image_rect,camera_info}; outputs go to NS too
  --left T --right T    image topics, with camera_info topics beside them; outputs go to /
                        (without these options: the only camera with a known layout, outputs in /)
  --rectify             rectifies the images (NS/{left,right}/image_raw) first, by their camera_info
  --config YAML         parameters: sections ego_motion, disparity, moving_objects
  --set NAME=VALUE      one parameter, e.g. disparity/matcher/p1=12; may be repeated
  --start S             begin S seconds after the beginning of the bag
  --duration S          end S seconds later
  --topics A,B,...      write these outputs only, e.g. disparity,odometry (default: all of them,
                        about 30 MB a pair of 1242x375)
  --compress            compress OUT (lz4)
  --csv FILE            writes the figures that need no ground truth: number of pairs, share of
                        pairs that were lost or without prediction, density, objects, ms per frame
  --threads N           threads to use (default: all cores)
  --parameters          print all parameters with their values and limits as yaml, and exit
  --help

The transform from base_frame to the left camera is taken from the bag's tf. If the bag does not
have it, the camera itself becomes the base, and a note says so.
)";

struct Options {
  explicit Options(const CommandLine& line)
      : bag(line.get("bag")),
        output(line.get("output")),
        csv(line.get("csv")),
        topics(topicChoice(line)),
        compress(line.has("compress")) {
    if (bag.empty()) throw UsageError("--bag is missing");
    if (output.empty()) throw UsageError("--output is missing");
    if (!line.positional().empty()) throw UsageError("unexpected argument " + line.positional()[0]);
    topics.raw = line.has("rectify");
    std::istringstream list(line.get("topics"));
    for (std::string topic; std::getline(list, topic, ',');) outputs.insert(topic);
    requireKnownOutputs();
    if (line.has("start")) start_s = seconds(line, "start");
    if (line.has("duration")) duration_s = seconds(line, "duration");
  }

  std::string bag, output, csv;
  StereoTopicChoice topics;
  std::set<std::string> outputs;
  double start_s = 0;
  std::optional<double> duration_s;
  bool compress;

 private:
  void requireKnownOutputs() const {
    std::set<std::string> known;
    visitOutputs([&](const std::string& topic, const auto&) { known.insert(topic); });
    for (const std::string& topic : outputs)
      if (!known.count(topic))
        throw UsageError("--topics: there is no output '" + topic + "'; choose from " +
                         boost::algorithm::join(known, " "));
  }

  static double seconds(const CommandLine& line, const std::string& name) {
    double value = 0;
    parseParam("--" + name, line.get(name), value);
    if (!(value >= 0))
      throw UsageError("--" + name + " = " + line.get(name) + ": must not be negative");
    return value;
  }
};

class Replay {
 public:
  Replay(const Options& options, const AllNodeletParams& params)
      : options_(options), params_(params) {
    openBag(options.bag, in_);
    topics_ = findStereoTopics(in_, options.topics);
    rosbag::View everything(in_);
    begin_ = timeAfter(everything.getBeginTime(), options.start_s);
    end_ = options.duration_s ? timeAfter(begin_, *options.duration_s) : ros::TIME_MAX;
  }

  void run() {
    readTf();
    BagFile out(options_.output, options_.compress);
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
    if (figures_.pairs() == 0)
      throw std::runtime_error(refused_.first().empty() ? describeMissingPairs(lefts.size(), pairs)
                                                        : refused_.first());
    out.finish();
    if (!options_.csv.empty())
      writeText(options_.csv, figures_.csv(options_.bag, pairs.unmatched(), ignored_, table_));
    report(pairs);
  }

 private:
  // Reads all transforms before the first frame, so that no frame has to wait.
  void readTf() {
    for (const rosbag::MessageInstance& message :
         rosbag::View(in_, rosbag::TopicQuery(std::vector<std::string>{"/tf", "/tf_static"}))) {
      const auto tf = message.instantiate<tf2_msgs::TFMessage>();
      if (!tf) continue;
      const bool is_static = message.getTopic() == "/tf_static";
      for (const geometry_msgs::TransformStamped& transform : tf->transforms)
        if (!refused_.has(message.getTopic(), transform, is_static))
          transforms_.emplace_back(transform, is_static);
    }
  }

  bool isOurs(const geometry_msgs::TransformStamped& transform) const {
    return params_.ego_motion.publish_tf &&
           transform.child_frame_id == params_.ego_motion.base_frame;
  }

  // Needs the first pair, which has the camera's frame.
  void startPipeline(const StereoPair& pair) {
    const std::string& camera = pair.left->header.frame_id;
    std::string& base = params_.ego_motion.base_frame;
    tf2::BufferCore extrinsics(ros::Duration(24 * 3600.0));
    for (const auto& [transform, is_static] : transforms_)
      if (!isOurs(transform)) extrinsics.setTransform(transform, "bag", is_static);
    if (!base.empty() && base != camera &&
        !extrinsics.canTransform(base, camera, pair.left->header.stamp)) {
      std::cerr << "note: the bag's tf has no path from '" << base << "' to the left camera '"
                << camera << "': the camera is the base frame, and odometry is that of '" << camera
                << "'\n";
      base.clear();
    }
    processor_.emplace(params_);
    if (const std::string slow = processor_->slowTargetWarning(); !slow.empty())
      std::cerr << "warning: " << slow << "\n";
    bool replaced = false;
    for (const auto& [transform, is_static] : transforms_) {
      if (isOurs(transform))
        replaced = true;
      else
        processor_->tf().setTransform(transform, "bag", is_static);
    }
    if (replaced)
      std::cerr << "note: the bag's own transforms to '" << base
                << "' are replaced by those of the estimated ego-motion (--set "
                   "ego_motion/publish_tf=false keeps them)\n";
  }

  void processPair(StereoPair pair, ros::Time time, BagFile& out) {
    const auto rectify = [&] {
      pair.left = left_rectifier_.rectify(*pair.left, *pair.left_info);
      pair.right = right_rectifier_.rectify(*pair.right, *pair.right_info);
    };
    if (options_.topics.raw && refused_.refuses("pairs", rectify)) return;
    if (!processor_) startPipeline(pair);
    std::optional<PipelineProcessor::Output> frame;
    if (refused_.refuses("pairs", [&] { frame = processor_->process(pair); })) return;
    if (!frame) {
      ++ignored_;
      return;
    }
    figures_.add(*frame);
    if (!frame->event.empty())
      std::cerr << "\npair " << figures_.pairs() << ": " << frame->event << "\n";
    write({*frame, params_.disparity.points}, time, out);
    table_.add(frame->times);
  }

  void write(const ReplayedFrame& frame, ros::Time time, BagFile& out) const {
    if (params_.ego_motion.publish_tf) {
      tf2_msgs::TFMessage tf;
      tf.transforms = {frame.out.ego_motion.transform};
      out.write("/tf", time, tf);
    }
    const std::string ns = cameraNamespace(options_.topics.camera);
    visitOutputs([&](const std::string& topic, const auto& make) {
      if (options_.outputs.empty() || options_.outputs.count(topic))
        out.write(ns + "/" + topic, time, *make(frame));
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

  std::string describeMissingPairs(size_t lefts, const BagPairs& pairs) const {
    if (lefts == 0)
      return options_.bag + ": has no left image between --start and --start plus --duration";
    const std::string mismatch = pairs.describeMismatch();
    return options_.bag + ": has " + std::to_string(lefts) +
           " left images but not one stereo pair; run check_bag" +
           (mismatch.empty() ? "" : ": " + mismatch);
  }

  void report(const BagPairs& pairs) const {
    std::cout << figures_.pairs() << " pairs";
    if (pairs.unmatched()) std::cout << ", " << pairs.unmatched() << " left images unmatched";
    if (ignored_) std::cout << ", " << ignored_ << " duplicate or late pairs ignored";
    for (const auto& [topic, count] : refused_.counts())
      std::cout << ", " << count << " of " << topic << " refused";
    std::cout << "; " << cv::getNumThreads() << " threads\n";
    table_.print(std::cout);
  }

  Options options_;
  AllNodeletParams params_;
  rosbag::Bag in_;
  StereoTopics topics_;
  ros::Time begin_, end_;
  std::vector<std::pair<geometry_msgs::TransformStamped, bool>> transforms_;
  Rectifier left_rectifier_, right_rectifier_;
  std::optional<PipelineProcessor> processor_;
  StageTable table_;
  ReplayFigures figures_;
  int lefts_ = 0;
  size_t ignored_ = 0;
  RefusedMessages refused_{
      [](const std::string& text) { std::cerr << "\nwarning: " << text << "\n"; }};
};

int run(const CommandLine& line) {
  if (line.has("parameters")) {
    AllNodeletParams params;
    std::cout << toYaml(ParamTable(params));
    return 0;
  }
  const Options options(line);
  catchInterruptions();
  if (line.has("threads")) cv::setNumThreads(line.getInt("threads", 0, 1));
  AllNodeletParams params;
  setFromOptions(line, params);
  Replay(options, params).run();
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  using namespace predictive_stereo;
  return runTool(argc, argv, kHelp,
                 {"bag", "output", "camera", "left", "right", "config", "csv", "set", "start",
                  "duration", "topics", "threads"},
                 {"compress", "parameters", "rectify"}, run);
}
