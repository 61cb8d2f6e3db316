/// Other packages accept our topics. Their nodelets are those of Debian, loaded from their
/// libraries: Debian 12 has no plugin descriptions for them, so `nodelet load` and their own
/// programs do not find them.
#include <dlfcn.h>
#include <nodelet/nodelet.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/PointCloud2.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <class_loader/class_loader.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "nodelet_fixture.h"

namespace predictive_stereo {
namespace {

/// A program that runs until the end of the test.
class Program {
 public:
  explicit Program(const std::string& command) : pid_(fork()) {
    if (pid_ != 0) return;
    setpgid(0, 0);
    execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), nullptr);
    _exit(127);
  }
  ~Program() { stop(SIGKILL); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void stop(int signal) {
    if (pid_ <= 0) return;
    kill(-pid_, signal);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }

 private:
  pid_t pid_;
};

bool hasProgram(const std::string& name) {
  return std::system(("command -v " + name + " > /dev/null").c_str()) == 0;
}

class Neighbours : public NodeletTest {
 protected:
  Neighbours() : extrinsic_(street().extrinsic()) {
    char name[] = "/tmp/neighboursXXXXXX";
    folder_ = mkdtemp(name);
  }
  ~Neighbours() override {
    neighbours_.reset();
    std::system(("rm -rf " + folder_).c_str());
  }

  /// Loads a nodelet of another package; false: that package is not installed.
  bool loadNeighbour(const std::string& library, const std::string& type,
                     const nodelet::M_string& remappings) {
    for (const std::string& file : {"lib" + library + ".so.0d", "lib" + library + ".so"})
      if (!library_ && dlopen(file.c_str(), RTLD_LAZY))
        library_ = std::make_unique<class_loader::ClassLoader>(file);
    if (!library_) return false;
    neighbours_ = std::make_unique<nodelet::Loader>([this](const std::string& name) {
      const auto instance = library_->createInstance<nodelet::Nodelet>(name);
      return boost::shared_ptr<nodelet::Nodelet>(instance.get(), [instance](auto*) {});
    });
    nodelet::M_string resolved;
    for (const auto& [from, to] : remappings) resolved[ns_ + "/" + from] = ns_ + "/" + to;
    EXPECT_TRUE(neighbours_->load(ns_ + "/neighbour", type, resolved, {}));
    return true;
  }

  /// Publishes frames until the condition holds.
  bool play(const std::function<bool()>& condition) {
    EXPECT_TRUE(player_.waitForSubscribers());
    for (int round = 0; round < 3; ++round)
      for (int index = 0; index < street().frames(); ++index) {
        player_.publish(street().pair(index));
        if (eventually(condition, 0.5)) return true;
      }
    return eventually(condition, 5);
  }

