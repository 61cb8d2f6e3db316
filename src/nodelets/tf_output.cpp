#include "nodelets/tf_output.h"

#include <ros/master.h>
#include <tf2_msgs/TFMessage.h>

#include <utility>

namespace predictive_stereo {
namespace {

constexpr double kFirstWithin_s = 0.5;  // rivals are assumed to publish at 2 Hz or more

// Whether another node publishes on the topic.
bool othersPublish(const std::string& topic) {
  XmlRpc::XmlRpcValue request(ros::this_node::getName()), response, state;
  return ros::master::execute("getSystemState", request, response, state, false) &&
         hasOtherPublisher(state, topic, ros::this_node::getName());
}

}  // namespace

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
  health.problem("tf", Health::Severity::kDegraded, objection);
  return false;
}

}  // namespace predictive_stereo
