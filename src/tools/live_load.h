#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "nodelets/nodelet_params.h"
#include "nodelets/stereo_messages.h"
#include "tools/stereo_bag.h"

namespace predictive_stereo {

/// Result of one frame.
struct LoadedFrame {
  double sent_s = 0;  ///< when it was sent, since the begin of the run
  double latency_ms = std::numeric_limits<double>::quiet_NaN();  ///< NaN: lost
  int64_t resident_bytes = 0;  ///< resident memory of the process after sending the frame
};

/// Statistics of some of the frames.
struct LoadSummary {
  int sent = 0;
  int lost = 0;                                           ///< frames without moving_objects
  double p50_ms = 0, p95_ms = 0, p99_ms = 0, max_ms = 0;  ///< latencies; 0 if all are lost
  int64_t resident_bytes = 0;                             ///< after sending the last one
};

/// Results of a run.
struct LiveLoadResult {
  std::vector<LoadedFrame> frames;  ///< all frames that were sent
  /// Lost frames according to the nodelets' diagnostics, which should count every loss.
  int64_t reported_losses = 0;

  /// Statistics of the frames [first, last).
  LoadSummary summary(int first, int last) const;
  LoadSummary summary() const { return summary(0, static_cast<int>(frames.size())); }
  /// Frames per second that were not lost, until the last frame was sent and the last output came.
  double reachedHz() const;
};

/// Load test of the three nodelets. They run in this process, so they get images without a copy, as
/// in the nodelet manager of a camera driver. Needs a ROS master.
class LiveLoad {
 public:
  /// Reads the stereo pairs of a bag into memory.
  /// @param max_pairs  largest number of pairs.
  /// @throws std::runtime_error if the bag cannot be read or has no pairs.
  LiveLoad(const std::string& bag, const StereoTopicChoice& choice, int max_pairs);

  int pairs() const { return static_cast<int>(pairs_.size()); }
  cv::Size size() const;

  /// Loads the nodelets, sends them `frames` pairs and receives their moving objects, disparity and
  /// odometry. The pairs are those of the bag, forwards and backwards, so that motion is
  /// continuous.
  /// @param rate_hz  0: as fast as possible without losses: each pair is sent after the disparity
  ///   of the previous one has arrived.
  /// @throws std::runtime_error if the nodelets do not start.
  LiveLoadResult run(double rate_hz, int frames, const AllNodeletParams& params);

 private:
  StereoPair pairAt(int index, ros::Time stamp) const;

  std::vector<StereoPair> pairs_;
  ros::Duration period_;  // of the bag
  int runs_ = 0;
};

}  // namespace predictive_stereo
