/// Plays a bag into the nodelets of bag.test, in a manager or as nodes, and compares their outputs
/// with the ground truth, with `replay`, and with a second pass of the bag.
///
/// Parameters: ~source: street, or a drive; ~camera, ~config: those of the nodelets; ~processes:
/// number of processes of the nodelets; ~baseline/*: figures for comparison; or ~new_baseline: file
/// for new figures.
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <rosgraph_msgs/Log.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "bag_player.h"
#include "evaluation/detection_score.h"
#include "evaluation/disparity_metrics.h"
#include "evaluation/object_labels.h"
#include "evaluation/odometry_evaluation.h"
#include "evaluation/tools/bag_sequence.h"
#include "nodelets/stereo_messages.h"
#include "nodelets/transforms.h"
#include "recorder.h"
#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

std::string param(const std::string& name, const std::string& otherwise = "") {
  return ros::param::param<std::string>("~" + name, otherwise);
}

void runProgram(const std::string& command) {
  const std::string quiet = command + " > /dev/null 2>&1";
  if (std::system(quiet.c_str()) != 0) throw std::runtime_error(command + " failed");
}

/// Date and name of a drive of the excerpts; none: the synthetic street.
std::optional<std::pair<std::string, std::string>> drive(const std::string& source) {
  const std::map<std::string, std::pair<std::string, std::string>> drives = {
      {"kitti_0002", {"2011_09_26", "2011_09_26_drive_0002_sync"}},
      {"kitti_0009", {"2011_09_26", "2011_09_26_drive_0009_sync"}},
      {"kitti_0020", {"2011_09_30", "2011_09_30_drive_0020_sync"}},
  };
  const auto found = drives.find(source);
  if (found != drives.end()) return found->second;
  if (source != "street") throw std::runtime_error("unknown source " + source);
  return std::nullopt;
}

/// A bag with its ground truth.
struct Recording {
  std::string path;
  std::unique_ptr<Sequence> sequence;
  std::vector<cv::Mat1f> disparity_px;  ///< empty: no truth in this frame
  Poses T_world_cam;
};

Recording kitti(const std::string& path, const std::string& date, const std::string& name) {
  const std::string excerpts = std::getenv("KITTI_EXCERPTS");
  const std::string date_dir = excerpts + "/" + date;
  runProgram(std::string(KITTI_TO_BAG) + " " + date_dir + " " + name + " " + path);
  Recording recording;
  recording.path = path;
  recording.sequence = kittiDriveSequence(date_dir, name);
  recording.sequence->setLabels(readObjectLabels(excerpts + "/labels/" + name + ".csv"));
  for (int i = 0; i < recording.sequence->frames(); ++i)
    recording.disparity_px.push_back(recording.sequence->frame(i).truth_px);
  recording.T_world_cam = recording.sequence->poses().value();
  return recording;
}

Recording street(const std::string& path) {
  runProgram(std::string(STREET_TO_BAG) + " " + path +
             " --scene leader --frames 24 --size 828x250");
  Recording recording;
  recording.path = path;
  recording.sequence = bagSequence(path, {});
  rosbag::Bag bag(path);
  for (const auto& message : rosbag::View(bag)) {
    if (const auto truth = message.instantiate<stereo_msgs::DisparityImage>()) {
      cv::Mat1f disparity_px = floatView(truth->image, "truth/disparity").clone();
      disparity_px.setTo(kNoTruth, disparity_px == 0);  // the sky
      recording.disparity_px.push_back(disparity_px);
    }
    if (const auto truth = message.instantiate<nav_msgs::Odometry>()) {
      Eigen::Isometry3d T_odom_base;
      tf2::fromMsg(truth->pose.pose, T_odom_base);
      recording.T_world_cam.push_back(T_odom_base * Street(StreetParams()).cameraMount());
    }
  }
  return recording;
}

/// Outputs of the nodelets for a bag.
class Outputs {
 public:
  explicit Outputs(const ros::NodeHandle& camera)
      : disparity(camera, "disparity"),
        measured(camera, "measured_disparity"),
        predicted(camera, "predicted_disparity"),
        odometry(camera, "odometry"),
        objects(camera, "moving_objects") {}

