/// Runs the tool on small streets, and with wrong inputs.
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <set>

#include "bag_messages.h"
#include "tool_fixture.h"

namespace predictive_stereo {
namespace {

// A camera with raw images, which are shifted by this; its camera_info has the shift.
constexpr int kLeftOff_px = 4, kRightDown_px = 3;

cv::Mat1b pixelsOf(const sensor_msgs::Image& image) {
  return cv::Mat1b(static_cast<int>(image.height), static_cast<int>(image.width),
                   const_cast<uint8_t*>(image.data.data()), image.step);
}

sensor_msgs::Image shifted(const sensor_msgs::Image& rectified, int x, int y) {
  sensor_msgs::Image raw = rectified;
  std::fill(raw.data.begin(), raw.data.end(), uint8_t{0});
  const cv::Size size(static_cast<int>(raw.width) - x, static_cast<int>(raw.height) - y);
  pixelsOf(rectified)(cv::Rect(cv::Point(), size))
      .copyTo(pixelsOf(raw)(cv::Rect(cv::Point(x, y), size)));
  return raw;
}

sensor_msgs::CameraInfo calibrationOf(const sensor_msgs::CameraInfo& rectified, int x, int y) {
  sensor_msgs::CameraInfo raw = rectified;
  const auto& P = rectified.P;
  raw.K = {P[0], 0, P[2] + x, 0, P[5], P[6] + y, 0, 0, 1};
  raw.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  raw.D.assign(5, 0.0);
  raw.distortion_model = "plumb_bob";
  return raw;
}

void makeRaw(const std::string& from, const std::string& to) {
  rosbag::Bag out(to, rosbag::bagmode::Write);
  rosbag::Bag in(from);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    const std::string& topic = message.getTopic();
    const bool left = topic.find("/left/") != std::string::npos;
    const int x = left ? kLeftOff_px : 0, y = left ? 0 : kRightDown_px;
    if (const auto image = message.instantiate<sensor_msgs::Image>())
      out.write(left ? "/street/left/image_raw" : "/street/right/image_raw", message.getTime(),
                shifted(*image, x, y));
    else if (const auto info = message.instantiate<sensor_msgs::CameraInfo>())
      out.write(topic, message.getTime(), calibrationOf(*info, x, y));
    else if (topic == "/tf_static")
      out.write(topic, message.getTime(), message);
  }
}

// The same images as PNG, which is lossless.
void compress(const std::string& from, const std::string& to) {
  rosbag::Bag out(to, rosbag::bagmode::Write);
  rosbag::Bag in(from);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    const std::string& topic = message.getTopic();
    if (const auto image = message.instantiate<sensor_msgs::Image>()) {
      sensor_msgs::CompressedImage packed;
      packed.header = image->header;
      packed.format = "mono8; png compressed ";
      if (image->encoding != "mono8") continue;
      cv::imencode(".png", pixelsOf(*image), packed.data);
      out.write(topic + "/compressed", message.getTime(), packed);
    } else if (topic == "/tf_static" || message.instantiate<sensor_msgs::CameraInfo>()) {
      out.write(topic, message.getTime(), message);
    }
  }
}

cv::Mat1f disparityOf(const stereo_msgs::DisparityImage& message) {
  cv::Mat1f map(static_cast<int>(message.image.height), static_cast<int>(message.image.width));
  std::memcpy(map.data, message.image.data.data(), message.image.data.size());
  return map;
}

class Replay : public ToolTest {
 protected:
  Result replay(const std::string& arguments) const {
    return run(std::string(REPLAY) + " " + arguments);
  }
  std::string street() const {
    const std::string path = files_.path("street.bag");
    if (!std::filesystem::exists(path)) {
      const std::string options = " --scene straight --frames 4 --size 496x160";
      EXPECT_EQ(run(std::string(STREET_TO_BAG) + " " + path + options).status, 0);
    }
    return path;
  }
  void expectRefused(const std::string& arguments, const std::string& message) const {
    const std::string out = files_.path("refused.bag");
    const Result result = replay(arguments + " --output " + out);
    EXPECT_NE(result.status, 0) << arguments;
    EXPECT_NE(result.errors.find(message), std::string::npos) << arguments << "\n" << result.errors;
    EXPECT_FALSE(std::filesystem::exists(out)) << arguments;
  }
};

TEST_F(Replay, WritesWhatIsAskedForOfEveryPair) {
  const std::string out = files_.path("out.bag");
  const Result result = replay("--bag " + street() + " --output " + out +
                               " --camera street --topics disparity,search_range");
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(messagesIn<stereo_msgs::DisparityImage>(out).at("/street/disparity").size(), 4u);
  const auto images = messagesIn<sensor_msgs::Image>(out);
  ASSERT_EQ(images.size(), 1u);
  EXPECT_EQ(images.at("/street/search_range").size(), 4u);
}

