#include "tools/live_load.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <nav_msgs/Odometry.h>
#include <nodelet/loader.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <stereo_msgs/DisparityImage.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/make_shared.hpp>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "params/param_table.h"
#include "tools/stage_table.h"

namespace predictive_stereo {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kGiveUp_s = 20;  // for steps that should take milliseconds

int64_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  int64_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

bool waitUntil(const std::function<bool()>& condition) {
  const auto deadline = Clock::now() + std::chrono::duration<double>(kGiveUp_s);
  while (!condition()) {
    if (Clock::now() > deadline) return false;
    throwIfInterrupted();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

/// The subscriber: measures the latencies of frames and collects the diagnostics.
class Listener {
 public:
  /// Writes latencies to `frames`.
  Listener(const std::string& ns, std::vector<LoadedFrame>& frames)
      : frames_(frames), node_(ns), spinner_(1, &queue_) {
    node_.setCallbackQueue(&queue_);
    objects_ = node_.subscribe<MovingObjectArray>(
        "moving_objects", 100, [this](const MovingObjectArrayConstPtr& objects) {
          const auto now = Clock::now();
          const std::lock_guard<std::mutex> lock(mutex_);
          const auto sent = sent_.find(objects->header.stamp);
          if (sent == sent_.end()) return;
          const auto& [index, time] = sent->second;
          frames_[static_cast<size_t>(index)].latency_ms =
              std::chrono::duration<double, std::milli>(now - time).count();
          // Earlier frames are lost, because frames are published in order.
          sent_.erase(sent_.begin(), std::next(sent));
          last_output_ = now;
          changed_.notify_all();
        });
    disparity_ = node_.subscribe<stereo_msgs::DisparityImage>(
        "disparity", 10, [this](const stereo_msgs::DisparityImageConstPtr& disparity) {
          const std::lock_guard<std::mutex> lock(mutex_);
          last_disparity_ = disparity->header.stamp;
          changed_.notify_all();
        });
    odometry_ = node_.subscribe("odometry", 10, &Listener::ignore);
    diagnostics_ = node_.subscribe<diagnostic_msgs::DiagnosticArray>(
        "/diagnostics", 100, [this, ns](const diagnostic_msgs::DiagnosticArrayConstPtr& array) {
          const std::lock_guard<std::mutex> lock(mutex_);
          for (const auto& status : array->status) {
            if (status.name.find(ns.substr(1) + "/") == std::string::npos) continue;  // another's
            for (const auto& value : status.values) figures_[status.name][value.key] = value.value;
            ++reports_;
          }
        });
    spinner_.start();
  }
  ~Listener() { spinner_.stop(); }

  bool connected() const {
    return objects_.getNumPublishers() > 0 && disparity_.getNumPublishers() > 0 &&
           odometry_.getNumPublishers() > 0;
  }
  void recordSent(int index, ros::Time stamp, Clock::time_point time) {
    const std::lock_guard<std::mutex> lock(mutex_);
    sent_[stamp] = {index, time};
  }
  /// Waits until the next frame cannot displace another one: the disparity of the last frame and
  /// the moving objects of all earlier frames have arrived.
  bool waitForRoom() {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_for(lock, std::chrono::duration<double>(kGiveUp_s), [this] {
      return sent_.empty() || (sent_.size() == 1 && last_disparity_ == sent_.begin()->first);
    });
  }
  /// Waits until there was no output for a second and the diagnostics cover all frames.
  void waitForTheLast() {
    waitUntil([this] {
      const std::lock_guard<std::mutex> lock(mutex_);
      return sent_.empty() || Clock::now() - last_output_ > std::chrono::seconds(1);
    });
    const int before = reports_;
    waitUntil([&] { return reports_ >= before + 6; });  // two per nodelet
  }

  /// Value of `key` in the diagnostics of the nodelet whose status name contains `part`.
  int64_t count(const std::string& part, const std::string& key) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& [name, figures] : figures_) {
      const auto found = figures.find(key);
      if (name.find(part) != std::string::npos && found != figures.end())
        return std::stoll(found->second);
    }
    return 0;
  }

 private:
  static void ignore(const nav_msgs::OdometryConstPtr&) {}

  std::vector<LoadedFrame>& frames_;
  ros::NodeHandle node_;
  ros::CallbackQueue queue_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::map<ros::Time, std::pair<int, Clock::time_point>> sent_;  // no output yet
  ros::Time last_disparity_;
  Clock::time_point last_output_ = Clock::now();
  std::map<std::string, std::map<std::string, std::string>> figures_;
  std::atomic<int> reports_{0};
  ros::Subscriber objects_, disparity_, odometry_, diagnostics_;
  ros::AsyncSpinner spinner_;  // last: uses the members above
};

template <class Message>
boost::shared_ptr<Message> stamped(const boost::shared_ptr<const Message>& message,
                                   ros::Time stamp) {
  auto copy = boost::make_shared<Message>(*message);
  copy->header.stamp = stamp;
  return copy;
}

/// The nodelets' parameters; a later run of another program does not find them.
class OwnParams {
 public:
  OwnParams(const std::string& ns, AllNodeletParams params) : ns_(ns) {
    const ParamTable table(params);
    for (const auto& entry : table.entries()) ros::param::set(ns + "/" + entry.name, entry.get());
  }
  ~OwnParams() { ros::param::del(ns_); }
  OwnParams(const OwnParams&) = delete;
  OwnParams& operator=(const OwnParams&) = delete;

