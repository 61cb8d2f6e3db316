/// What goes wrong around nodelets while they run: after each fault they are right again within
/// three frames, and memory does not grow. A watchdog says who stands.
#include <dynamic_reconfigure/Reconfigure.h>
#include <malloc.h>
#include <nav_msgs/Odometry.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/xmlrpc_manager.h>
#include <sensor_msgs/PointCloud2.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iostream>
#include <limits>
#include <thread>

#include "changed_pairs.h"
#include "nodelet_fixture.h"

namespace predictive_stereo {
namespace {

constexpr double kPeriod_s = 0.1;  // of the camera
constexpr const char* kNodelets[] = {"EgoMotion", "Disparity", "MovingObjects"};

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMemoryTells = false;  // mallinfo does not see their heap
#else
constexpr bool kMemoryTells = true;
#endif

/// Of the heap. The resident memory also has what malloc keeps: it varies by 10 MB. The heap varies
/// by what threads keep, 0.2 MB or so.
double allocatedMegabytes() {
#if __GLIBC_PREREQ(2, 33)
  const auto heap = mallinfo2();
#else
  const auto heap = mallinfo();
#endif
  return (static_cast<double>(heap.uordblks) + static_cast<double>(heap.hblkhd)) / 1e6;
}

// With the thread sanitizer, the images of the street alone take a minute.
#ifdef __SANITIZE_THREAD__
constexpr std::chrono::minutes kLongestStep(4);
#else
constexpr std::chrono::minutes kLongestStep(1);
#endif

/// Ends the process when a step takes too long, and says which one.
class Watchdog {
 public:
  void step(const std::string& name) {
    const std::lock_guard<std::mutex> lock(mutex_);
    step_ = name;
    begin_ = std::chrono::steady_clock::now();
  }

  ~Watchdog() {
    done_ = true;
    thread_.join();
  }

 private:
  void run() {
    while (!done_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      const std::lock_guard<std::mutex> lock(mutex_);
      if (std::chrono::steady_clock::now() - begin_ < kLongestStep) continue;
      std::cerr << "stands still: " << step_ << std::endl;
      std::abort();
    }
  }

  std::mutex mutex_;
  std::string step_ = "start";
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::atomic<bool> done_{false};
  std::thread thread_{[this] { run(); }};  // last: it uses all of the above
};

/// Calls something again and again, in a thread of its own.
class Meanwhile {
 public:
  Meanwhile(double period_s, std::function<void()> call)
      : thread_([this, period_s, call = std::move(call)] {
          while (!done_) {
            call();
            ros::WallDuration(period_s).sleep();
          }
        }) {}
  ~Meanwhile() {
    done_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> done_{false};
  std::thread thread_;
};

StereoPair halfAsHigh(StereoPair pair) {
  for (auto* image : {&pair.left, &pair.right}) {
    const auto half = copyOf(*image);
    half->height /= 2;
    half->data.resize(half->data.size() / 2);
    *image = half;
  }
  changeInfos(pair, [](sensor_msgs::CameraInfo& info) { info.height /= 2; });
  return pair;
}

class LiveFaults : public NodeletTest {
 protected:
  LiveFaults() { watchdog_.step(ns_); }

  static const StreetCamera& drive() {
    static const StreetCamera drive(20);
    return drive;
  }

  void start() {
    for (const char* nodelet : kNodelets) load(nodelet);
    ASSERT_TRUE(player_.waitForSubscribers());
    ASSERT_TRUE(eventually([&] { return disparity_.connected() && objects_.connected(); }));
    expectRight("start");
  }

  /// The next pair of the drive, which goes to and fro.
  StereoPair next() {
    ++frame_;
    stamp_ += ros::Duration(kPeriod_s);
    return withStamp(drive().pair(place(frame_)), stamp_);
  }
  int place(int frame) const {
    const int last = drive().frames() - 1, on_the_way = frame % (2 * last);
    return on_the_way <= last ? on_the_way : 2 * last - on_the_way;
  }

