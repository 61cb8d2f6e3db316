/// dynamic_reconfigure: changes of parameters while the nodelets run.
#include <dynamic_reconfigure/ConfigDescription.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <rosgraph_msgs/Log.h>
#include <stereo_msgs/DisparityImage.h>

#include <cstdio>
#include <cstring>
#include <numeric>

#include "nodelet_fixture.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {
namespace {

using dynamic_reconfigure::Config;
using dynamic_reconfigure::Reconfigure;

template <class Value>
std::optional<Value> findIn(const Config& config, const std::string& name) {
  const auto search = [&](const auto& list) -> std::optional<Value> {
    for (const auto& item : list)
      if (item.name == name) return static_cast<Value>(item.value);
    return std::nullopt;
  };
  if constexpr (std::is_same_v<Value, std::string>)
    return search(config.strs);
  else if constexpr (std::is_same_v<Value, int>)
    return search(config.ints);
  else if constexpr (std::is_same_v<Value, bool>)
    return search(config.bools);
  else
    return search(config.doubles);
}

template <class List, class Value>
void add(List& list, const std::string& name, const Value& value) {
  list.emplace_back();
  list.back().name = name;
  list.back().value = value;
}

class LiveParamsTest : public NodeletTest {
 protected:
  LiveParamsTest() : log_(ros::NodeHandle(), "/rosout"), extrinsic_(street().extrinsic()) {
    // Without a motion there is no prediction; under a sanitizer the motion takes its time.
    for (const char* nodelet : {"Disparity", "MovingObjects"})
      setParam(nodelet, "transform_timeout", 5.0);
  }

  bool request(const std::string& nodelet, Reconfigure& call) {
    const std::string service = ns_ + "/" + nodelet + "/set_parameters";
    EXPECT_TRUE(ros::service::waitForService(service, ros::Duration(10)));
    return ros::service::call(service, call);
  }
  bool logSays(const std::string& text) {
    return eventually(
        [&] {
          for (const auto& message : log_.messages())
            if (message->msg.find(text) != std::string::npos) return true;
          return false;
        },
        5);
  }
  /// Runs a shell command; returns its exit status and its output.
  int shell(const std::string& command, std::string& output) {
    FILE* pipe = popen((command + " 2>&1").c_str(), "r");
    for (int c; (c = fgetc(pipe)) != EOF;) output.push_back(static_cast<char>(c));
    return pclose(pipe);
  }

