/// Nodelets without subscribers sleep, and so does the camera driver: checked by the subscribers of
/// the driver's topics and by the CPU time of the nodelets' process. A subscriber wakes what it
/// needs.
#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <ros/network.h>
#include <ros/xmlrpc_manager.h>
#include <sensor_msgs/PointCloud2.h>
#include <stereo_msgs/DisparityImage.h>
#include <tf2_msgs/TFMessage.h>
#include <topic_tools/shape_shifter.h>
#include <unistd.h>
#include <visualization_msgs/MarkerArray.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <thread>

#include "recorder.h"
#include "street_camera.h"

namespace predictive_stereo {
namespace {

constexpr double kSoon_s = 1;  // a new subscriber gets a message within this time
constexpr int kAttempts = 3;   // because the machine may be busy

const StreetCamera& street() {
  static const StreetCamera street(8);
  return street;
}

/// A driver that publishes at 10 Hz, forwards and backwards along the street.
class Driver {
 public:
  explicit Driver(const std::string& ns) : node_(ns) {
    left_ = node_.advertise<sensor_msgs::Image>("left/image_rect", 5);
    right_ = node_.advertise<sensor_msgs::Image>("right/image_rect", 5);
    left_info_ = node_.advertise<sensor_msgs::CameraInfo>("left/camera_info", 5);
    right_info_ = node_.advertise<sensor_msgs::CameraInfo>("right/camera_info", 5);
    thread_ = std::thread([this] { run(); });
  }
  ~Driver() {
    done_ = true;
    thread_.join();
  }

  uint32_t subscribers() const {
    return left_.getNumSubscribers() + right_.getNumSubscribers() + left_info_.getNumSubscribers() +
           right_info_.getNumSubscribers();
  }

 private:
  void run() {
    const int round = 2 * (street().frames() - 1);
    for (int i = 0; !done_; ++i) {
      StereoPair pair =
          street().pair(i % round < street().frames() ? i % round : round - i % round);
      const auto stamped = [&](auto& message) {
        auto copy = boost::make_shared<std::decay_t<decltype(*message)>>(*message);
        copy->header.stamp = street().stamp(0) + ros::Duration(0.1 * i);
        copy->header.frame_id = node_.getNamespace().substr(1) + "_camera";
        message = copy;
      };
      stamped(pair.left);
      stamped(pair.right);
      stamped(pair.left_info);
      stamped(pair.right_info);
      left_info_.publish(pair.left_info);
      right_info_.publish(pair.right_info);
      left_.publish(pair.left);
      right_.publish(pair.right);
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }

  ros::NodeHandle node_;
  ros::Publisher left_, right_, left_info_, right_info_;
  std::atomic<bool> done_{false};
  std::thread thread_;
};

/// CPU time of a node's process so far [s].
double cpuTime_s(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, uri;
  request[0] = ros::this_node::getName();
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, response, uri, false)) return -1;
  std::string host;
  uint32_t port = 0;
  ros::network::splitURI(uri, host, port);
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller, answer;
  caller[0] = ros::this_node::getName();
  if (!client.execute("getPid", caller, answer)) return -1;
  std::ifstream file("/proc/" + std::to_string(static_cast<int>(answer[2])) + "/stat");
  std::string text;
  std::getline(file, text);
  // Fields 14 and 15. The second field, the name, may contain blanks and ends with the last
  // bracket.
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  std::string skipped;
  for (int i = 3; i < 14; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

double cpuShare(const std::string& node, double seconds) {
  const double before_s = cpuTime_s(node);
  const auto begin = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
  return (cpuTime_s(node) - before_s) / passed.count();
}

class OnDemand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    for (const char* name : {"/stereo/ego_motion", "/stereo/disparity", "/stereo/moving_objects",
                             "/depth_only/disparity", "/navigation/ego_motion"})
      ASSERT_TRUE(ros::service::waitForService(std::string(name) + "/reset", 60000)) << name;
  }

  bool isAwake(const std::string& nodelet) const {
    return !diagnostics_.says(nodelet, "asleep") && !diagnostics_.of(nodelet).message.empty();
  }
  bool allAsleep(const Driver& driver) const {
    return eventually([&] { return driver.subscribers() == 0; }, 10);
  }

