#pragma once

#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <ros/ros.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <string>

#include "recorder.h"
#include "stereo_player.h"
#include "street_camera.h"

namespace predictive_stereo {

/// Runs nodelets in the process of the test, each test in a separate namespace.
class NodeletTest : public testing::Test {
 protected:
  NodeletTest()
      : ns_(std::string("/") + testing::UnitTest::GetInstance()->current_test_info()->name()),
        node_(ns_),
        loader_(std::make_unique<nodelet::Loader>(false)),
        diagnostics_(node_),
        player_(node_) {}

  /// @param nodelet  "EgoMotion", ...; also its name in the test's namespace.
  void load(const std::string& nodelet) {
    ASSERT_TRUE(loader_->load(ns_ + "/" + nodelet, "predictive_stereo/" + nodelet, {}, {}));
  }
  template <class Value>
  void setParam(const std::string& nodelet, const std::string& name, const Value& value) {
    ros::param::set(ns_ + "/" + nodelet + "/" + name, value);
  }
  /// Waits until the nodelet's diagnostics contain the text; fails if they do not.
  testing::AssertionResult says(const std::string& nodelet, const std::string& text) {
    if (eventually([&] { return diagnostics_.says(ns_.substr(1) + "/" + nodelet, text); }, 10))
      return testing::AssertionSuccess();
    return testing::AssertionFailure()
           << nodelet << " says: " << diagnostics_.of(ns_.substr(1) + "/" + nodelet).message;
  }
  int level(const std::string& nodelet) {
    return diagnostics_.of(ns_.substr(1) + "/" + nodelet).level;
  }
  std::string value(const std::string& nodelet, const std::string& key) {
    return diagnostics_.value(ns_.substr(1) + "/" + nodelet, key);
  }

  /// Publishes the pair and waits for its disparity.
  bool publishesDisparity(const StereoPair& pair, const DisparityRecorder& disparity) {
    player_.publish(pair);
    return eventually([&] { return disparity.at(pair.left->header.stamp) != nullptr; }, 10);
  }

  static const StreetCamera& street() {
    static const StreetCamera street(6);
    return street;
  }

  std::string ns_;
  ros::NodeHandle node_;
  std::unique_ptr<nodelet::Loader> loader_;
  DiagnosticsRecorder diagnostics_;
  StereoPlayer player_;
};

}  // namespace predictive_stereo
