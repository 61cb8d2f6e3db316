#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "tools/stereo_topics.h"

namespace predictive_stereo {

/// What became of a run of frames.
struct LiveLoadResult {
  int sent = 0;
  int processed = 0;  ///< whose moving objects were published
  double seconds = 0;
  std::vector<double> latency_ms;  ///< of those processed, but the first ones
  /// Frames lost, as the nodelets' diagnostics say; sent - processed where each loss is counted.
  int64_t reported_losses = 0;
  int64_t early_bytes = 0, late_bytes = 0;  ///< resident memory after 100 frames, and at the end

  int lost() const { return sent - processed; }
  double rate_hz() const { return seconds > 0 ? processed / seconds : 0; }
  double growth_percent() const {
    return early_bytes > 0 ? 100.0 * static_cast<double>(late_bytes - early_bytes) /
                                 static_cast<double>(early_bytes)
                           : 0;
  }
};

/// Puts load on the three nodelets. They run in this process, in the camera driver's place: images
/// reach them as they do in a driver's manager, without a copy. Needs a ROS master.
class LiveLoad {
 public:
  /// Reads the stereo pairs of a bag into memory.
  /// @param max_pairs  so many at most.
  /// @throws std::runtime_error where the bag cannot be read or has no pairs.
  LiveLoad(const std::string& bag, const StereoTopicChoice& choice, int max_pairs);

  int pairs() const { return static_cast<int>(pairs_.size()); }
  cv::Size size() const;

  /// Sends `frames` pairs, forwards and backwards through the bag so that the motion stays
  /// continuous, to newly loaded nodelets, and takes what they say of moving objects, disparity and
  /// odometry.
  /// @param rate_hz  0: as fast as nothing is lost: the next pair comes with the last one's
  /// disparity.
  /// @throws std::runtime_error where the nodelets do not start.
  LiveLoadResult run(double rate_hz, int frames, const AllNodeletParams& params);

 private:
  StereoPair pairAt(int index, ros::Time stamp) const;

  std::vector<StereoPair> pairs_;
  ros::Duration period_;  // of the bag
  int runs_ = 0;
};

}  // namespace predictive_stereo