 private:
  const std::string ns_;
};

// Their tf is their own: that of a robot on the same master may fix the camera to another frame.
void loadNodelets(const std::string& ns, nodelet::Loader& loader) {
  const ros::M_string own_tf{{"/tf", ns + "/tf"}, {"/tf_static", ns + "/tf_static"}};
  for (const auto& [name, type] :
       {std::pair("ego_motion", "EgoMotion"), std::pair("disparity", "Disparity"),
        std::pair("moving_objects", "MovingObjects")})
    if (!loader.load(ns + "/" + name, std::string("predictive_stereo/") + type, own_tf, {}))
      throw std::runtime_error(std::string("the nodelet ") + type +
                               " cannot be loaded; source the workspace's setup.bash first");
}

}  // namespace

LoadSummary LiveLoadResult::summary(int first, int last) const {
  LoadSummary summary;
  summary.sent = last - first;
  std::vector<double> latencies_ms;
  for (int i = first; i < last; ++i) {
    const LoadedFrame& frame = frames[static_cast<size_t>(i)];
    if (!std::isnan(frame.latency_ms)) latencies_ms.push_back(frame.latency_ms);
    summary.resident_bytes = frame.resident_bytes;
  }
  summary.lost = summary.sent - static_cast<int>(latencies_ms.size());
  if (latencies_ms.empty()) return summary;
  summary.p50_ms = quantile(latencies_ms, 0.5);
  summary.p95_ms = quantile(latencies_ms, 0.95);
  summary.p99_ms = quantile(latencies_ms, 0.99);
  summary.max_ms = quantile(latencies_ms, 1);
  return summary;
}

double LiveLoadResult::reachedHz() const {
  int arrived = 0;
  double seconds = 0;
  for (const LoadedFrame& frame : frames) {
    const bool lost = std::isnan(frame.latency_ms);
    arrived += lost ? 0 : 1;
    seconds = std::max(seconds, frame.sent_s + (lost ? 0 : frame.latency_ms / 1000));
  }
  return arrived > 0 ? arrived / seconds : 0;
}

LiveLoad::LiveLoad(const std::string& path, const StereoTopicChoice& choice, int max_pairs) {
  rosbag::Bag bag;
  openBag(path, bag);
  const StereoTopics topics = findStereoTopics(bag, choice);
  RefusedMessages refused(
      [](const std::string& text) { std::cerr << "warning: " << text << "\n"; });
  SyncParams sync;
  sync.sync_tolerance = 0.02;
  BagPairs reader(topics, sync, refused);
  for (const auto& message : rosbag::View(bag, rosbag::TopicQuery(topics.all()))) {
    if (pairs() == max_pairs) break;
    for (const BagPair& found : reader.add(message)) pairs_.push_back(found.pair);
  }
  if (pairs_.size() < 2)
    throw std::runtime_error(path + ": has fewer than two stereo pairs. " +
                             reader.describeMismatch());
  period_ = (pairs_.back().left->header.stamp - pairs_.front().left->header.stamp) *
            (1.0 / (pairs() - 1));
}