  Recorder<rosgraph_msgs::Log> log_;
  StaticTransform extrinsic_;
};

double meanOf16Bit(const sensor_msgs::Image& image) {
  const auto* values = reinterpret_cast<const uint16_t*>(image.data.data());
  const size_t count = image.data.size() / sizeof(uint16_t);
  return std::accumulate(values, values + count, 0.0) / static_cast<double>(count);
}

size_t knownPixels(const stereo_msgs::DisparityImage& disparity) {
  const auto* values = reinterpret_cast<const float*>(disparity.image.data.data());
  return static_cast<size_t>(std::count_if(values,
                                           values + disparity.image.data.size() / sizeof(float),
                                           [&](float d) { return d >= disparity.min_disparity; }));
}

TEST_F(LiveParamsTest, matching_changes_between_two_frames_and_the_past_is_kept) {
  load("EgoMotion");
  load("Disparity");
  Recorder<sensor_msgs::Image> width(node_, "search_range");
  Recorder<stereo_msgs::DisparityImage> predicted(node_, "predicted_disparity");
  ASSERT_TRUE(player_.waitForSubscribers());
  const auto play = [&](int index) {
    player_.publish(street().pair(index));
    return eventually([&] { return width.at(street().stamp(index)) != nullptr; }, 10);
  };
  for (int index = 0; index < 4; ++index) ASSERT_TRUE(play(index));
  EXPECT_LT(meanOf16Bit(*width.last()), 100);
  const size_t known = knownPixels(*predicted.last());
  EXPECT_GT(known, StreetCamera::kWidth * StreetCamera::kHeight / 4u);

  Reconfigure call;
  add(call.request.config.strs, "search/scheme", "full");
  ASSERT_TRUE(request("Disparity", call));
  EXPECT_EQ(findIn<std::string>(call.response.config, "search/scheme"), "full");
  EXPECT_EQ(findIn<int>(call.response.config, "matcher/p2"), MatcherParams().p2);
  ASSERT_TRUE(play(4));
  EXPECT_EQ(meanOf16Bit(*width.last()), 128);
  EXPECT_GT(knownPixels(*predicted.last()), known / 2);

  // The past has the old range.
  Reconfigure range;
  add(range.request.config.ints, "matcher/range/count", 64);
  ASSERT_TRUE(request("Disparity", range));
  ASSERT_TRUE(play(5));
  EXPECT_EQ(meanOf16Bit(*width.last()), 64);
  EXPECT_EQ(predicted.last()->max_disparity, 63);
  EXPECT_EQ(knownPixels(*predicted.last()), 0u);
}

TEST_F(LiveParamsTest, what_is_not_allowed_changes_nothing_and_the_log_says_why) {
  load("Disparity");
  Recorder<rosgraph_msgs::Log>& log = log_;
  ASSERT_TRUE(eventually([&] { return log.connected(); }));
  Reconfigure too_large;
  add(too_large.request.config.ints, "matcher/p2", 90);
  add(too_large.request.config.ints, "matcher/p1", 500);
  EXPECT_FALSE(request("Disparity", too_large));
  EXPECT_TRUE(logSays(ns_ + "/Disparity: nothing is reconfigured: matcher/p1 = 500: must be within "
                            "[1, 200]"));
  Reconfigure together;
  add(together.request.config.ints, "matcher/p1", 80);
  EXPECT_FALSE(request("Disparity", together));
  EXPECT_TRUE(logSays("p2 = 70: must be larger than p1 = 80"));
  Reconfigure unknown;
  add(unknown.request.config.ints, "matcher/p3", 80);
  EXPECT_FALSE(request("Disparity", unknown));
  EXPECT_TRUE(logSays("unknown parameter matcher/p3; did you mean matcher/p1?"));
  Reconfigure choice;
  add(choice.request.config.strs, "matcher/paths", "all_9");
  EXPECT_FALSE(request("Disparity", choice));
  EXPECT_TRUE(logSays("matcher/paths = all_9: must be one of straight_4 | diagonal_4 | all_8"));

  Reconfigure nothing;
  ASSERT_TRUE(request("Disparity", nothing));
  EXPECT_EQ(findIn<int>(nothing.response.config, "matcher/p1"), MatcherParams().p1);
  EXPECT_EQ(findIn<int>(nothing.response.config, "matcher/p2"), MatcherParams().p2);
}

TEST_F(LiveParamsTest, odometry_follows_fewer_features) {
  load("EgoMotion");
  Recorder<nav_msgs::Odometry> odometry(node_, "odometry");
  ASSERT_TRUE(player_.waitForSubscribers());
  Reconfigure few, call;
  add(few.request.config.ints, "features", 60);
  ASSERT_TRUE(request("EgoMotion", few));
  add(call.request.config.doubles, "disparity_jitter_px", 0.1);
  for (int index = 0; index < 5; ++index) {
    if (index == 2) {
      ASSERT_TRUE(request("EgoMotion", call));
    }
    player_.publish(street().pair(index));
    ASSERT_TRUE(eventually([&] { return odometry.at(street().stamp(index)) != nullptr; }, 10));
    if (index > 0) {
      EXPECT_GT(odometry.last()->twist.twist.linear.x, 1) << "the past is lost in frame " << index;
    }
  }
  ASSERT_TRUE(eventually([&] { return !value("EgoMotion", "features").empty(); }));
  // At most twice the parameter if the whole image has texture; about 225 by default.
  EXPECT_LE(std::stoi(value("EgoMotion", "features")), 120);
}

TEST_F(LiveParamsTest, detection_changes_its_thresholds) {
  setParam("MovingObjects", "scheme", "paper");
  load("EgoMotion");
  load("Disparity");
  load("MovingObjects");
  Recorder<MovingObjectArray> objects(node_, "moving_objects");
  ASSERT_TRUE(player_.waitForSubscribers());
  const auto play = [&](int index) {
    player_.publish(street().pair(index));
    return eventually([&] { return objects.at(street().stamp(index)) != nullptr; }, 10);
  };
  Reconfigure scheme, nothing;
  add(scheme.request.config.strs, "scheme", "default");
  EXPECT_FALSE(request("MovingObjects", scheme)) << "the inputs depend on it";
  add(nothing.request.config.doubles, "paper/min_mean_difference_px", 256.0);
  ASSERT_TRUE(request("MovingObjects", nothing));
  for (int index = 0; index < 4; ++index) ASSERT_TRUE(play(index));
  EXPECT_EQ(objects.last()->objects.size(), 0u);
  Reconfigure everything;
  add(everything.request.config.doubles, "paper/min_mean_difference_px", 0.01);
  ASSERT_TRUE(request("MovingObjects", everything));
  ASSERT_TRUE(play(4));
  EXPECT_GT(objects.last()->objects.size(), 0u);
}

TEST_F(LiveParamsTest, a_nodelet_that_is_loaded_again_goes_on_with_what_was_set) {
  setParam("Disparity", "min_support", 3);
  load("Disparity");
  Reconfigure call;
  add(call.request.config.ints, "matcher/p1", 7);
  ASSERT_TRUE(request("Disparity", call));
  EXPECT_EQ(findIn<int>(call.response.config, "min_support"), 3);
  ASSERT_TRUE(loader_->unload(ns_ + "/Disparity"));
  // The calls below must not reach the server that is ending.
  ASSERT_TRUE(
      eventually([&] { return !ros::service::exists(ns_ + "/Disparity/set_parameters", false); }));
  load("Disparity");
  Reconfigure nothing;
  ASSERT_TRUE(request("Disparity", nothing));
  EXPECT_EQ(findIn<int>(nothing.response.config, "matcher/p1"), 7);
}

TEST_F(LiveParamsTest, a_section_that_no_nodelet_reads_is_told) {
  ros::param::set(ns_ + "/predictive_stereo_config/disparity/min_support", 3);
  ros::param::set(ns_ + "/predictive_stereo_config/dispairty/min_support", 3);
  ASSERT_TRUE(eventually([&] { return log_.connected(); }));
  load("Disparity");
  EXPECT_TRUE(logSays("config has 'dispairty', which no nodelet reads"));
  EXPECT_FALSE(logSays("config has 'disparity'"));
}

TEST_F(LiveParamsTest, rectify_tells_a_name_that_it_does_not_read) {
  setParam("Rectify", "queue_size", 20);
  ASSERT_TRUE(eventually([&] { return log_.connected(); }));
  load("Rectify");
  EXPECT_TRUE(logSays("unknown parameter " + ns_ + "/Rectify/queue_size"));
}

TEST_F(LiveParamsTest, all_three_describe_themselves) {
  for (const char* nodelet : {"EgoMotion", "Disparity", "MovingObjects"}) {
    load(nodelet);
    std::shared_ptr<const dynamic_reconfigure::ConfigDescription> description;
    const auto subscriber = node_.subscribe<dynamic_reconfigure::ConfigDescription>(
        std::string(nodelet) + "/parameter_descriptions", 1,
        [&](const boost::shared_ptr<const dynamic_reconfigure::ConfigDescription>& message) {
          std::atomic_store(
              &description,
              std::make_shared<const dynamic_reconfigure::ConfigDescription>(*message));
        });
    ASSERT_TRUE(eventually([&] { return std::atomic_load(&description) != nullptr; })) << nodelet;
    size_t parameters = 0;
    for (const auto& group : description->groups) {
      parameters += group.parameters.size();
      for (const auto& parameter : group.parameters) {
        if (parameter.type == "double") {
          EXPECT_LT(*findIn<double>(description->min, parameter.name),
                    *findIn<double>(description->max, parameter.name));
        } else if (parameter.type == "int") {
          EXPECT_LT(*findIn<int>(description->min, parameter.name),
                    *findIn<int>(description->max, parameter.name));
        }
      }
    }
    EXPECT_GT(parameters, 5u);
    if (nodelet == std::string("Disparity")) {
      EXPECT_EQ(findIn<int>(description->max, "min_support"), 25);
      EXPECT_EQ(findIn<double>(description->dflt, "correction/gate_sigma"),
                CorrectionParams().gate_sigma);
    }
  }
}

// The client of dynamic_reconfigure, like a user.
TEST_F(LiveParamsTest, dynparam_works) {
  load("Disparity");
  // Another python3 in PATH may lack the ROS packages.
  const std::string dynparam = "PATH=/usr/bin:$PATH rosrun dynamic_reconfigure dynparam ",
                    nodelet = ns_ + "/Disparity";
  std::string output;
  EXPECT_EQ(shell(dynparam + "list", output), 0);
  EXPECT_NE(output.find(nodelet), std::string::npos) << output;
  EXPECT_EQ(shell(dynparam + "set " + nodelet +
                      " \"{matcher/paths: all_8, correction/gate_sigma: 4, row_alignment/enabled: "
                      "false, min_support: 12}\"",
                  output),
            0)
      << output;
  Reconfigure now;
  ASSERT_TRUE(request("Disparity", now));
  EXPECT_EQ(findIn<std::string>(now.response.config, "matcher/paths"), "all_8");
  EXPECT_EQ(findIn<double>(now.response.config, "correction/gate_sigma"), 4.0);
  EXPECT_EQ(findIn<bool>(now.response.config, "row_alignment/enabled"), false);
  EXPECT_EQ(findIn<int>(now.response.config, "min_support"), 12);

  output.clear();
  EXPECT_EQ(shell(dynparam + "get " + nodelet, output), 0);
  EXPECT_NE(output.find("'matcher/paths': 'all_8'"), std::string::npos) << output;
  output.clear();
  EXPECT_NE(shell(dynparam + "set " + nodelet + " min_support 26", output), 0);
  EXPECT_NE(output.find("service call failed"), std::string::npos) << output;
  EXPECT_TRUE(logSays("min_support = 26: must be within [0, 25]"));
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_params_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