TEST_F(Replay, WritesWhatCanBeToldWithoutTruth) {
  const std::string bag = files_.path("a,b.bag");
  std::filesystem::copy_file(street(), bag);
  const Result result = replay("--bag " + bag + " --topics odometry --output " +
                               files_.path("out.bag") + " --csv " + files_.path("figures.csv"));
  ASSERT_EQ(result.status, 0) << result.errors;
  std::istringstream lines(text("figures.csv"));
  std::string header, figures;
  std::getline(lines, header);
  std::getline(lines, figures);
  EXPECT_EQ(header.find("recording,pairs,unmatched,duplicates,lost_percent,unpredicted_percent,"),
            0u);
  // The first frame of four has no past.
  EXPECT_EQ(figures.find("\"a,b\",4,0,0,0,25,"), 0u) << figures;
}

TEST_F(Replay, EgoMotionUsesTheMaskWhereItIsTold) {
  const std::string near = files_.path("near.bag");
  const std::string street = " --scene near_half_moves --frames 8 --size 496x160";
  ASSERT_EQ(run(std::string(STREET_TO_BAG) + " " + near + street).status, 0);
  const auto last = [&](const std::string& used) {
    const std::string out = files_.path(used + ".bag");
    const Result result = replay("--bag " + near + " --camera street --topics odometry --output " +
                                 out + " --set ego_motion/use_moving_mask=" + used);
    EXPECT_EQ(result.status, 0) << result.errors;
    return messagesIn<nav_msgs::Odometry>(out).at("/street/odometry").back()->pose.pose.position;
  };
  // Half of the view moves, so features on it change the motion.
  EXPECT_NE(last("true"), last("false"));
}

// As of a simulator that was reset: the poses of the first pass are not those of the second one.
TEST_F(Replay, APassWithTheStampsOfAnotherHasItsOwnPoses) {
  const std::string passes = files_.path("passes.bag");
  {
    rosbag::Bag out(passes, rosbag::bagmode::Write);
    ros::Duration later;
    for (const std::string scene : {"straight", "fast_rotation"}) {
      const std::string path = files_.path(scene + ".bag");
      const std::string options = " --frames 8 --size 496x160 --scene " + scene;
      ASSERT_EQ(run(std::string(STREET_TO_BAG) + " " + path + options).status, 0);
      rosbag::Bag in(path);
      for (const rosbag::MessageInstance& message : rosbag::View(in))
        out.write(message.getTopic(), message.getTime() + later, message);
      later += ros::Duration(10);
    }
  }
  const auto disparities = [&](const std::string& bag) {
    const std::string out = files_.path("out.bag");
    const Result result = replay("--topics disparity --bag " + bag + " --output " + out);
    EXPECT_EQ(result.status, 0) << result.errors;
    return messagesIn<stereo_msgs::DisparityImage>(out).at("/disparity");
  };
  const auto both = disparities(passes), second = disparities(files_.path("fast_rotation.bag"));
  ASSERT_EQ(both.size(), 16u);
  for (size_t k = 0; k < 8; ++k) EXPECT_EQ(both[8 + k]->image, second[k]->image) << k;
}

TEST_F(Replay, ReadsCompressedImages) {
  const std::string packed = files_.path("packed.bag"), from_raw = files_.path("from_raw.bag"),
                    from_packed = files_.path("from_packed.bag");
  compress(street(), packed);
  ASSERT_EQ(replay("--bag " + street() + " --topics disparity --output " + from_raw).status, 0);
  const Result result = replay("--bag " + packed + " --topics disparity --output " + from_packed);
  ASSERT_EQ(result.status, 0) << result.errors;
  const auto expected = messagesIn<stereo_msgs::DisparityImage>(from_raw).at("/disparity");
  const auto disparity = messagesIn<stereo_msgs::DisparityImage>(from_packed).at("/disparity");
  ASSERT_EQ(disparity.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i)
    EXPECT_TRUE(disparity[i]->image.data == expected[i]->image.data) << i;
}

