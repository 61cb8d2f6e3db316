/// Messages that no publisher should send, on every input topic of every nodelet: the diagnostics
/// name each, and the nodelets process the next good pairs.
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <predictive_stereo/RowAlignment.h>
#include <sensor_msgs/Imu.h>
#include <std_srvs/Empty.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "changed_pairs.h"
#include "nodelet_fixture.h"
#include "nodelets/callbacks.h"

namespace predictive_stereo {
namespace {

const ros::Time kRefused[] = {ros::Time(2147483648u, 0), ros::Time(4200000000u, 0),
                              ros::Time(4294967295u, 999999999)};
const ros::Time kLargest(2147483647u, 0);
const ros::Duration kHours(3 * 3600.0);
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class HostileMessages : public NodeletTest {
 protected:
  using Names = std::vector<std::string>;
  /// A topic, and the nodelets that subscribe to it.
  struct Input {
    std::string topic;
    Names readers;
    std::function<void(ros::Time)> send;  ///< a message that is good but for this stamp
    bool may_be_zero = false;
  };

  template <class Message>
  Input input(const std::string& topic, const Names& readers, const Message& message) {
    const ros::Publisher publisher = node_.advertise<Message>(topic, 20);
    publishers_.push_back(publisher);
    return {publisher.getTopic(), readers, [=](ros::Time stamp) {
              Message stamped = message;
              stamped.header.stamp = stamp;
              publisher.publish(stamped);
              ros::WallDuration(0.02).sleep();  // so that no queue drops it
            }};
  }
  Input transforms(const std::string& topic) {
    const ros::Publisher publisher = node_.advertise<tf2_msgs::TFMessage>(topic, 20);
    publishers_.push_back(publisher);
    return {topic, all_,
            [=](ros::Time stamp) {
              tf2_msgs::TFMessage message = transform(stamp);
              message.transforms[0].child_frame_id = topic == "/tf" ? "wheel" : "axle";
              publisher.publish(message);
            },
            topic == "/tf_static"};
  }

  static tf2_msgs::TFMessage transform(ros::Time stamp) {
    tf2_msgs::TFMessage message;
    message.transforms.resize(1);
    message.transforms[0].header.stamp = stamp;
    message.transforms[0].header.frame_id = "base_link";
    message.transforms[0].child_frame_id = "wheel";
    message.transforms[0].transform.rotation.w = 1;
    return message;
  }
  static sensor_msgs::Imu imu() {
    sensor_msgs::Imu message;
    message.header.frame_id = "imu";
    return message;
  }
  static nav_msgs::Odometry odometry() {
    nav_msgs::Odometry message;
    message.child_frame_id = "base_link";
    return message;
  }
  static sensor_msgs::Image mask() {
    sensor_msgs::Image message = *street().pair(0).left;
    std::fill(message.data.begin(), message.data.end(), 0);
    return message;
  }
  static sensor_msgs::Image variance() {
    sensor_msgs::Image message = mask();
    message.encoding = "32FC1";
    message.step *= 4;
    message.data.resize(4 * message.data.size());
    return message;
  }
  static stereo_msgs::DisparityImage disparityImage() {
    stereo_msgs::DisparityImage message;
    message.image = variance();
    message.max_disparity = 127;
    return message;
  }

  std::vector<Input> inputs() {
    const StereoPair pair = street().pair(0);
    const Names cameras = {"EgoMotion", "Disparity"}, objects = {"MovingObjects"};
    std::vector<Input> inputs = {input("left/image_rect", all_, *pair.left),
                                 input("right/image_rect", cameras, *pair.right),
                                 input("left/camera_info", all_, *pair.left_info),
                                 input("right/camera_info", cameras, *pair.right_info),
                                 transforms("/tf"),
                                 transforms("/tf_static"),
                                 input("imu", {"EgoMotion"}, imu()),
                                 input("moving_objects/mask", cameras, mask()),
                                 input("odometry", {"Disparity", "MovingObjects"}, odometry()),
                                 input("odometry/row_alignment", {"Disparity"}, RowAlignment()),
                                 input("measured_disparity", objects, disparityImage()),
                                 input("predicted_disparity", objects, disparityImage()),
                                 input("measured_variance", objects, variance()),
                                 input("predicted_variance", objects, variance()),
                                 input("row_alignment", objects, RowAlignment())};
    inputs[2].may_be_zero = inputs[3].may_be_zero = true;
    return inputs;
  }

  void start() {
    setParam("EgoMotion", "use_imu", true);
    setParam("EgoMotion", "use_moving_mask", true);
    setParam("Disparity", "use_moving_mask", true);
    for (const std::string& nodelet : all_) load(nodelet);
    ASSERT_TRUE(player_.waitForSubscribers());
    ASSERT_TRUE(eventually([&] { return disparity_.connected() && objects_.connected(); }));
    for (const Input& input : inputs()) inputs_.push_back(input);
    ASSERT_TRUE(eventually([&] {
      for (const ros::Publisher& publisher : publishers_)
        if (publisher.getNumSubscribers() == 0) return false;
      return true;
    }));
    ros::WallDuration(0.5).sleep();
    expectGood("start");
  }

  /// The next pair of a camera that drives to and fro.
  StereoPair next() {
    const int last = street().frames() - 1, place = ++frame_ % (2 * last);
    stamp_ += ros::Duration(0.1);
    return withStamp(street().pair(place <= last ? place : 2 * last - place), stamp_);
  }
  bool comesOutOfAll(const StereoPair& pair) {
    const ros::Time stamp = pair.left->header.stamp;
    player_.publish(pair);
    return eventually(
        [&] { return disparity_.at(stamp) && odometry_.at(stamp) && objects_.at(stamp); }, 10);
  }
  /// The third pair after a fault.
  void expectGood(const std::string& fault) {
    ros::WallDuration(0.05).sleep();  // what is still on its way
    bool came = false;
    for (int i = 0; i < 3; ++i) came = comesOutOfAll(next());
    ASSERT_TRUE(came) << fault;
    EXPECT_LT(odometry_.at(stamp_)->twist.covariance[0], 1) << fault << ": EgoMotion is lost";
    disparity_.clear();
    odometry_.clear();
    objects_.clear();
  }
  const Input& inputNamed(const std::string& topic) {
    for (const Input& input : inputs_)
      if (input.topic == topic || input.topic == ns_ + "/" + topic) return input;
    throw std::logic_error(topic);
  }
  template <class Message>
  void publish(const std::string& topic, const Message& message) {
    for (const ros::Publisher& publisher : publishers_)
      if (publisher.getTopic() == inputNamed(topic).topic) publisher.publish(message);
  }

  const Names all_ = {"EgoMotion", "Disparity", "MovingObjects"};
  int frame_ = 0;
  ros::Time stamp_ = ros::Time(1600000000);
  std::vector<ros::Publisher> publishers_;
  std::vector<Input> inputs_;
  StaticTransform extrinsic_{street().extrinsic()};
  DisparityRecorder disparity_{node_, "disparity"};
  Recorder<nav_msgs::Odometry> odometry_{node_, "odometry"};
  Recorder<MovingObjectArray> objects_{node_, "moving_objects"};
  Recorder<sensor_msgs::Image> residual_{node_, "moving_objects/residual"};  // needs all inputs
};

TEST_F(HostileMessages, stamps_that_ros_cannot_compute_with) {
  start();
  for (const Input& input : inputs_) {
    for (const ros::Time stamp : kRefused) input.send(stamp);
    for (const std::string& nodelet : input.readers)
      EXPECT_TRUE(says(nodelet, input.topic + ": ") && says(nodelet, "4294967295.999999999 s"))
          << input.topic;
    input.send(kLargest);
    input.send(ros::Time());
    if (!input.may_be_zero)
      for (const std::string& nodelet : input.readers) {
        EXPECT_TRUE(says(nodelet, "stamp 0: ")) << input.topic;
        EXPECT_TRUE(eventually([&] { return value(nodelet, "refused: " + input.topic) == "4"; }))
            << nodelet << " refused " << value(nodelet, "refused: " + input.topic) << " of "
            << input.topic;
      }
    expectGood(input.topic);
    if (HasFatalFailure()) return;
  }
  // Good messages solve the problems.
  EXPECT_TRUE(eventually([&] {
    comesOutOfAll(next());
    return !diagnostics_.says(ns_.substr(1) + "/Disparity", "image_rect: ") &&
           !diagnostics_.says(ns_.substr(1) + "/Disparity", "camera_info: ");
  }));
}

TEST_F(HostileMessages, pairs_with_such_stamps) {
  start();
  for (const ros::Time stamp : kRefused) player_.publish(withStamp(next(), stamp));
  EXPECT_TRUE(says("Disparity", "left/image_rect: stamp 4294967295.999999999 s"));
  player_.publish(withStamp(next(), ros::Time()));
  expectGood("stamps that are refused");
  player_.publish(withStamp(next(), kLargest));
  expectGood("the largest stamp");
  sensor_msgs::Image image = *next().left;
  image.header.stamp.nsec = 2000000000;
  publish("left/image_rect", image);
  EXPECT_TRUE(says("Disparity", "left/image_rect: stamp 1600000"));
  expectGood("two thousand million nanoseconds");
}

TEST_F(HostileMessages, times_that_jump_by_hours) {
  start();
  for (const Input& input : inputs_)
    for (const ros::Duration& jump : {kHours, -kHours}) {
      input.send(stamp_ + jump);
      expectGood(input.topic);
      if (HasFatalFailure()) return;
    }
  for (const ros::Duration& jump : {kHours, -kHours}) {
    player_.publish(withStamp(next(), stamp_ + jump));
    expectGood("a pair");
  }
}

TEST_F(HostileMessages, transforms_that_are_none) {
  start();
  const auto expectNamed =
      [&](const std::string& name, const std::string& reason,
          const std::function<void(geometry_msgs::TransformStamped&)>& change) {
        for (const char* topic : {"/tf", "/tf_static"}) {
          tf2_msgs::TFMessage message = transform(stamp_);
          message.transforms[0].child_frame_id = StreetCamera::kFrame;  // as the good extrinsic
          change(message.transforms[0]);
          publish(topic, message);
          for (const std::string& nodelet : all_) {
            EXPECT_TRUE(says(nodelet, std::string(topic) + ": transform of '")) << name;
            EXPECT_TRUE(says(nodelet, reason)) << name;
          }
          expectGood(name);
        }
      };
  using Stamped = geometry_msgs::TransformStamped;
  expectNamed("NaN", "not finite", [](Stamped& t) { t.transform.translation.x = kNan; });
  expectNamed("infinity", "not finite", [](Stamped& t) { t.transform.translation.z = kInfinity; });
  expectNamed("NaN in the rotation", "not finite",
              [](Stamped& t) { t.transform.rotation.x = kNan; });
  expectNamed("no rotation", "unit quaternion", [](Stamped& t) { t.transform.rotation.w = 0; });
  expectNamed("no child", "of '' in", [](Stamped& t) { t.child_frame_id.clear(); });
  expectNamed("no parent", "in ''", [](Stamped& t) { t.header.frame_id.clear(); });
  expectNamed("itself", "its own parent", [](Stamped& t) { t.header.frame_id = t.child_frame_id; });
}

TEST_F(HostileMessages, frames_without_a_name_and_numbers_that_are_none) {
  start();
  sensor_msgs::Imu unnamed = imu();
  unnamed.header.stamp = stamp_;
  unnamed.header.frame_id.clear();
  publish("imu", unnamed);
  EXPECT_TRUE(says("EgoMotion", "/imu: frame_id is empty"));
  sensor_msgs::Imu spinning = imu();
  spinning.header.stamp = stamp_;
  spinning.angular_velocity.y = kInfinity;
  publish("imu", spinning);
  EXPECT_TRUE(says("EgoMotion", "/imu: angular_velocity is not finite"));
  expectGood("imu");

  nav_msgs::Odometry childless = odometry();
  childless.header.stamp = stamp_;
  childless.child_frame_id.clear();
  publish("odometry", childless);
  EXPECT_TRUE(says("Disparity", "/odometry: child_frame_id is empty"));
  expectGood("odometry");

  RowAlignment columns;
  columns.header.stamp = stamp_;
  columns.column_offset_sigma = 1;
  columns.column_correction = kNan;
  publish("odometry/row_alignment", columns);
  publish("row_alignment", columns);
  for (const char* nodelet : {"Disparity", "MovingObjects"})
    EXPECT_TRUE(says(nodelet, "row_alignment: its column offset is not finite"));
  expectGood("row_alignment");

  StereoPair pair = next();
  const auto frameless = copyOf(pair.left);
  frameless->header.frame_id.clear();
  pair.left = frameless;
  player_.publish(pair);
  for (const std::string& nodelet : all_)
    EXPECT_TRUE(says(nodelet, "left/image_rect has an empty frame_id"));
  expectGood("an image without a frame");
}

TEST_F(HostileMessages, sizes_that_contradict_each_other) {
  start();
  using Image = sensor_msgs::Image;
  const auto sendPair = [&](const std::function<void(Image&)>& change, bool right) {
    StereoPair pair = next();
    const auto changed = copyOf(right ? pair.right : pair.left);
    change(*changed);
    (right ? pair.right : pair.left) = changed;
    player_.publish(pair);
  };
  for (const bool right : {false, true}) {
    sendPair([](Image& image) { image.data.resize(100); }, right);
    EXPECT_TRUE(says("Disparity", "image is broken"));
    EXPECT_TRUE(says("EgoMotion", "image is broken"));
    expectGood("data cut off");
    sendPair([](Image& image) { image.width = image.height = 0xffffffffu; }, right);
    expectGood("a size that no camera has");
    sendPair([](Image& image) { image.step = 0; }, right);
    expectGood("a step of 0");
  }
  // What MovingObjects gets beside Disparity's own messages has the stamp of the next pair.
  const ros::Time stamp = stamp_ + ros::Duration(0.1);
  Image narrow = variance();
  narrow.width /= 2;
  narrow.header.stamp = stamp;
  publish("measured_variance", narrow);
  stereo_msgs::DisparityImage empty = disparityImage();
  empty.header.stamp = stamp;
  empty.image = Image();
  publish("predicted_disparity", empty);
  expectGood("maps of other sizes");
}

// Disparity and EgoMotion go on without it.
TEST_F(HostileMessages, masks_that_cannot_be_used) {
  setParam("Disparity", "transform_timeout", 5.0);  // no mask is asked for without a motion
  start();
  sensor_msgs::Image coded = mask(), small = mask();
  coded.encoding = "smoke";
  small.height /= 2;
  small.data.resize(small.data.size() / 2);
  for (const auto& [bad, reason] : {std::pair(coded, "encoding 'smoke'"), {small, "416x64"}}) {
    Recorder<MovingObjectArray> objects(node_, "moving_objects");
    bool ego_motion_told = false, disparity_told = false;
    // Masks of MovingObjects arrive, too: it must be the last one when the next pair arrives.
    for (int round = 0; round < 20 && !(ego_motion_told && disparity_told); ++round) {
      ASSERT_TRUE(comesOutOfAll(next())) << reason;
      sensor_msgs::Image stamped = bad;
      stamped.header.stamp = stamp_;
      ros::WallDuration(0.05).sleep();
      publish("moving_objects/mask", stamped);
      ros::WallDuration(0.05).sleep();
      ASSERT_TRUE(comesOutOfAll(next())) << "with a mask of " << reason;
      eventually(
          [&] {
            ego_motion_told |= diagnostics_.says(ns_.substr(1) + "/EgoMotion", reason);
            disparity_told |= diagnostics_.says(ns_.substr(1) + "/Disparity", reason);
            return ego_motion_told && disparity_told;
          },
          2);
    }
    EXPECT_TRUE(ego_motion_told) << reason;
    EXPECT_TRUE(disparity_told) << reason;
    expectGood(reason);
  }
}

TEST_F(HostileMessages, to_rectify) {
  load("Rectify");
  const Recorder<sensor_msgs::Image> rectified(node_, "image_rect");
  const StereoPair pair = street().pair(0);
  sensor_msgs::CameraInfo info = *pair.left_info;
  info.K = {info.P[0], 0, info.P[2], 0, info.P[5], info.P[6], 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.distortion_model = "plumb_bob";
  info.D.assign(5, 0);
  const std::vector<Input> inputs = {input("image_raw", {"Rectify"}, *pair.left),
                                     input("camera_info", {"Rectify"}, info)};
  ASSERT_TRUE(eventually([&] {
    return publishers_[0].getNumSubscribers() > 0 && publishers_[1].getNumSubscribers() > 0;
  }));
  const auto expectRectified = [&](const std::string& fault) {
    bool came = false;
    for (int i = 0; i < 3; ++i) {
      stamp_ += ros::Duration(0.1);
      for (const Input& input : inputs) input.send(stamp_);
      came = eventually([&] { return rectified.at(stamp_) != nullptr; }, 10);
    }
    EXPECT_TRUE(came) << fault;
  };
  expectRectified("start");
  for (const Input& input : inputs) {
    for (const ros::Time stamp : kRefused) input.send(stamp);
    EXPECT_TRUE(says("Rectify", input.topic + ": stamp 4294967295.999999999 s"));
    input.send(ros::Time());
    for (const ros::Duration& jump : {kHours, -kHours}) {
      input.send(stamp_ + jump);
      expectRectified(input.topic);
    }
  }
  for (const ros::Time stamp : {kLargest, kRefused[1]})
    for (const Input& input : inputs) input.send(stamp);
  expectRectified("both");
  sensor_msgs::Image broken = *pair.left;
  broken.data.resize(10);
  broken.header.stamp = info.header.stamp = stamp_ + ros::Duration(0.05);
  publishers_[0].publish(broken);
  publishers_[1].publish(info);
  EXPECT_TRUE(says("Rectify", "image is broken"));
  expectRectified("data cut off");
}

/// What no message brings about: exceptions of any type.
TEST(GuardedCallbacks, end_whatever_is_thrown_and_the_diagnostics_name_it) {
  ros::NodeHandle node("/guarded");
  const DiagnosticsRecorder diagnostics(node);
  Health health(node, node, "/guarded", "Guard", [] { return std::string(); });
  health.start();
  EXPECT_FALSE(health.guard("/a", [] { throw XmlRpc::XmlRpcException("no such value"); }));
  EXPECT_FALSE(health.guard("/b", [] { throw 5; }));
  EXPECT_FALSE(health.guard("/c", [] { throw std::runtime_error("too late"); }));
  EXPECT_FALSE(health.guard("/c", [] { throw std::runtime_error("too late"); }));
  for (const char* text : {"/a: no such value", "/b: an exception of unknown type", "/c: too late"})
    EXPECT_TRUE(eventually([&] { return diagnostics.says("guarded", text); }, 10)) << text;
  EXPECT_EQ(diagnostics.of("guarded").level, diagnostic_msgs::DiagnosticStatus::WARN);
  EXPECT_EQ(diagnostics.value("guarded", "refused: /c"), "2");
  EXPECT_TRUE(health.guard("/a", [] {}));
  EXPECT_TRUE(diagnostics.says("guarded", "/a")) << "gone before anybody could read it";
  EXPECT_TRUE(eventually([&] { return !diagnostics.says("guarded", "/a"); }, 10));
  EXPECT_TRUE(diagnostics.says("guarded", "/c"));
}

TEST(GuardedCallbacks, are_those_of_topics_and_services) {
  ros::NodeHandle node("/guarded_calls");
  const DiagnosticsRecorder diagnostics(node);
  Health health(node, node, "/guarded_calls", "Guard", [] { return std::string(); });
  health.start();
  const ros::Subscriber subscriber = subscribe<sensor_msgs::Imu>(
      node, health, "imu", 5,
      [](const sensor_msgs::ImuConstPtr&) { throw XmlRpc::XmlRpcException("of a message"); });
  const ros::ServiceServer service =
      advertiseService<std_srvs::EmptyRequest, std_srvs::EmptyResponse>(
          node, health, "reset", [](std_srvs::EmptyRequest&, std_srvs::EmptyResponse&) -> bool {
            throw XmlRpc::XmlRpcException("of a service");
          });
  const ros::Publisher publisher = node.advertise<sensor_msgs::Imu>("imu", 5);
  sensor_msgs::Imu imu;
  imu.header.stamp = ros::Time(5);
  publisher.publish(imu);
  std_srvs::Empty call;
  EXPECT_FALSE(ros::service::call("/guarded_calls/reset", call));
  for (const char* text :
       {"/guarded_calls/imu: of a message", "/guarded_calls/reset: of a service"})
    EXPECT_TRUE(eventually([&] { return diagnostics.says("guarded_calls", text); }, 10)) << text;
}

// wake() and sleep() replace subscribers while frames are processed: for ThreadSanitizer.
TEST_F(HostileMessages, subscribers_come_and_go_while_an_imu_is_asked_for) {
  setParam("EgoMotion", "use_imu", true);
  setParam("EgoMotion", "publish_tf", false);
  load("EgoMotion");
  for (int i = 0; i < 20; ++i) {
    const Recorder<nav_msgs::Odometry> odometry(node_, "odometry");
    ASSERT_TRUE(eventually([&] { return player_.subscribers() == 4; }));
    for (int pair = 0; pair < 3; ++pair) player_.publish(next());
    eventually([&] { return odometry.count() > 0; }, 0.2);
  }
  EXPECT_TRUE(says("EgoMotion", "use_imu: nobody publishes"));
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "hostile_messages_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
