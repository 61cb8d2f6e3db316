#pragma once

#include <atomic>
#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <vector>

namespace predictive_stereo {

/// Recycles messages after every subscriber has released them. So publishing without a copy does
/// not allocate (and page in) megabytes per frame.
template <class Message>
class MessagePool {
 public:
  /// A message without other owners. Its fields have the values of the last use.
  boost::shared_ptr<Message> take() {
    for (boost::shared_ptr<Message>& message : messages_) {
      if (message.use_count() != 1) continue;
      // Pairs with the release of the last subscriber's reference: its reads happen before.
      std::atomic_thread_fence(std::memory_order_acquire);
      return message;
    }
    auto message = boost::make_shared<Message>();
    if (messages_.size() < kLargest) messages_.push_back(message);
    return message;
  }

 private:
  // More messages are in use only if a subscriber keeps many of them. The pool does not keep these.
  static constexpr size_t kLargest = 16;
  std::vector<boost::shared_ptr<Message>> messages_;
};

}  // namespace predictive_stereo