TEST_F(Replay, KnowsTheLayoutsOfCheckBag) {
  const std::string path = files_.path("infrared.bag"), out = files_.path("out.bag");
  {
    rosbag::Bag in(street()), renamed(path, rosbag::bagmode::Write);
    for (const rosbag::MessageInstance& message : rosbag::View(in)) {
      std::string topic = std::regex_replace(message.getTopic(), std::regex("left"), "infra1");
      topic = std::regex_replace(topic, std::regex("right"), "infra2");
      topic = std::regex_replace(topic, std::regex("image_rect"), "image_rect_raw");
      renamed.write(topic, message.getTime(), message);
    }
  }
  const Result result = replay("--topics odometry --output " + out + " --bag " + path);
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.out.find("4 pairs"), std::string::npos) << result.out;
}

TEST_F(Replay, RectifiesRawImages) {
  makeRaw(street(), files_.path("raw.bag"));
  const std::string rectified = files_.path("rectified.bag"), raw = files_.path("from_raw.bag");
  const std::string options = " --topics disparity --camera /street --output ";
  ASSERT_EQ(replay("--bag " + street() + options + rectified).status, 0);
  const Result result = replay("--bag " + files_.path("raw.bag") + options + raw + " --rectify");
  ASSERT_EQ(result.status, 0) << result.errors;
  const auto expected = messagesIn<stereo_msgs::DisparityImage>(rectified).at("/street/disparity");
  const auto found = messagesIn<stereo_msgs::DisparityImage>(raw).at("/street/disparity");
  ASSERT_EQ(found.size(), expected.size());
  for (size_t k = 0; k < found.size(); ++k) {
    const cv::Mat1f a = disparityOf(*expected[k]), b = disparityOf(*found[k]);
    int known = 0, equal = 0;
    for (int y = 0; y < a.rows - 16; ++y)  // the last rows and columns were cut off
      for (int x = 0; x < a.cols - 16; ++x) {
        if (a(y, x) < expected[k]->min_disparity) continue;
        ++known;
        equal += std::abs(a(y, x) - b(y, x)) < 0.5f;
      }
    EXPECT_GT(known, a.size().area() / 2) << "frame " << k;
    EXPECT_GT(equal, 0.95 * known) << "frame " << k;
  }
}

TEST_F(Replay, WarnsWhereNoSimdInstructionsAreUsed) {
  const std::string arguments =
      "--bag " + street() + " --topics odometry --duration 0.05 --output ";
  const Result fast = replay(arguments + files_.path("fast.bag"));
  ASSERT_EQ(fast.status, 0) << fast.errors;
  EXPECT_EQ(fast.errors.find("simd_target"), std::string::npos) << fast.errors;
  const Result slow =
      replay(arguments + files_.path("slow.bag") + " --set disparity/matcher/simd_target=scalar");
  ASSERT_EQ(slow.status, 0) << slow.errors;
  EXPECT_NE(slow.errors.find("warning: simd_target is scalar"), std::string::npos) << slow.errors;
}

TEST_F(Replay, GoesOnWithoutMessagesThatTheNodeletsRefuse) {
  const std::string path = files_.path("hostile.bag"), out = files_.path("out.bag");
  const std::string options =
      " --camera street --topics disparity,odometry --output " + out + " --bag ";
  ASSERT_EQ(replay(options + street()).status, 0);
  const auto expected = messagesIn<nav_msgs::Odometry>(out).at("/street/odometry");
  std::filesystem::copy_file(street(), path);
  {
    rosbag::Bag bag(path, rosbag::bagmode::Append);
    const ros::Time now = expected[0]->header.stamp + ros::Duration(0.05);
    sensor_msgs::CameraInfo info;
    sensor_msgs::Image image;
    tf2_msgs::TFMessage tf;
    tf.transforms.resize(2);
    tf.transforms[0].child_frame_id = "wheel";
    tf.transforms[0].header.frame_id = "base_link";
    tf.transforms[0].transform.rotation.w = 1;
    for (const uint32_t sec : {2147483648u, 4200000000u, 4294967295u}) {
      info.header.stamp = image.header.stamp = tf.transforms[0].header.stamp =
          ros::Time(sec, 999999999);
      bag.write("/street/left/camera_info", now, info);
      bag.write("/street/right/image_rect", now, image);
      bag.write("/tf", now, tf);
    }
    image.header.stamp = ros::Time();
    bag.write("/street/right/image_rect", now, image);
  }
  const Result result = replay(options + path);
  ASSERT_EQ(result.status, 0) << result.errors;
  for (const char* text :
       {"warning: /street/left/camera_info: stamp 2147483648.999999999 s",
        "warning: /street/right/image_rect: stamp ",
        "warning: /tf: transform of 'wheel' in 'base_link' from the bag: stamp 2147483648"})
    EXPECT_NE(result.errors.find(text), std::string::npos) << text << "\n" << result.errors;
  EXPECT_NE(result.out.find("3 of /street/left/camera_info refused"), std::string::npos)
      << result.out;
  EXPECT_NE(result.out.find("4 of /street/right/image_rect refused"), std::string::npos)
      << result.out;
  const auto odometry = messagesIn<nav_msgs::Odometry>(out).at("/street/odometry");
  ASSERT_EQ(odometry.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(*odometry[i], *expected[i]) << i;
}

// Copies a bag; `change` may change each message of a type.
template <class Message>
void copyChanged(const std::string& from, const std::string& to,
                 const std::function<void(const std::string& topic, Message&)>& change) {
  rosbag::Bag out(to, rosbag::bagmode::Write);
  rosbag::Bag in(from);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    const auto found = message.instantiate<Message>();
    if (!found) {
      out.write(message.getTopic(), message.getTime(), message);
      continue;
    }
    change(message.getTopic(), *found);
    out.write(message.getTopic(), message.getTime(), *found, message.getConnectionHeader());
  }
}

