#include "evaluation/perturbation.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace predictive_stereo {
namespace {

class RememberedSequence : public Sequence {
 public:
  RememberedSequence(const Sequence& from, int max_frames) : Sequence(from.name(), from.rig()) {
    const int frames = framesOf(from, max_frames);
    for (int i = 0; i < frames; ++i) {
      const SequenceFrame images = from.frame(i);
      frames_.push_back({{images.left, images.right, {}, {}}, from.stamp_s(i), from.objects(i)});
    }
  }
  int frames() const override { return static_cast<int>(frames_.size()); }
  SequenceFrame frame(int index) const override { return at(index).images; }
  double stamp_s(int index) const override { return at(index).stamp_s; }

 private:
  struct Frame {
    SequenceFrame images;
    double stamp_s;
    std::optional<std::vector<ObjectLabel>> objects;
  };
  std::optional<std::vector<ObjectLabel>> trueObjects(int index) const override {
    return at(index).objects;
  }
  const Frame& at(int index) const { return frames_.at(static_cast<size_t>(index)); }

  std::vector<Frame> frames_;
};

cv::Mat1b withNoise(const cv::Mat1b& image, double sigma, uint64_t seed) {
  cv::Mat1s noise(image.size());
  // In tenths of grey levels: whole levels would be too coarse.
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, 10 * sigma);
  cv::Mat1b noisy(image.size());
  std::transform(image.begin(), image.end(), noise.begin(), noisy.begin(), [](uchar g, short n) {
    return cv::saturate_cast<uchar>(g + 0.1f * static_cast<float>(n));
  });
  return noisy;
}

class PerturbedSequence : public Sequence {
 public:
  PerturbedSequence(std::shared_ptr<const Sequence> from, const Perturbation& change)
      : Sequence(from->name(), from->rig()), from_(std::move(from)), change_(change) {
    if (change.mirrored) {
      const double last = rig_.size.width - 1;
      rig_.cx_left_px = last - from_->rig().cx_right_px;
      rig_.cx_right_px = last - from_->rig().cx_left_px;
    }
    for (int i = change.first; i < from_->frames(); i += change.every)
      if (change.drop_every == 0 || i % change.drop_every != 5) kept_.push_back(i);
  }
  int frames() const override { return static_cast<int>(kept_.size()); }
  double stamp_s(int index) const override { return from_->stamp_s(source(index)); }
  int fileNumber(int index) const override { return from_->fileNumber(source(index)); }

  SequenceFrame frame(int index) const override {
    SequenceFrame frame = from_->frame(source(index));
    frame.right = withWrongColumns(frame.right, source(index));
    if (change_.mirrored) {
      cv::Mat1b left, right;
      cv::flip(frame.right, left, 1);
      cv::flip(frame.left, right, 1);
      frame.left = left;
      frame.right = right;
    }
    uint64_t seed = 2 * static_cast<uint64_t>(source(index)) + 1;
    for (cv::Mat1b* image : {&frame.left, &frame.right}) {
      const double gain = change_.gain * (image == &frame.right ? change_.right_gain : 1);
      if (gain != 1 || change_.offset != 0) {
        cv::Mat1b changed;
        image->convertTo(changed, CV_8U, gain, change_.offset);
        *image = changed;
      }
      if (change_.noise_sigma > 0) *image = withNoise(*image, change_.noise_sigma, seed++);
    }
    return frame;
  }

