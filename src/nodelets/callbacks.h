/// Where ROS calls a nodelet: each subscription and service goes through Health::guard.
#pragma once

#include <ros/node_handle.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "nodelets/health.h"
#include "nodelets/message_checks.h"

namespace predictive_stereo {

/// Length of roscpp's queue per topic. It drops messages silently, so it is longer than a nodelet
/// needs: StampMatcher and FrameWorker drop messages as well, but count them.
constexpr uint32_t kRoscppQueue = 64;

/// May throw: see Health::guard.
template <class Message>
using Receiver = std::function<void(const boost::shared_ptr<const Message>&)>;

/// A callback for a topic, which refuses stamps (see objectionTo).
/// @param topic  resolved name.
template <class Message>
boost::function<void(const boost::shared_ptr<const Message>&)> guarded(
    Health& health, const std::string& topic, Receiver<Message> use,
    ZeroStamp zero = ZeroStamp::kRefused) {
  return [&health, topic, use = std::move(use),
          zero](const boost::shared_ptr<const Message>& message) {
    health.guard(topic, [&] {
      requireStamp(message->header.stamp, zero);
      use(message);
    });
  };
}

template <class Message>
ros::Subscriber subscribe(ros::NodeHandle& node, Health& health, const std::string& topic,
                          uint32_t queue, Receiver<Message> use,
                          ZeroStamp zero = ZeroStamp::kRefused) {
  return node.subscribe<Message>(
      topic, queue, guarded<Message>(health, node.resolveName(topic), std::move(use), zero),
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

/// @param serve  returns whether the service has done what was asked; may throw.
template <class Request, class Response>
ros::ServiceServer advertiseService(ros::NodeHandle& node, Health& health, const std::string& name,
                                    std::function<bool(Request&, Response&)> serve) {
  return node.advertiseService<Request, Response>(
      name, boost::function<bool(Request&, Response&)>(
                [&health, service = node.resolveName(name), serve = std::move(serve)](
                    Request& request, Response& response) {
                  bool done = false;
                  health.guard(service, [&] { done = serve(request, response); });
                  return done;
                }));
}

}  // namespace predictive_stereo