TEST_F(Replay, GoesOnAfterAPairThatCannotBeUsed) {
  const std::string path = files_.path("torn.bag"), out = files_.path("out.bag");
  int image = 0;
  copyChanged<sensor_msgs::Image>(street(), path, [&](const std::string& topic, auto& message) {
    if (topic == "/street/right/image_rect" && ++image == 2) message.data.resize(100);
  });
  const Result result =
      replay("--camera street --topics disparity --output " + out + " --bag " + path);
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.errors.find("warning: pairs: right image is broken"), std::string::npos)
      << result.errors;
  EXPECT_NE(result.out.find("3 pairs, 1 of pairs refused"), std::string::npos) << result.out;
  EXPECT_EQ(messagesIn<stereo_msgs::DisparityImage>(out).at("/street/disparity").size(), 3u);
}

TEST_F(Replay, GoesOnAfterAnImageThatCannotBeDecoded) {
  const std::string packed = files_.path("packed.bag"), path = files_.path("torn.bag"),
                    out = files_.path("out.bag");
  compress(street(), packed);
  int image = 0;
  copyChanged<sensor_msgs::CompressedImage>(
      packed, path, [&](const std::string& topic, auto& message) {
        if (topic == "/street/left/image_rect/compressed" && ++image == 2) message.data = {1, 2, 3};
      });
  const Result result = replay("--topics odometry --output " + out + " --bag " + path);
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.out.find("3 pairs"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("1 of /street/left/image_rect/compressed refused"), std::string::npos)
      << result.out;
}

TEST_F(Replay, CountsLeftImagesThatFindNoPartnersUntilTheEnd) {
  const std::string path = files_.path("cut.bag"), out = files_.path("out.bag");
  int image = 0;
  copyChanged<sensor_msgs::Image>(street(), path, [&](const std::string& topic, auto& message) {
    if (topic == "/street/right/image_rect" && ++image > 2) message.header.stamp.sec += 100;
  });
  const Result result =
      replay("--camera street --topics odometry --output " + out + " --bag " + path);
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.out.find("2 pairs, 2 left images unmatched"), std::string::npos) << result.out;
}

TEST_F(Replay, SaysWhatIsWrongIfNoPairCanBeUsed) {
  const std::string path = files_.path("torn.bag");
  copyChanged<sensor_msgs::Image>(
      street(), path, [&](const std::string&, auto& message) { message.data.resize(100); });
  expectRefused("--bag " + path, "left image is broken");
}

// Child frames of the static tf.
std::set<std::string> staticFrames(const std::string& bag) {
  std::set<std::string> frames;
  const auto messages = messagesIn<tf2_msgs::TFMessage>(bag);
  for (const auto& message : messages.at("/tf_static"))
    for (const auto& transform : message->transforms) frames.insert(transform.child_frame_id);
  return frames;
}

TEST_F(Replay, TheOutputHasTheMountingOfTheCamera) {
  const std::string out = files_.path("out.bag"), robot = files_.path("robot.bag");
  const std::string options = " --topics odometry --camera street --output " + out + " --bag ";
  ASSERT_EQ(replay(options + street()).status, 0);
  const std::set<std::string> expected = staticFrames(out);
  EXPECT_EQ(expected.count("camera_left_optical_frame"), 1u);
  ASSERT_EQ(replay(options + street() + " --start 0.15").status, 0);
  EXPECT_EQ(staticFrames(out), expected) << "it was sent before the first pair";

  // One message with all fixed joints; the odometry moves one of them.
  copyChanged<tf2_msgs::TFMessage>(street(), robot, [](const std::string& topic, auto& message) {
    if (topic != "/tf_static") return;
    message.transforms.push_back(message.transforms.front());
    message.transforms.back().header.frame_id = "base_footprint";
    message.transforms.back().child_frame_id = "base_link";
  });
  ASSERT_EQ(replay(options + robot).status, 0);
  EXPECT_EQ(staticFrames(out), expected);
}