cv::Size LiveLoad::size() const {
  return {static_cast<int>(pairs_[0].left->width), static_cast<int>(pairs_[0].left->height)};
}

StereoPair LiveLoad::pairAt(int index, ros::Time stamp) const {
  const int round = 2 * (pairs() - 1);
  const int place = index % round;
  const StereoPair& pair = pairs_[static_cast<size_t>(place < pairs() ? place : round - place)];
  return {stamped(pair.left, stamp), stamped(pair.right, stamp), stamped(pair.left_info, stamp),
          stamped(pair.right_info, stamp)};
}

LiveLoadResult LiveLoad::run(double rate_hz, int frames, const AllNodeletParams& given) {
  // A new namespace, so that late messages of another run are not received.
  const std::string ns = "/live_load_" + std::to_string(getpid()) + "_" + std::to_string(runs_++);
  AllNodeletParams params = given;
  params.ego_motion.base_frame = "";  // the camera, so no extrinsic is needed
  params.ego_motion.odom_frame = ns.substr(1) + "_odom";
  params.disparity.odom_frame = params.moving_objects.odom_frame = params.ego_motion.odom_frame;
  const OwnParams own_params(ns, params);
  LiveLoadResult result;
  result.frames.resize(static_cast<size_t>(frames));
  Listener listener(ns, result.frames);
  ros::NodeHandle node(ns);
  ros::Publisher left = node.advertise<sensor_msgs::Image>("left/image_rect", 20);
  ros::Publisher right = node.advertise<sensor_msgs::Image>("right/image_rect", 20);
  ros::Publisher left_info = node.advertise<sensor_msgs::CameraInfo>("left/camera_info", 20);
  ros::Publisher right_info = node.advertise<sensor_msgs::CameraInfo>("right/camera_info", 20);
  nodelet::Loader loader(false);
  loadNodelets(ns, loader);
  if (!waitUntil([&] {
        return left.getNumSubscribers() > 0 && right.getNumSubscribers() > 0 &&
               left_info.getNumSubscribers() > 0 && right_info.getNumSubscribers() > 0 &&
               listener.connected();
      }))
    throw std::runtime_error("the nodelets do not subscribe to the images; see the log above");
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until all are connected

  const ros::Time first = pairs_[0].left->header.stamp;
  const auto begin = Clock::now();
  for (int i = 0; i < frames; ++i) {
    throwIfInterrupted();
    const StereoPair pair = pairAt(i, first + period_ * i);
    if (rate_hz > 0)
      std::this_thread::sleep_until(begin + std::chrono::duration_cast<Clock::duration>(
                                                std::chrono::duration<double>(i / rate_hz)));
    else if (!listener.waitForRoom())
      throw std::runtime_error("the nodelets publish nothing for frame " + std::to_string(i - 1) +
                               "; see the log above");
    LoadedFrame& frame = result.frames[static_cast<size_t>(i)];
    const auto now = Clock::now();
    frame.sent_s = std::chrono::duration<double>(now - begin).count();
    listener.recordSent(i, pair.left->header.stamp, now);
    left_info.publish(pair.left_info);
    right_info.publish(pair.right_info);
    left.publish(pair.left);
    right.publish(pair.right);
    frame.resident_bytes = residentBytes();
  }
  listener.waitForTheLast();
  result.reported_losses = listener.count("/disparity", "dropped pairs") +
                           listener.count("/disparity", "unmatched left images") +
                           listener.count("/moving_objects", "dropped frames") +
                           listener.count("/moving_objects", "unmatched frames");
  return result;
}

}  // namespace predictive_stereo