  bool connected() const {
    return disparity.connected() && measured.connected() && predicted.connected() &&
           odometry.connected() && objects.connected();
  }
  bool hasAllOutputs(ros::Time stamp) const {
    return disparity.at(stamp) && measured.at(stamp) && predicted.at(stamp) && odometry.at(stamp) &&
           objects.at(stamp);
  }
  void clear() {
    disparity.clear();
    measured.clear();
    predicted.clear();
    odometry.clear();
    objects.clear();
  }

  DisparityRecorder disparity, measured, predicted;
  Recorder<nav_msgs::Odometry> odometry;
  Recorder<MovingObjectArray> objects;
};

/// A quality figure of the outputs.
struct Figure {
  const char* name;
  double value;
  double worst;  ///< worst accepted value if the baseline has `value`
};

bool larger(const Figure& figure) { return figure.worst < figure.value; }  // larger is better

double driftPercent(const Poses& estimated, const Poses& truth) {
  double length_m = 0;
  for (size_t i = 1; i < truth.size(); ++i)
    length_m += (truth[i].translation() - truth[i - 1].translation()).norm();
  const Eigen::Isometry3d error = (truth.front().inverse() * truth.back()).inverse() *
                                  (estimated.front().inverse() * estimated.back());
  return 100 * error.translation().norm() / length_m;
}

double turnErrorDeg(const Poses& estimated, const Poses& truth) {
  const Eigen::Isometry3d error = (truth.front().inverse() * truth.back()).inverse() *
                                  (estimated.front().inverse() * estimated.back());
  return Eigen::AngleAxisd(error.linear()).angle() * 180 / M_PI;
}

/// Removes the ids, which are not reused after time went back.
std::vector<MovingObject> withoutIds(const MovingObjectArray& array) {
  std::vector<MovingObject> objects = array.objects;
  for (MovingObject& object : objects) object.id = 0;
  return objects;
}

class Bag : public testing::Test {
 protected:
  static constexpr size_t kSecondPass = 8;  // pairs

  // The bag is played once, for all tests.
  static void SetUpTestSuite() {
    const auto kitti_drive = drive(param("source"));
    if (kitti_drive && !std::getenv("KITTI_EXCERPTS")) return;
    folder_ = std::make_unique<TemporaryDirectory>();
    const std::string path = folder_->path("in.bag");
    recording_ = std::make_unique<Recording>(
        kitti_drive ? kitti(path, kitti_drive->first, kitti_drive->second) : street(path));
    player_ = std::make_unique<BagPlayer>(path);
    const ros::NodeHandle camera(param("camera"));
    log_ = std::make_unique<Recorder<rosgraph_msgs::Log>>(camera, "/rosout");
    first_ = std::make_unique<Outputs>(camera);
    for (const char* name : {"ego_motion", "disparity", "moving_objects"})
      if (!ros::service::waitForService(camera.resolveName(name) + "/reset", 30000))
        throw std::runtime_error(std::string(name) + " does not come up");
    player_->publishStaticTransforms();
    const auto processes = static_cast<uint32_t>(ros::param::param("~processes", 1));
    if (!player_->waitForSubscribers(processes) || !eventually([] { return first_->connected(); }))
      throw std::runtime_error("the nodelets do not subscribe to the camera");
    ros::WallDuration(1.0).sleep();  // until all are connected in both directions
    player_->play(player_->stamps().size(), wait(*first_));
  }
  static void TearDownTestSuite() {
    second_.reset();
    first_.reset();
    log_.reset();
    player_.reset();
    recording_.reset();
    folder_.reset();
  }

  void SetUp() override {
    if (!recording_) GTEST_SKIP() << "KITTI_EXCERPTS is not set";
    for (const ros::Time stamp : player_->stamps())
      ASSERT_TRUE(first_->hasAllOutputs(stamp)) << "no outputs for " << stamp;
  }

  static std::function<void(ros::Time)> wait(const Outputs& outputs) {
    return [&](ros::Time stamp) { eventually([&] { return outputs.hasAllOutputs(stamp); }, 15); };
  }