TEST_F(Replay, DoesNotMoveAFrameInItself) {
  const std::string path = files_.path("fixed.bag"), out = files_.path("out.bag");
  copyChanged<tf2_msgs::TFMessage>(street(), path, [](const std::string&, auto& message) {
    for (auto& transform : message.transforms)
      if (transform.header.frame_id == "base_link") transform.header.frame_id = "odom";
  });
  const Result result =
      replay("--bag " + path + " --topics odometry --camera street --output " + out);
  ASSERT_EQ(result.status, 0) << result.errors;
  const auto odometry = messagesIn<nav_msgs::Odometry>(out).at("/street/odometry");
  EXPECT_EQ(odometry.back()->header.frame_id, "visual_odom");
  EXPECT_EQ(odometry.back()->child_frame_id, "odom");
  EXPECT_NE(result.errors.find("in the frame 'visual_odom'"), std::string::npos);
}

// As cameras have that bring their own static tf: a frame must not get a second parent.
TEST_F(Replay, MovesWhatTheCameraIsFixedTo) {
  const std::string path = files_.path("mounted.bag"), out = files_.path("out.bag"),
                    expected = files_.path("expected.bag");
  copyChanged<tf2_msgs::TFMessage>(street(), path, [](const std::string&, auto& message) {
    for (auto& transform : message.transforms)
      if (transform.header.frame_id == "base_link") transform.header.frame_id = "camera_mount";
  });
  const std::string options = " --topics disparity,odometry --camera street --output ";
  ASSERT_EQ(replay("--bag " + street() + options + expected).status, 0);
  const Result result = replay("--bag " + path + options + out);
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.errors.find("'camera_mount', to which it is fixed, is the base frame"),
            std::string::npos)
      << result.errors;
  const auto odometry = messagesIn<nav_msgs::Odometry>(out).at("/street/odometry");
  EXPECT_EQ(odometry.back()->child_frame_id, "camera_mount");
  const auto tf = messagesIn<tf2_msgs::TFMessage>(out);
  for (const auto& message : tf.at("/tf"))
    EXPECT_EQ(message->transforms.at(0).child_frame_id, "camera_mount");
  const auto with_base = messagesIn<stereo_msgs::DisparityImage>(expected).at("/street/disparity");
  const auto disparity = messagesIn<stereo_msgs::DisparityImage>(out).at("/street/disparity");
  ASSERT_EQ(disparity.size(), with_base.size());
  for (size_t i = 0; i < disparity.size(); ++i)
    EXPECT_TRUE(disparity[i]->image.data == with_base[i]->image.data) << "frame " << i;
}

TEST_F(Replay, ACameraThatIsTheBaseHasNoOtherParent) {
  const std::string out = files_.path("out.bag");
  const Result result =
      replay("--bag " + street() + " --topics odometry --camera street --output " + out +
             " --set ego_motion/base_frame=");
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.errors.find("'camera_left_optical_frame' are replaced"), std::string::npos)
      << result.errors;
  EXPECT_EQ(staticFrames(out).count("camera_left_optical_frame"), 0u);
}

TEST_F(Replay, MistakesAreNamedAndLeaveNothingBehind) {
  expectRefused("--bag " + files_.path("none.bag"), "none.bag");
  expectRefused("--bag " + street() + " --topics depth", "there is no output 'depth'");
  expectRefused("--bag " + street() + " --start 1e15", "has no left image between --start");
  expectRefused("--bag " + street() + " --camera /front", "/front/left/image_rect");
  expectRefused("--bag " + street() + " --rectify --camera /street", "/street/left/image_raw");
  expectRefused("--bag " + street() + " --set disparity/matcher/p1=500", "p1");
  expectRefused("--bag " + street() + " --config " + files_.path("none.yaml"), "none.yaml");
}

TEST_F(Replay, TheRecordingIsNotOverwritten) {
  const auto bytes = std::filesystem::file_size(street());
  const std::string recording = files_.path("./street.bag");
  for (const std::string& outputs :
       {"--output " + recording, "--csv " + recording + " --output " + files_.path("out.bag")}) {
    const Result result = replay("--bag " + street() + " " + outputs);
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.errors.find("is an input, which would be lost"), std::string::npos);
    EXPECT_EQ(std::filesystem::file_size(street()), bytes);
  }
}

}  // namespace
}  // namespace predictive_stereo