  std::unique_ptr<class_loader::ClassLoader> library_;
  std::unique_ptr<nodelet::Loader> neighbours_;
  StaticTransform extrinsic_;
  std::string folder_;
};

cv::Mat3f points(const sensor_msgs::PointCloud2& cloud) {
  cv::Mat3f result(static_cast<int>(cloud.height), static_cast<int>(cloud.width));
  std::map<std::string, size_t> offsets;
  for (const auto& field : cloud.fields) offsets[field.name] = field.offset;
  for (int y = 0; y < result.rows; ++y)
    for (int x = 0; x < result.cols; ++x) {
      const uint8_t* point = &cloud.data[y * cloud.row_step + x * cloud.point_step];
      for (int i = 0; i < 3; ++i)
        std::memcpy(&result(y, x)[i], point + offsets.at(std::string(1, "xyz"[i])), sizeof(float));
    }
  return result;
}

/// Expects the same points in both clouds, except unknown ones.
void expectSameClouds(const sensor_msgs::PointCloud2& theirs,
                      const sensor_msgs::PointCloud2& ours) {
  EXPECT_EQ(theirs.header.frame_id, ours.header.frame_id);
  const cv::Mat3f a = points(theirs), b = points(ours);
  ASSERT_EQ(a.size(), b.size());
  int known = 0, different = 0;
  for (int y = 0; y < a.rows; ++y)
    for (int x = 0; x < a.cols; ++x) {
      const cv::Vec3f p = a(y, x), q = b(y, x);
      // Farther points are not compared, because of the rounding of their disparity.
      if (std::isfinite(q[2]) && q[2] > 500) continue;
      if (std::isfinite(q[2])) ++known;
      if (std::isfinite(p[2]) != std::isfinite(q[2]) ||
          (std::isfinite(q[2]) && cv::norm(p - q) > 1e-3 * cv::norm(q)))
        ++different;
    }
  EXPECT_GT(known, static_cast<int>(a.total() / 2));
  EXPECT_EQ(different, 0);
}

template <class First, class Second>
bool haveOneStamp(const Recorder<First>& first, const Recorder<Second>& second) {
  for (const auto& message : first.messages())
    if (second.at(message->header.stamp)) return true;
  return false;
}

void expectSameClouds(const Recorder<sensor_msgs::PointCloud2>& theirs,
                      const Recorder<sensor_msgs::PointCloud2>& ours) {
  for (const auto& message : theirs.messages())
    if (const auto partner = ours.at(message->header.stamp))
      return expectSameClouds(*message, *partner);
  FAIL() << theirs.count() << " clouds of theirs and " << ours.count() << " of ours share no stamp";
}

TEST_F(Neighbours, stereo_image_proc_makes_our_cloud) {
  if (!loadNeighbour("stereo_image_proc", "stereo_image_proc::PointCloud2Nodelet",
                     {{"left/image_rect_color", "left/image_rect"}, {"points2", "their_points"}}))
    GTEST_SKIP() << "stereo_image_proc is not installed";
  load("Disparity");
  Recorder<sensor_msgs::PointCloud2> theirs(node_, "their_points"), ours(node_, "points2");
  ASSERT_TRUE(play([&] { return haveOneStamp(theirs, ours); }));
  expectSameClouds(theirs, ours);
}

TEST_F(Neighbours, depth_image_proc_makes_our_cloud) {
  if (!loadNeighbour("depth_image_proc", "depth_image_proc::PointCloudXyzNodelet",
                     {{"image_rect", "depth/image_rect"}, {"points", "their_points"}}))
    GTEST_SKIP() << "depth_image_proc is not installed";
  load("Disparity");
  Recorder<sensor_msgs::PointCloud2> theirs(node_, "their_points"), ours(node_, "points2");
  ASSERT_TRUE(play([&] { return haveOneStamp(theirs, ours); }));
  expectSameClouds(theirs, ours);
}

TEST_F(Neighbours, disparity_view_shows_our_disparity) {
  if (!hasProgram("Xvfb") || !hasProgram("import"))
    GTEST_SKIP() << "Xvfb (xvfb) and import (imagemagick) are needed to look at a window";
  // Xvfb says which display it took as soon as it answers. It must not reset after a screenshot,
  // its last client, has left: this breaks the connection of the window that is about to open.
  const std::string said = folder_ + "/display";
  const Program screen("Xvfb -displayfd 3 -noreset -screen 0 800x600x24 3> " + said +
                       " 2> /dev/null");
  std::string display;
  ASSERT_TRUE(eventually(
      [&] { return static_cast<bool>(std::getline(std::ifstream(said), display)); }, 60));
  setenv("DISPLAY", (":" + display).c_str(), 1);
  const std::string shot = folder_ + "/shot.png";
  const auto colours = [&] {
    std::system(("import -window root " + shot + " 2> /dev/null").c_str());
    const cv::Mat3b picture = cv::imread(shot);
    std::set<std::tuple<int, int, int>> found;
    for (const cv::Vec3b& pixel : picture)
      found.emplace(pixel[0] / 16, pixel[1] / 16, pixel[2] / 16);
    return found.size();
  };
  if (!loadNeighbour("image_view", "image_view::DisparityNodelet", {{"image", "disparity"}}))
    GTEST_SKIP() << "image_view is not installed";
  load("Disparity");
  // A disparity palette has many colours; an empty window has a few greys.
  EXPECT_TRUE(play([&] { return colours() > 20; })) << colours() << " colours";
}

TEST_F(Neighbours, tf2_echo_follows_the_odometry) {
  load("EgoMotion");
  Recorder<nav_msgs::Odometry> odometry(node_, "odometry");
  const std::string output = folder_ + "/tf2_echo";
  // Noetic also has the program in tf2_ros, Debian 12 only here.
  if (std::system("rospack find tf2_tools > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "tf2_tools is not installed";
  const Program echo("rosrun tf2_tools echo.py -r 5 odom base_link > " + output + " 2>&1");
  std::string text;
  EXPECT_TRUE(play([&] {
    text.clear();
    if (FILE* file = std::fopen(output.c_str(), "r")) {
      for (int c; (c = std::fgetc(file)) != EOF;) text.push_back(static_cast<char>(c));
      std::fclose(file);
    }
    return text.find("- Translation: [") != std::string::npos;
  })) << text;
}

TEST_F(Neighbours, rosbag_record_records_everything) {
  load("EgoMotion");
  load("Disparity");
  load("MovingObjects");
  const std::string path = folder_ + "/recorded.bag";
  Program record("rosrun rosbag record -q -O " + path + " -e '" + ns_ + "/.*' 2> /dev/null");
  Recorder<sensor_msgs::PointCloud2> cloud(node_, "points2");
  const auto recorded = [&](const std::string& topic) {
    ros::V_string nodes;
    XmlRpc::XmlRpcValue request(ros::this_node::getName()), state, payload;
    if (!ros::master::execute("getSystemState", request, state, payload, false)) return false;
    for (int i = 0; i < payload[1].size(); ++i)
      if (payload[1][i][0] == ns_ + "/" + topic)
        for (int j = 0; j < payload[1][i][1].size(); ++j)
          if (std::string(payload[1][i][1][j]).find("record") != std::string::npos) return true;
    return false;
  };
  const std::set<std::string> topics = {
      "disparity",      "disparity_variance",      "odometry",      "moving_objects",
      "points2",        "depth/image_rect",        "search_range",  "moving_objects/markers",
      "row_alignment",  "moving_objects/residual", "odometry/pose", "disparity/color",
      "left/image_rect"};
  for (const std::string& topic : topics)
    ASSERT_TRUE(eventually([&] { return recorded(topic); }, 20)) << topic;
  ros::WallDuration(1).sleep();  // it connects shortly after its registration at the master
  ASSERT_TRUE(play([&] { return cloud.count() >= 4; }));
  ros::WallDuration(1).sleep();  // until its queues are empty
  record.stop(SIGINT);

  const rosbag::Bag bag(path);
  for (const std::string& topic : topics) {
    rosbag::View view(bag, rosbag::TopicQuery(ns_ + "/" + topic));
    EXPECT_GE(view.size(), 2u) << topic;
  }
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "neighbours_test");
  // Another python3 in PATH may lack the ROS packages.
  setenv("PATH", (std::string("/usr/bin:") + getenv("PATH")).c_str(), 1);
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