  Poses cameraPoses() const {
    tf2::BufferCore extrinsics;
    const tf2_msgs::TFMessage tf = player_->staticTransforms();
    for (const auto& transform : tf.transforms) extrinsics.setTransform(transform, "bag", true);
    Poses poses;
    for (const ros::Time stamp : player_->stamps()) {
      const auto odometry = first_->odometry.at(stamp);
      Eigen::Isometry3d T_odom_base;
      tf2::fromMsg(odometry->pose.pose, T_odom_base);
      std::string error;
      const auto T_base_cam =
          lookUpTransform(extrinsics, odometry->child_frame_id,
                          first_->disparity.at(stamp)->header.frame_id, stamp, error);
      if (!T_base_cam) throw std::runtime_error(error);
      poses.push_back(T_odom_base * *T_base_cam);
    }
    return poses;
  }

  std::vector<Figure> figures() const {
    MeanDisparityScore disparity;
    for (size_t i = 1; i < player_->stamps().size(); ++i) {
      if (recording_->disparity_px[i].empty()) continue;
      const auto message = first_->disparity.at(player_->stamps()[i]);
      disparity.add(scoreDisparity(floatView(message->image, "disparity"), rangeOf(*message),
                                   recording_->disparity_px[i]));
    }
    size_t index = 0;
    const Detector live = [&](const StereoFrame&) {
      DetectorOutput output;
      for (const auto& object : first_->objects.at(player_->stamps().at(index++))->objects)
        output.objects.push_back(detectedObject(object));
      return output;
    };
    const DetectionScore detection = evaluateDetection(*recording_->sequence, live, 0, {}).score;
    const Poses poses = cameraPoses();
    std::vector<Figure> result;
    const auto add = [&](const char* name, double value, double factor, double slack) {
      if (!std::isnan(value)) result.push_back({name, value, factor * value + slack});
    };
    // The test is deterministic, so figures change only with the algorithms. Accepted changes: 2 %
    // of an error, a thousandth of the pixels, one detected object and one false positive of the
    // whole recording.
    constexpr double kRounding = 1e-4;  // of the figures in files
    if (disparity.frames) {
      add("d1_filled_percent", disparity.d1_filled_percent, 1.02, 0);
      add("density_percent", disparity.density_percent, 1.0, -0.1);
      add("rms_px", disparity.rms_px, 1.02, 0);
    }
    add("drift_percent", driftPercent(poses, recording_->T_world_cam), 1.02, 0.005);
    add("turn_error_deg", turnErrorDeg(poses, recording_->T_world_cam), 1.02, 0.002);
    add("found_percent", 100 * detection.all().recall(), 1.0,
        -100.0 / std::max(1, detection.all().demanded) - kRounding);
    add("false_boxes_per_frame", detection.falsePerFrame(), 1.0,
        1.0 / std::max(1, detection.frames()) + kRounding);
    return result;
  }

  static std::unique_ptr<TemporaryDirectory> folder_;
  static std::unique_ptr<Recording> recording_;
  static std::unique_ptr<BagPlayer> player_;
  static std::unique_ptr<Recorder<rosgraph_msgs::Log>> log_;
  static std::unique_ptr<Outputs> first_, second_;
};
std::unique_ptr<TemporaryDirectory> Bag::folder_;
std::unique_ptr<Recording> Bag::recording_;
std::unique_ptr<BagPlayer> Bag::player_;
std::unique_ptr<Recorder<rosgraph_msgs::Log>> Bag::log_;
std::unique_ptr<Outputs> Bag::first_, Bag::second_;

