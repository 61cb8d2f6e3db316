#include "evaluation/shifted_sequence.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace predictive_stereo {
namespace {

class ShiftedRightSequence : public Sequence {
 public:
  ShiftedRightSequence(std::unique_ptr<Sequence> sequence, double shift_px)
      : sequence_(std::move(sequence)), shift_px_(shift_px) {
    char text[64];
    std::snprintf(text, sizeof text, ", right %+g px", shift_px);
    name_ = sequence_->name() + text;
  }
  const std::string& name() const override { return name_; }
  const std::string& recording() const override { return sequence_->recording(); }
  const StereoRig& rig() const override { return sequence_->rig(); }
  int frames() const override { return sequence_->frames(); }
  SequenceFrame frame(int index) const override {
    SequenceFrame frame = sequence_->frame(index);
    frame.right = shiftedRight(frame.right, shift_px_);
    return frame;
  }
  double stamp_s(int index) const override { return sequence_->stamp_s(index); }
  int fileNumber(int index) const override { return sequence_->fileNumber(index); }
  std::optional<std::vector<ObjectLabel>> objects(int index) const override {
    return sequence_->objects(index);
  }
  bool hasExactPoses() const override { return sequence_->hasExactPoses(); }
  std::optional<std::vector<Eigen::Isometry3d>> poses() const override {
    return sequence_->poses();
  }

 private:
  std::unique_ptr<Sequence> sequence_;
  double shift_px_;
  std::string name_;
};

}  // namespace

cv::Mat1b shiftedRight(const cv::Mat1b& right, double shift_px) {
  const cv::Matx23d shift(1, 0, shift_px, 0, 1, 0);
  cv::Mat1b shifted;
  cv::warpAffine(right, shifted, shift, right.size(), cv::INTER_LANCZOS4, cv::BORDER_REPLICATE);
  return shifted;
}

std::unique_ptr<Sequence> shiftedRightSequence(std::unique_ptr<Sequence> sequence,
                                               double shift_px) {
  return std::make_unique<ShiftedRightSequence>(std::move(sequence), shift_px);
}

}  // namespace predictive_stereo
