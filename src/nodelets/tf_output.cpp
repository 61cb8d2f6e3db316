#include "nodelets/tf_output.h"

#include <ros/master.h>
#include <tf2_msgs/TFMessage.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <set>
#include <utility>

namespace predictive_stereo {
namespace {

// Frame ids in tf2 have no leading slash, but some publishers still add one.
std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

constexpr double kFirstWithin_s = 0.5;  // rivals are assumed to publish at 2 Hz or more

// Whether another node publishes on the topic.
bool othersPublish(const std::string& topic) {
  XmlRpc::XmlRpcValue request(ros::this_node::getName()), response, state;
  return ros::master::execute("getSystemState", request, response, state, false) &&
         hasOtherPublisher(state, topic, ros::this_node::getName());
}

}  // namespace

bool hasOtherPublisher(XmlRpc::XmlRpcValue system_state, const std::string& topic,
                       const std::string& node) try {
  XmlRpc::XmlRpcValue& publishers = system_state[0];
  for (int i = 0; i < publishers.size(); ++i) {
    if (static_cast<std::string>(publishers[i][0]) != topic) continue;
    for (int j = 0; j < publishers[i][1].size(); ++j)
      if (static_cast<std::string>(publishers[i][1][j]) != node) return true;
  }
  return false;
} catch (const XmlRpc::XmlRpcException&) {  // is no std::exception
  return true;
}

void TfRivals::addOwnTransform(const geometry_msgs::TransformStamped& transform) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ours_.push_back(transform);
  if (ours_.size() > kRemembered) ours_.pop_front();
}

void TfRivals::addTransform(const geometry_msgs::TransformStamped& transform,
                            const std::string& publisher, bool is_static) {
  const std::lock_guard<std::mutex> lock(mutex_);
  // Backwards, because the newest ones are at the end.
  if (!is_static && std::find(ours_.rbegin(), ours_.rend(), transform) != ours_.rend()) return;
  rivals_[withoutSlash(transform.child_frame_id)] = {
      publisher, withoutSlash(transform.header.frame_id), is_static};
}

std::optional<TfRivals::Rival> TfRivals::rivalOf(const std::string& frame) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto rival = rivals_.find(withoutSlash(frame));
  if (rival == rivals_.end()) return std::nullopt;
  return rival->second;
}

std::string TfRivals::reasonNotToMove(const std::string& frame) const {
  const std::optional<Rival> rival = rivalOf(frame);
  if (!rival) return "";
  const std::string silent = ": tf is not published from here, as a frame has one parent only. ";
  if (!rival->is_static)
    return "tf: " + rival->publisher + " already moves '" + frame + "' in '" + rival->parent + "'" +
           silent + "To use that motion, set publish_tf to false and odom_frame to '" +
           rival->parent + "'; to use this one, stop the other and restart this nodelet";
  // The robot's frame is the root of the static frames.
  std::string root = rival->parent;
  std::set<std::string> seen;
  for (auto above = rivalOf(root); above && above->is_static && seen.insert(root).second;
       above = rivalOf(root))
    root = above->parent;
  return "tf: " + rival->publisher + " has '" + frame + "' fixed to '" + rival->parent + "'" +
         silent + "Set base_frame to '" + root + "', or publish_tf to false";
}

void TfOutput::start(ros::NodeHandle& node) {
  listening_since_ = std::chrono::steady_clock::now();
  publisher_ = node.advertise<tf2_msgs::TFMessage>("/tf", 100);
}

void TfOutput::publish(const geometry_msgs::TransformStamped& transform, Health& health,
                       Arrivals& arrivals) {
  if (!mayPublish(transform.child_frame_id, health, arrivals)) return;
  rivals_.addOwnTransform(transform);
  tf2_msgs::TFMessagePtr tf = boost::make_shared<tf2_msgs::TFMessage>();
  tf->transforms.push_back(transform);
  publisher_.publish(tf);
}

bool TfOutput::mayPublish(const std::string& frame, Health& health, Arrivals& arrivals) {
  if (yielded_) return false;
  if (!std::exchange(asked_, true) && othersPublish(publisher_.getTopic())) {
    const std::chrono::duration<double> listened =
        std::chrono::steady_clock::now() - listening_since_;
    arrivals.waitFor(kFirstWithin_s - listened.count(),
                     [&] { return rivals_.rivalOf(frame).has_value(); });
  }
  const std::string objection = rivals_.reasonNotToMove(frame);
  if (objection.empty()) return true;
  yielded_ = true;
  health.problem("tf", objection);
  return false;
}

}  // namespace predictive_stereo
