#include "nodelets/tf_rivals.h"

#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <set>

namespace predictive_stereo {
namespace {

// Frame ids in tf2 have no leading slash, but some publishers still add one.
std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
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

}  // namespace predictive_stereo