 private:
  std::optional<std::vector<ObjectLabel>> trueObjects(int index) const override {
    auto labels = from_->objects(source(index));
    if (labels && change_.mirrored)
      for (ObjectLabel& label : *labels) label = predictive_stereo::mirrored(label, from_->rig());
    return labels;
  }
  cv::Mat1b withWrongColumns(const cv::Mat1b& right, int frame) const {
    const double corner_px = change_.column_offset_px, bow_px = change_.column_bow_px;
    const double jump_px = 2 * frame >= from_->frames() ? change_.column_jump_px : 0;
    if (corner_px == 0 && bow_px == 0 && jump_px == 0) return right;
    // The quadratic part is corner_px in the lower left corner, -corner_px in the upper right one.
    cv::Mat1f x_px(right.size()), y_px(right.size());
    for (int y = 0; y < right.rows; ++y)
      for (int x = 0; x < right.cols; ++x) {
        const double u = 2.0 * x / right.cols - 1, v = 2.0 * y / right.rows - 1;  // -1 to 1
        const double offset_px =
            corner_px * (0.25 * (v - u) - 0.5 * u * v) + bow_px * u * u + jump_px;
        x_px(y, x) = static_cast<float>(x + offset_px);
        y_px(y, x) = static_cast<float>(y);
      }
    cv::Mat1b warped;
    cv::remap(right, warped, x_px, y_px, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return warped;
  }
  int source(int index) const { return kept_.at(static_cast<size_t>(index)); }

  std::shared_ptr<const Sequence> from_;
  Perturbation change_;
  std::vector<int> kept_;
};

Perturbation with(const char* name, void (*change)(Perturbation&)) {
  Perturbation perturbation;
  perturbation.name = name;
  change(perturbation);
  return perturbation;
}

}  // namespace

PipelineParams Perturbation::applyTo(PipelineParams params) const {
  if (margin_px > 0) params.disparity.search.margin_px = margin_px;
  return params;
}

const std::vector<Perturbation>& perturbations() {
  using P = Perturbation;
  static const std::vector<P> all = {
      with("as it is", [](P&) {}),
      with("ranges 2 px", [](P& p) { p.margin_px = 2; }),
      with("ranges 2.5 px", [](P& p) { p.margin_px = 2.5; }),
      with("ranges 3 px", [](P& p) { p.margin_px = 3; }),
      with("noise 2 grey levels", [](P& p) { p.noise_sigma = 2; }),
      with("contrast 0.7", [](P& p) { p.gain = 0.7, p.offset = 20; }),
      with("contrast 1.3", [](P& p) { p.gain = 1.3, p.offset = -20; }),
      with("mirrored", [](P& p) { p.mirrored = true; }),
      with("columns off 1 px", [](P& p) { p.column_offset_px = 1; }),
      with("columns off 3 px at the borders", [](P& p) { p.column_bow_px = 3; }),
      with("columns jump by 2 px", [](P& p) { p.column_jump_px = 2; }),
      with("right image darker by a quarter", [](P& p) { p.right_gain = 0.75; }),
      with("every 7th frame missing", [](P& p) { p.drop_every = 7; }),
      with("even frames", [](P& p) { p.every = 2; }),
      with("odd frames", [](P& p) { p.every = 2, p.first = 1; }),
  };
  return all;
}

std::unique_ptr<Sequence> loadIntoMemory(const Sequence& sequence, int max_frames) {
  return std::make_unique<RememberedSequence>(sequence, max_frames);
}

ObjectLabel mirrored(const ObjectLabel& label, const StereoRig& rig) {
  ObjectLabel result = label;
  const double disparity_px = label.distance_m ? rig.disparityTimesDepth() / *label.distance_m : 0;
  const double shift_px = disparity_px + rig.cx_left_px - rig.cx_right_px;
  const cv::Rect2d whole(rig.size.width - (label.box_px.br().x - shift_px), label.box_px.y,
                         label.box_px.width, label.box_px.height);
  result.box_px = whole & cv::Rect2d(0, 0, rig.size.width, rig.size.height);
  if (!label.distance_m || result.box_px.area() < 0.5 * whole.area()) result.hard = true;
  return result;
}

std::unique_ptr<Sequence> perturbed(std::shared_ptr<const Sequence> sequence,
                                    const Perturbation& perturbation) {
  return std::make_unique<PerturbedSequence>(std::move(sequence), perturbation);
}

}  // namespace predictive_stereo
