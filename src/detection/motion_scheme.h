/// The default detector: tracks and dense residuals against the static world.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "detection/dense_channel.h"
#include "detection/frame_comparison.h"
#include "detection/layer_motion.h"
#include "detection/long_residual.h"
#include "detection/point_tracks.h"
#include "detection/road_line.h"
#include "detection/segmentation.h"
#include "detection/suspicion.h"
#include "detection/tracker.h"

namespace predictive_stereo {

/// An object of this frame with its pixels.
struct ObservedObject {
  Observation observation;
  cv::Mat1b mask;  ///< 255 on its pixels; of the size of its box
};

class MotionScheme {
 public:
  /// Frames back that slow motion is told from.
  static constexpr int kFarthestPast = 8;

  MotionScheme(const DisparityRange& range, const MotionDetectionParams& params)
      : range_(range), params_(params) {}
  /// The previous frame is kept.
  void setParams(const MotionDetectionParams& params) { params_ = params; }

  /// @param known  objects that are followed, moved to this frame.
  void observe(const DetectionInput& input, const ObjectTracker& known,
               std::vector<ObservedObject>& objects);
  void reset();

 private:
  /// The current frame against one of the past.
  struct Baseline {
    PastFrame past;
    PastFrame halfway;  ///< where it is long: the motion has to be the same since then
    Comparison static_world;
    cv::Mat1f residual_px;
  };
  enum class Source { kTracks, kDense, kSlow, kKnown };

  std::vector<PastFrame> pastOf(const DetectionInput& input) const;
  void setLayer(const DetectionInput& input, Hypothesis& hypothesis) const;
  void remember(const DetectionInput& input);
  TrackingView trackingView(const DetectionInput& input, const PastFrame& past) const;
  bool isFree(const Hypothesis& hypothesis) const;
  bool belongsToAny(const Observation& seen, double largest_share,
                    const std::vector<ObservedObject>& objects) const;
  void tryHypothesis(const DetectionInput& input, const Baseline& baseline,
                     const Hypothesis& hypothesis, const Eigen::Matrix3d& covariance, Source source,
                     std::vector<ObservedObject>& objects);
  bool poseFollows();
  void findAcross(const DetectionInput& input, const Baseline& baseline,
                  const std::vector<cv::Point>& suspects_px, std::vector<ObservedObject>& objects);
  void findAlong(const DetectionInput& input, const Baseline& baseline,
                 std::vector<ObservedObject>& objects);
  void compareLong(const DetectionInput& input, const Hypothesis& hypothesis);
  bool goesOn(const DetectionInput& input, const std::vector<cv::Point>& points_px,
              cv::Point2f shift_px, const Displacement& fit) const;
  void tryGroup(const DetectionInput& input, const DenseGroup& group, const Baseline& baseline,
                std::vector<ObservedObject>& objects);
  void findSlow(const DetectionInput& input, std::vector<ObservedObject>& objects);
  bool trySlow(const DetectionInput& input, Hypothesis hypothesis,
               const std::optional<Eigen::Vector3d>& expected_mps,
               std::vector<ObservedObject>& objects);
  void findKnown(const DetectionInput& input, const ObjectTrack& track, const Baseline& baseline,
                 std::vector<ObservedObject>& objects);

  DisparityRange range_;
  MotionDetectionParams params_;
  /// The current frame first, then the one before it, and so on.
  std::array<RememberedFrame, 1 + kFarthestPast> frames_;

  // How much of the image contradicts the static world as a rule, and frames in a row beyond that.
  std::optional<double> usual_share_;
  int odd_frames_ = 0;

  // The frame in work.
  Baseline short_;
  Baseline long_;                // of one hypothesis; compared where that reaches
  std::vector<PastPair> pairs_;  // frames further back, the farthest first
  cv::Mat1b pair_;               // of each lattice point, see longResidual
  Comparison compared_;
  std::optional<DisparityHistory> history_;
  Suspicion suspicion_;
  std::vector<cv::Point> unexplained_px_;
  DenseGroups dense_groups_;
  std::optional<RoadLine> road_;  // the last one that was found
  LevelGround ground_;
  SegmentationWork segmentation_;
  cv::Mat1b taken_;  // lattice points of objects that were found already
};

}  // namespace predictive_stereo
