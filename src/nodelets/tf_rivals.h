#pragma once

#include <geometry_msgs/TransformStamped.h>

#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace predictive_stereo {

/// Who else says in tf where a frame is. A frame can have one parent, and one who moves it: where
/// two do, a reader of tf gets the one and the other in turns.
///
/// Thread-safe.
class TfRivals {
 public:
  struct Rival {
    std::string publisher;  ///< node
    std::string parent;
    bool is_static = false;
  };

  /// To be called before this transform is published: it will be heard, and is no rival's.
  void addOwnTransform(const geometry_msgs::TransformStamped& transform);

  /// A transform that tf has, of anybody.
  void addTransform(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
                    bool is_static);

  /// The other publisher that was heard last; none: nobody else publishes this frame.
  std::optional<Rival> rivalOf(const std::string& frame) const;

  /// Why this frame must not be moved in tf by us, and what to do about it; empty: it may.
  std::string reasonNotToMove(const std::string& frame) const;

 private:
  static constexpr size_t kRemembered = 1000;  // of ours; they come back within milliseconds

  mutable std::mutex mutex_;
  std::deque<geometry_msgs::TransformStamped> ours_;
  std::map<std::string, Rival> rivals_;  // by child
};

}  // namespace predictive_stereo
