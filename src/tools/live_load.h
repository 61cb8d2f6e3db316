#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "tools/stereo_topics.h"

namespace predictive_stereo {

/// What became of one frame.
struct LoadedFrame {
  double latency_ms = std::numeric_limits<double>::quiet_NaN();  ///< NaN: lost
  int64_t resident_bytes = 0;  ///< of the process, when the frame had been sent
};

/// Some of the frames that were sent.
struct LoadSummary {
  int sent = 0;
  int lost = 0;                                           ///< no moving objects came out
  double p50_ms = 0, p95_ms = 0, p99_ms = 0, max_ms = 0;  ///< latencies; 0 where all are lost
  int64_t resident_bytes = 0;                             ///< when the last one had been sent
};

/// A run of frames.
struct LiveLoadResult {
  std::vector<LoadedFrame> frames;  ///< all that were sent
  double seconds = 0;               ///< from the first sent to the last output
  /// Frames lost, as the nodelets' diagnostics say; all that are lost where each loss is counted.
  int64_t reported_losses = 0;

  /// Of the frames [first, last).
  LoadSummary summary(int first, int last) const;
  LoadSummary summary() const { return summary(0, static_cast<int>(frames.size())); }
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
  /// continuous, to newly loaded nodelets, and receives their moving objects, disparity and
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
