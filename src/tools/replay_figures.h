#pragma once

#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>

#include "nodelets/pipeline_processor.h"
#include "tools/stage_table.h"

namespace predictive_stereo {

/// Quality figures that need no ground truth, for replay.
class ReplayFigures {
 public:
  void add(const PipelineProcessor::Output& frame) {
    ++pairs_;
    lost_ += frame.pose_state != PoseState::kKnown;
    unpredicted_ += !frame.disparity.predicted;
    objects_ += frame.moving_objects.objects->objects.size();
    const stereo_msgs::DisparityImage& disparity = *frame.disparity.disparity;
    const cv::Mat1f map(static_cast<int>(disparity.image.height),
                        static_cast<int>(disparity.image.width),
                        reinterpret_cast<float*>(const_cast<uint8_t*>(disparity.image.data.data())),
                        disparity.image.step);
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
         << times.quantile("whole frame", 0.5) << ',' << times.quantile("whole frame", 0.95)
         << '\n';
    return text.str();
  }

 private:
  size_t pairs_ = 0, lost_ = 0, unpredicted_ = 0, objects_ = 0;
  double density_ = 0;
};

}  // namespace predictive_stereo