  /// Publishes the pair and waits for what all nodelets say of it.
  bool comesOutOfAll(const StereoPair& pair) {
    const ros::Time stamp = pair.left->header.stamp;
    player_.publish(pair);
    return eventually(
        [&] { return disparity_.at(stamp) && odometry_.at(stamp) && objects_.at(stamp); }, 10);
  }
  /// Publishes what may come out or not.
  void send(const StereoPair& pair) {
    const ros::Time stamp = pair.left->header.stamp;
    player_.publish(pair);
    eventually([&] { return disparity_.at(stamp) && odometry_.at(stamp) && objects_.at(stamp); },
               0.5);
  }
  std::string whoStands() {
    std::string text;
    for (const char* nodelet : kNodelets) {
      const bool stands = nodelet == std::string("EgoMotion")   ? !odometry_.at(stamp_)
                          : nodelet == std::string("Disparity") ? !disparity_.at(stamp_)
                                                                : !objects_.at(stamp_);
      if (stands)
        text += std::string(nodelet) + " gives nothing and says: " +
                diagnostics_.of(ns_.substr(1) + "/" + nodelet).message + "\n";
    }
    return text;
  }

  /// The third frame after a fault.
  void expectRight(const std::string& fault) {
    watchdog_.step(ns_ + ", after " + fault);
    // What is still on its way is no part of it.
    ros::WallDuration(0.2).sleep();
    bool came = false;
    for (int i = 0; i < 3; ++i) came = comesOutOfAll(next());
    ASSERT_TRUE(came) << fault << ": " << whoStands();
    EXPECT_GT(rightShare(*disparity_.at(stamp_)), 0.8) << fault;
    const double moved_m = (drive().truth(place(frame_)).T_world_cam.inverse() *
                            drive().truth(place(frame_ - 1)).T_world_cam)
                               .translation()
                               .norm();
    const auto& twist = odometry_.at(stamp_)->twist;
    EXPECT_LT(twist.covariance[0], 1) << fault << ": EgoMotion is lost";
    const auto& velocity = twist.twist.linear;
    EXPECT_NEAR(std::hypot(velocity.x, velocity.y, velocity.z), moved_m / kPeriod_s,
                0.1 * moved_m / kPeriod_s + 0.2)
        << fault;
    disparity_.clear();
    odometry_.clear();
    objects_.clear();
  }

  /// Of the pixels inside both images: whose disparity is known, and right to three pixels.
  double rightShare(const stereo_msgs::DisparityImage& disparity) const {
    const StreetFrame& truth = drive().truth(place(frame_));
    if (disparity.image.data.size() != truth.disparity_px.total() * sizeof(float)) return 0;
    cv::Mat1f found(truth.disparity_px.size());
    std::memcpy(found.data, disparity.image.data.data(), disparity.image.data.size());
    int seen = 0, right = 0;
    for (int y = 0; y < found.rows; ++y)
      for (int x = 0; x < found.cols; ++x) {
        const float d = truth.disparity_px(y, x);
        if (d == 0 || static_cast<float>(x) < d) continue;
        ++seen;
        right += found(y, x) >= disparity.min_disparity && std::abs(found(y, x) - d) < 3;
      }
    return static_cast<double>(right) / seen;
  }

  using Faults = std::vector<std::pair<std::string, std::function<void()>>>;
  /// Each fault six times. The first two rounds still fill pools. An image lost at each new start
  /// is 1.7 MB.
  void expectRightAfter(const Faults& faults) {
    double before = 0;
    for (int round = 0; round < 6; ++round) {
      for (const auto& [name, make] : faults) {
        watchdog_.step(ns_ + ", " + name);
        make();
        expectRight(name);
        if (HasFatalFailure()) return;
      }
      if (round == 1) before = allocatedMegabytes();
    }
    if (!kMemoryTells) return;
    EXPECT_LT(allocatedMegabytes(), before + 1) << "MB; before " << before;
  }