  /// Subscribes until `right` accepts a message, which must arrive soon. The driver must be asleep
  /// before and afterwards.
  template <class Message>
  testing::AssertionResult wakes(Driver& driver, const std::string& topic,
                                 const std::vector<std::string>& awake,
                                 const std::vector<std::string>& asleep,
                                 const std::function<bool(const Message&)>& right) {
    const ros::NodeHandle node;
    bool came = false;
    for (int attempt = 0; attempt < kAttempts && !came; ++attempt) {
      if (!allAsleep(driver))
        return testing::AssertionFailure() << driver.subscribers() << " subscriptions are left";
      Recorder<Message> recorder(node, topic);
      came = eventually(
          [&] {
            for (const auto& message : recorder.messages())
              if (right(*message)) return true;
            return false;
          },
          kSoon_s);
      if (!came) continue;
      // Diagnostics are published once per second.
      for (const std::string& nodelet : awake)
        if (!eventually([&] { return isAwake(nodelet); }, 5))
          return testing::AssertionFailure()
                 << nodelet << " sleeps while " << topic << " is wanted";
      for (const std::string& nodelet : asleep)
        if (isAwake(nodelet))
          return testing::AssertionFailure() << nodelet << " is awake for " << topic;
    }
    if (!came) return testing::AssertionFailure() << topic << " does not come soon";
    if (!allAsleep(driver))
      return testing::AssertionFailure() << driver.subscribers() << " subscriptions stay";
    return testing::AssertionSuccess();
  }

