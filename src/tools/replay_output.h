#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>

#include "nodelets/output_topics.h"
#include "nodelets/pipeline_processor.h"
#include "tools/stage_table.h"

namespace predictive_stereo {

/// What the outputs of a pair are made of.
struct ReplayedFrame {
  const PipelineProcessor::Output& out;
  const PointsParams& points;

  CloudSource clouds() const {
    return {out.disparity.disparity, out.disparity.left, out.disparity.rig, points,
            out.moving_objects.mask};
  }
};

/// Calls `visit(topic, make)` for each output; make(frame) is a pointer to its message.
template <class Visit>
void visitOutputs(const Visit& visit) {
  using F = ReplayedFrame;
  // @param part  gives what the outputs of a nodelet are made of.
  const auto of = [&](const auto& part) {
    return [&visit, part](const OutputTopic& topic, const auto& make) {
      visit(topic.name, [&](const F& frame) { return std::invoke(make, part(frame)); });
    };
  };
  const auto of_disparity = of([](const F& f) -> const auto& { return f.out.disparity; });
  visitEgoMotionOutputs(of([](const F& f) -> const auto& { return f.out.ego_motion; }));
  visitDisparityOutputs(of_disparity, of_disparity);
  visitCloudOutputs(of([](const F& f) { return f.clouds(); }));
  visitMovingObjectsOutputs(of([](const F& f) -> const auto& { return f.out.moving_objects; }));
}

/// Quality figures that need no ground truth, for replay.
class ReplayFigures {
 public:
  void add(const PipelineProcessor::Output& frame) {
    ++pairs_;
    lost_ += frame.ego_motion.pose_state != PoseState::kKnown;
    unpredicted_ += !frame.disparity.predicted;
    objects_ += frame.moving_objects.objects->objects.size();
    const stereo_msgs::DisparityImage& disparity = *frame.disparity.disparity;
    const cv::Mat1f map = floatView(disparity.image, "disparity");
    density_ += cv::countNonZero(map >= disparity.min_disparity) / double(map.total());
  }

  size_t pairs() const { return pairs_; }

  std::string csv(const std::string& bag, size_t unmatched, size_t duplicates,
                  const StageTable& times) const {
    const double frames = static_cast<double>(pairs_);
    std::ostringstream text;
    text << "recording,pairs,unmatched,duplicates,lost_percent,unpredicted_percent,"
            "density_percent,objects_per_frame,median_ms,p95_ms\n"
         << std::filesystem::path(bag).stem().string() << ',' << pairs_ << ',' << unmatched << ','
         << duplicates << ',' << 100 * lost_ / frames << ',' << 100 * unpredicted_ / frames << ','
         << 100 * density_ / frames << ',' << objects_ / frames << ','
         << times.quantileOf("whole frame", 0.5) << ',' << times.quantileOf("whole frame", 0.95)
         << '\n';
    return text.str();
  }

 private:
  size_t pairs_ = 0, lost_ = 0, unpredicted_ = 0, objects_ = 0;
  double density_ = 0;
};

}  // namespace predictive_stereo