TEST_F(Bag, results_are_as_near_to_the_truth_as_they_were) {
  const std::vector<Figure> found = figures();
  ASSERT_GE(found.size(), 3u);
  const std::string new_baseline = param("new_baseline");
  if (!new_baseline.empty()) {
    std::ofstream file(new_baseline);
    file << "# Measured by bag.test with rebaseline:=true.\n";
    for (const Figure& figure : found) file << figure.name << ": " << figure.value << "\n";
    ASSERT_TRUE(file.good()) << new_baseline;
    return;
  }
  for (const Figure& figure : found) {
    std::printf("%-24s %8.3f\n", figure.name, figure.value);
    double before = 0;
    ASSERT_TRUE(ros::param::get(std::string("~baseline/") + figure.name, before))
        << "the baseline lacks " << figure.name << ": see bag.test on how to store it";
    const double margin = figure.worst - figure.value;
    if (larger(figure))
      EXPECT_GE(figure.value, before + margin) << figure.name << ", it was " << before;
    else
      EXPECT_LE(figure.value, before + margin) << figure.name << ", it was " << before;
  }
}

TEST_F(Bag, replay_gives_the_same) {
  const std::string out = folder_->path("replay.bag");
  runProgram(std::string(REPLAY) + " --bag " + recording_->path + " --output " + out +
             " --config " + param("config") +
             " --topics disparity,measured_disparity,predicted_disparity,odometry,moving_objects");
  rosbag::Bag bag(out);
  std::map<std::string, size_t> compared;
  for (const auto& message : rosbag::View(bag)) {
    const std::string topic = message.getTopic();
    const std::string name = topic.substr(topic.rfind('/') + 1);
    if (const auto replayed = message.instantiate<stereo_msgs::DisparityImage>()) {
      const DisparityRecorder& recorder = name == "disparity"            ? first_->disparity
                                          : name == "measured_disparity" ? first_->measured
                                                                         : first_->predicted;
      const auto live = recorder.at(replayed->header.stamp);
      ASSERT_TRUE(live) << name;
      EXPECT_TRUE(live->image.data == replayed->image.data)
          << name << " at " << replayed->header.stamp;
    } else if (const auto replayed = message.instantiate<nav_msgs::Odometry>()) {
      const auto live = first_->odometry.at(replayed->header.stamp);
      ASSERT_TRUE(live);
      EXPECT_TRUE(live->pose == replayed->pose && live->twist == replayed->twist)
          << replayed->header.stamp;
    } else if (const auto replayed = message.instantiate<MovingObjectArray>()) {
      const auto live = first_->objects.at(replayed->header.stamp);
      ASSERT_TRUE(live);
      EXPECT_TRUE(live->objects == replayed->objects) << replayed->header.stamp;
    } else {
      continue;
    }
    ++compared[name];
  }
  EXPECT_EQ(compared.size(), 5u);
  for (const auto& [name, count] : compared) EXPECT_EQ(count, player_->stamps().size()) << name;
}

TEST_F(Bag, played_in_a_loop_it_starts_anew_and_gives_the_same) {
  const ros::NodeHandle camera(param("camera"));
  second_ = std::make_unique<Outputs>(camera);
  ASSERT_TRUE(eventually([] { return second_->connected(); }));
  ros::WallDuration(0.5).sleep();
  player_->play(kSecondPass, wait(*second_));
  for (size_t i = 0; i < kSecondPass; ++i) {
    const ros::Time stamp = player_->stamps()[i];
    ASSERT_TRUE(second_->hasAllOutputs(stamp)) << "frame " << i;
    EXPECT_TRUE(second_->disparity.at(stamp)->image.data == first_->disparity.at(stamp)->image.data)
        << "frame " << i;
    EXPECT_TRUE(second_->odometry.at(stamp)->pose == first_->odometry.at(stamp)->pose)
        << "frame " << i;
    EXPECT_TRUE(withoutIds(*second_->objects.at(stamp)) == withoutIds(*first_->objects.at(stamp)))
        << "frame " << i;
  }
  for (const char* name : {"/ego_motion", "/disparity", "/moving_objects"})
    EXPECT_TRUE(eventually([&] {
      for (const auto& line : log_->messages())
        if (line->msg.find(param("camera") + name + ": stamps went back") != std::string::npos)
          return true;
      return false;
    })) << name
        << " does not say that it starts anew";
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "bag_test");
  ros::AsyncSpinner spinner(1);
  spinner.start();
  return RUN_ALL_TESTS();
}