  DiagnosticsRecorder diagnostics_{ros::NodeHandle()};
};

size_t knownPixels(const stereo_msgs::DisparityImage& disparity) {
  size_t known = 0;
  for (size_t i = 0; i < disparity.image.data.size(); i += sizeof(float)) {
    float d;
    std::memcpy(&d, &disparity.image.data[i], sizeof(d));
    known += d >= disparity.min_disparity;
  }
  return known;
}

constexpr size_t kHalf = StreetCamera::kWidth * StreetCamera::kHeight / 2;

const char* const kEgoMotion = "stereo/ego_motion";
const char* const kDisparity = "stereo/disparity";
const char* const kMovingObjects = "stereo/moving_objects";

TEST_F(OnDemand, nobody_listens_nobody_works) {
  Driver driver("/stereo");
  ASSERT_TRUE(eventually([&] { return diagnostics_.says(kMovingObjects, "asleep"); }, 10));
  ASSERT_TRUE(allAsleep(driver));
  const double asleep = cpuShare("/stereo/predictive_stereo_manager", 4);
  EXPECT_EQ(driver.subscribers(), 0u);
  for (const char* nodelet : {kEgoMotion, kDisparity, kMovingObjects})
    EXPECT_TRUE(eventually([&] { return diagnostics_.says(nodelet, "asleep: nobody"); }, 5))
        << nodelet;

  Recorder<MovingObjectArray> objects(ros::NodeHandle(), "/stereo/moving_objects");
  ASSERT_TRUE(eventually([&] { return objects.count() > 2; }));
  const double awake = cpuShare("/stereo/predictive_stereo_manager", 4);
  std::cout << "CPU: asleep " << 100 * asleep << " %, awake " << 100 * awake << " %\n";
  RecordProperty("asleep_percent", std::to_string(100 * asleep));
  RecordProperty("awake_percent", std::to_string(100 * awake));
  EXPECT_LT(asleep, 0.03);
  EXPECT_GT(awake, 5 * asleep);
}

TEST_F(OnDemand, who_comes_wakes_what_he_needs) {
  Driver driver("/stereo");
  // The odometry needs no other nodelet; frames after the first one have a speed.
  EXPECT_TRUE((wakes<nav_msgs::Odometry>(
      driver, "/stereo/odometry", {kEgoMotion}, {kDisparity, kMovingObjects},
      [&](const nav_msgs::Odometry& odometry) {
        const double step_m =
            (street().T_world_base(0).translation() - street().T_world_base(1).translation())
                .norm();
        return odometry.twist.covariance[0] < 1 &&
               std::abs(std::abs(odometry.twist.twist.linear.z) - step_m / 0.1) <
                   0.1 * step_m / 0.1;
      })));
  // Disparity needs the motion, and the mask of moving objects.
  const auto predicted = [](const stereo_msgs::DisparityImage& disparity) {
    return knownPixels(disparity) > kHalf;
  };
  for (const char* topic : {"/stereo/disparity", "/stereo/predicted_disparity"})
    EXPECT_TRUE((
        wakes<stereo_msgs::DisparityImage>(driver, topic, {kEgoMotion, kDisparity}, {}, predicted)))
        << topic;
  EXPECT_TRUE((wakes<MovingObjectArray>(driver, "/stereo/moving_objects",
                                        {kEgoMotion, kDisparity, kMovingObjects}, {},
                                        [](const auto&) { return true; })));
}

TEST_F(OnDemand, every_output_wakes_and_lets_sleep) {
  Driver driver("/stereo");
  const ros::V_string topics = {"odometry/pose",
                                "odometry/row_alignment",
                                "disparity_variance",
                                "measured_disparity",
                                "measured_variance",
                                "predicted_variance",
                                "disparity/image",
                                "disparity/color",
                                "disparity/standard_deviation",
                                "search_range",
                                "depth/image_rect",
                                "depth/camera_info",
                                "points2",
                                "points2_static",
                                "row_alignment",
                                "moving_objects/mask",
                                "moving_objects/residual",
                                "moving_objects/markers",
                                "moving_objects/image"};
  for (const std::string& topic : topics) {
    EXPECT_TRUE(allAsleep(driver)) << "before " << topic;
    std::atomic<int> count{0};
    ros::Subscriber subscriber = ros::NodeHandle().subscribe<topic_tools::ShapeShifter>(
        "/stereo/" + topic, 5,
        boost::function<void(const topic_tools::ShapeShifter::ConstPtr&)>(
            [&](const topic_tools::ShapeShifter::ConstPtr&) { ++count; }));
    EXPECT_TRUE(eventually([&] { return count > 1; }, 5)) << topic;
    subscriber.shutdown();
  }
  EXPECT_TRUE(allAsleep(driver));
}

// MovingObjects needs two more topics for it. Its objects go on.
TEST_F(OnDemand, the_residual_may_be_asked_for_at_any_time) {
  Driver driver("/stereo");
  ros::NodeHandle node;
  const Recorder<MovingObjectArray> objects(node, "/stereo/moving_objects");
  const ros::Publisher predicted =
      node.advertise<sensor_msgs::Image>("/stereo/predicted_variance", 1);
  const auto goOn = [&](bool with_predicted) {
    const size_t before = objects.count();
    return eventually([&] { return objects.count() > before + 3; }, 5) &&
           (predicted.getNumSubscribers() > 0) == with_predicted;
  };
  EXPECT_TRUE(eventually([&] { return objects.count() > 0; }));
  EXPECT_TRUE(goOn(false));
  {
    const Recorder<sensor_msgs::Image> residual(node, "/stereo/moving_objects/residual");
    EXPECT_TRUE(eventually([&] { return residual.count() > 3; }, 10));
    EXPECT_TRUE(goOn(true));
  }
  EXPECT_TRUE(eventually([&] { return goOn(false); }, 10));
}

// Disparity does not wait for nodelets that do not run.
TEST_F(OnDemand, depth_comes_without_the_other_two) {
  Driver driver("/depth_only");
  EXPECT_TRUE((wakes<sensor_msgs::Image>(
      driver, "/depth_only/depth/image_rect", {"depth_only/disparity"}, {},
      [](const sensor_msgs::Image& image) { return image.encoding == "32FC1"; })));
  ros::V_string nodes;
  ASSERT_TRUE(ros::master::getNodes(nodes));
  for (const char* absent : {"/depth_only/ego_motion", "/depth_only/moving_objects"})
    EXPECT_EQ(std::count(nodes.begin(), nodes.end(), absent), 0) << absent;
}

TEST_F(OnDemand, odometry_in_tf_does_not_sleep) {
  Driver driver("/navigation");
  EXPECT_TRUE(eventually([&] { return driver.subscribers() == 4; }, 10));
  std::atomic<int> transforms{0};
  const ros::Subscriber tf = ros::NodeHandle().subscribe<tf2_msgs::TFMessage>(
      "/tf", 10,
      boost::function<void(const tf2_msgs::TFMessageConstPtr&)>(
          [&](const tf2_msgs::TFMessageConstPtr& message) {
            for (const auto& transform : message->transforms)
              transforms += transform.header.frame_id == "navigation_odom";
          }));
  EXPECT_TRUE(eventually([&] { return transforms > 3; }, 10));
  for (const char* nodelet : {"navigation/disparity", "navigation/moving_objects"})
    EXPECT_TRUE(eventually([&] { return diagnostics_.says(nodelet, "asleep"); }, 10)) << nodelet;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "on_demand_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
