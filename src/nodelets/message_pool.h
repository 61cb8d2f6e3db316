#pragma once

#include <atomic>
#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <vector>

namespace predictive_stereo {

/// Hands out messages whose memory is used again once every subscriber has let go of them, so that
/// publishing without a copy does not allocate (and fault in) megabytes a frame.
template <class Message>
class MessagePool {
 public:
  /// A message without other owners; its fields are those of its last use.
  boost::shared_ptr<Message> take() {
    for (boost::shared_ptr<Message>& message : messages_) {
      if (message.use_count() != 1) continue;
      // Pairs with the release of the last subscriber's reference: its reads come first.
      std::atomic_thread_fence(std::memory_order_acquire);
      return message;
    }
    auto message = boost::make_shared<Message>();
    if (messages_.size() < kLargest) messages_.push_back(message);
    return message;
  }

 private:
  // More than this are only in flight when a subscriber hoards them; those are not ours to keep.
  static constexpr size_t kLargest = 16;
  std::vector<boost::shared_ptr<Message>> messages_;
};

}  // namespace predictive_stereo
