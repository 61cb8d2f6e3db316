#pragma once

#include <map>
#include <set>
#include <string>

namespace predictive_stereo {

/// Frame ids in tf2 have no leading slash, but some publishers still add one.
inline std::string withoutSlash(const std::string& frame) {
  return !frame.empty() && frame[0] == '/' ? frame.substr(1) : frame;
}

/// Frames that static transforms fix to others. A frame must have one parent: only their root can
/// be moved by an odometry.
class FixedFrames {
 public:
  void add(const std::string& child, const std::string& parent) {
    parents_[withoutSlash(child)] = withoutSlash(parent);
  }

  /// The root of the static frames above this one; itself if it is fixed to none.
  std::string rootOf(std::string frame) const {
    frame = withoutSlash(frame);
    std::set<std::string> seen;  // a wrong tree may have a circle
    for (auto parent = parents_.find(frame); parent != parents_.end() && seen.insert(frame).second;
         parent = parents_.find(frame))
      frame = parent->second;
    return frame;
  }

 private:
  std::map<std::string, std::string> parents_;  // by child
};

}  // namespace predictive_stereo