  int frame_ = 0;
  ros::Time stamp_ = ros::Time(1600000000);
  Watchdog watchdog_;
  StaticTransform extrinsic_{drive().extrinsic()};
  DisparityRecorder disparity_{node_, "disparity"};
  Recorder<nav_msgs::Odometry> odometry_{node_, "odometry"};
  Recorder<MovingObjectArray> objects_{node_, "moving_objects"};
};

TEST_F(LiveFaults, of_images_stamps_and_calibrations) {
  start();
  expectRightAfter({
      {"dropped images", [&] { frame_ += 3, stamp_ += ros::Duration(3 * kPeriod_s); }},
      {"doubled images",
       [&] {
         const StereoPair pair = next();
         player_.publish(pair);
         player_.publish(pair);
       }},
      {"reordered images",
       [&] {
         const StereoPair first = next(), second = next();
         player_.publish(second);
         player_.publish(first);
       }},
      {"late right images",
       [&] {
         std::vector<StereoPair> pairs;
         for (int i = 0; i < 4; ++i) {
           pairs.push_back(next());
           player_.publishLeft(pairs.back().left);
         }
         ros::WallDuration(0.2).sleep();
         for (const StereoPair& pair : pairs) player_.publish(pair);
       }},
      {"frozen images",
       [&] {
         const StereoPair pair = next();
         for (int i = 0; i < 15; ++i) {
           stamp_ += ros::Duration(kPeriod_s);
           send(withStamp(pair, stamp_));
         }
       }},
      {"torn images",
       [&] {
         for (int i = 0; i < 2; ++i) {
           StereoPair pair = next();
           const auto torn = copyOf(pair.left);
           const StereoPair other = drive().pair(place(frame_ + 3));
           std::copy_n(other.left->data.begin(), torn->data.size() / 2, torn->data.begin());
           pair.left = torn;
           send(pair);
         }
       }},
      {"data cut off",
       [&] {
         StereoPair pair = next();
         const auto cut = copyOf(pair.right);
         cut->data.resize(cut->data.size() / 2);
         pair.right = cut;
         player_.publish(pair);
       }},
      {"a minute without right images",
       [&] {
         for (int i = 0; i < 600; ++i) {
           player_.publishLeft(next().left);
           if (i % 20 == 0) ros::WallDuration(0.01).sleep();
         }
       }},
      {"a stamp of zero", [&] { player_.publish(withStamp(next(), ros::Time())); }},
      {"a stamp an hour ahead", [&] { send(withStamp(next(), stamp_ + ros::Duration(3600))); }},
      {"stamps that go back", [&] { stamp_ -= ros::Duration(5); }},
      {"another size", [&] { send(halfAsHigh(next())); }},
      {"another calibration",
       [&] {
         StereoPair pair = next();
         changeInfos(pair, [](sensor_msgs::CameraInfo& info) { info.P[0] *= 1.1; });
         send(pair);
       }},
      {"no calibration",
       [&] {
         StereoPair pair = next();
         changeInfos(pair, [](sensor_msgs::CameraInfo& info) { info.P.fill(0); });
         player_.publish(pair);
       }},
  });
}

// The motion comes from others: what EgoMotion publishes has no faults.
TEST_F(LiveFaults, of_tf) {
  setParam("EgoMotion", "publish_tf", false);
  for (const char* nodelet : {"Disparity", "MovingObjects"})
    setParam(nodelet, "odom_frame", "world_of_others");
  tf2_ros::TransformBroadcaster broadcaster;
  Eigen::Isometry3d jump = Eigen::Isometry3d::Identity();
  const auto sendPose = [&](const std::string& parent) {
    broadcaster.sendTransform(
        transformMsg(stamp_, parent, "base_link", jump * drive().T_world_base(place(frame_))));
  };
  // After a fault, poses come for all frames again.
  const auto good = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      const StereoPair pair = next();
      sendPose("world_of_others");
      comesOutOfAll(pair);
    }
  };
  const DisparityRecorder predicted(node_, "predicted_disparity");
  const auto expectPredicted = [&](const std::string& fault) {
    watchdog_.step(ns_ + ", after " + fault);
    good(3);
    ASSERT_TRUE(disparity_.at(stamp_) && objects_.at(stamp_)) << fault << ": " << whoStands();
    EXPECT_GT(rightShare(*disparity_.at(stamp_)), 0.8) << fault;
    EXPECT_GT(rightShare(*predicted.at(stamp_)), 0.4) << fault << ": is not predicted again";
  };
  for (const char* nodelet : kNodelets) load(nodelet);
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(eventually([&] { return disparity_.connected() && objects_.connected(); }));
  expectPredicted("start");
  const Faults faults = {
      {"no tf for a while", [&] { send(next()); }},
      {"late tf",
       [&] {
         player_.publish(next());
         ros::WallDuration(0.6).sleep();
         sendPose("world_of_others");
       }},
      {"a jump", [&] { jump.translate(Eigen::Vector3d(2, -1, 0.5)); }},
      {"a pose that is not a number",
       [&] {
         const Eigen::Isometry3d finite = jump;
         jump.translation().x() = std::nan("");
         good(1);
         jump = finite;
       }},
      {"a second parent",
       [&] {
         const StereoPair pair = next();
         sendPose("another_world");
         send(pair);
       }},
  };
  for (const auto& [name, make] : faults) {
    watchdog_.step(ns_ + ", " + name);
    make();
    expectPredicted(name);
    if (HasFatalFailure()) return;
  }
}

TEST_F(LiveFaults, of_subscribers_that_come_and_go_at_50_hz) {
  start();
  {
    const Meanwhile comings(0, [&] {
      const Recorder<sensor_msgs::PointCloud2> cloud(node_, "points2");
      const Recorder<sensor_msgs::Image> colour(node_, "disparity/color");
      const Recorder<sensor_msgs::Image> overlay(node_, "moving_objects/image");
      const Recorder<sensor_msgs::Image> mask(node_, "moving_objects/mask");
      const DisparityRecorder map(node_, "disparity");
      ros::WallDuration(1.0 / 50).sleep();
    });
    for (int i = 0; i < 40; ++i) EXPECT_TRUE(comesOutOfAll(next())) << i << ": " << whoStands();
  }
  expectRight("subscribers");
}

TEST_F(LiveFaults, of_nodelets_that_are_loaded_again_while_images_flow) {
  start();
  const int loads = ros::param::param("~loads", 20);
  {
    const Meanwhile camera(0.02, [&] { player_.publish(next()); });
    for (int i = 0; i < loads; ++i) {
      const std::string nodelet = kNodelets[i % 3];
      watchdog_.step("unloading " + nodelet + ", time " + std::to_string(i + 1));
      EXPECT_TRUE(loader_->unload(ns_ + "/" + nodelet)) << i;
      watchdog_.step("loading " + nodelet + ", time " + std::to_string(i + 1));
      load(nodelet);
    }
  }
  ASSERT_TRUE(player_.waitForSubscribers());
  ASSERT_TRUE(eventually([&] { return disparity_.connected() && objects_.connected(); }));
  expectRight("loading");
}

TEST_F(LiveFaults, of_parameters_that_change_at_20_hz) {
  start();
  std::atomic<int> calls{0}, wrong{0};
  {
    const Meanwhile user(1.0 / 20, [&] {
      const bool allowed = ++calls % 4 != 0;
      dynamic_reconfigure::Reconfigure change;
      change.request.config.ints.resize(1);
      change.request.config.ints[0].name = "matcher/p2";
      change.request.config.ints[0].value = allowed ? 70 + calls % 3 : 100000;
      wrong += ros::service::call(ns_ + "/Disparity/set_parameters", change) != allowed;
    });
    for (int i = 0; i < 40; ++i) EXPECT_TRUE(comesOutOfAll(next())) << i << ": " << whoStands();
    EXPECT_TRUE(eventually([&] { return calls > 20; }));
  }
  EXPECT_EQ(wrong, 0);
  expectRight("parameters");
}

// Also run where simulated time never comes (live_faults_no_clock.test).
TEST_F(LiveFaults, of_clocks) { start(); }

/// Process id of a node; 0: it does not run.
int pidOf(const std::string& name) {
  XmlRpc::XmlRpcValue request, answer, payload, reply;
  request[0] = ros::this_node::getName();
  request[1] = name;
  if (!ros::master::execute("lookupNode", request, answer, payload, false)) return 0;
  std::string host;
  uint32_t port = 0;
  if (!ros::network::splitURI(payload, host, port)) return 0;
  XmlRpc::XmlRpcClient client(host.c_str(), static_cast<int>(port), "/");
  XmlRpc::XmlRpcValue caller;
  caller[0] = ros::this_node::getName();
  if (!client.execute("getPid", caller, reply) || reply.size() < 3) return 0;
  return reply[2];
}

// The manager is a process of its own, which roslaunch starts again, and so its nodelets.
TEST(LiveFaultsOfManagers, a_killed_one_comes_back) {
  if (!ros::param::param("~manager", false)) GTEST_SKIP() << "no manager is started";
  const ros::NodeHandle node("/respawned");
  const StreetCamera drive(6);
  StereoPlayer player(node);
  const DisparityRecorder disparity(node, "disparity");
  ros::Time stamp(1600000000);
  const auto comesOut = [&] {
    const size_t before = disparity.count();
    const Meanwhile camera(kPeriod_s, [&] {
      stamp += ros::Duration(1);
      player.publish(withStamp(drive.pair(0), stamp));
    });
    return eventually([&] { return disparity.count() > before; });
  };
  ASSERT_TRUE(comesOut());
  const int pid = pidOf("/respawned/manager");
  ASSERT_GT(pid, 0);
  ASSERT_EQ(kill(pid, SIGKILL), 0);
  ASSERT_TRUE(eventually([&] { return kill(pid, 0) != 0; }));
  EXPECT_TRUE(comesOut());
  EXPECT_NE(pidOf("/respawned/manager"), pid);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_faults_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
