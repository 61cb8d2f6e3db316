#include "benchmark/sequences.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "evaluation/sequence.h"
#include "evaluation/simulation/street.h"

namespace predictive_stereo {
namespace {

class PairSequence : public Sequence {
 public:
  PairSequence(const std::string& left_file, const std::string& right_file, int frames)
      : Sequence(left_file), frames_(frames), left_(read(left_file)), right_(read(right_file)) {
    if (left_.size() != right_.size())
      throw std::runtime_error(left_file + " and " + right_file + " differ in size");
    // Arbitrary, because without motion the prediction does not depend on the rig.
    rig_.size = left_.size();
    rig_.fx_px = rig_.fy_px = 0.58 * left_.cols;
    rig_.cx_left_px = rig_.cx_right_px = 0.5 * left_.cols;
    rig_.cy_px = 0.5 * left_.rows;
    rig_.baseline_m = 0.5;
  }
  int frames() const override { return frames_; }
  SequenceFrame frame(int) const override { return {left_, right_, {}, {}}; }

 private:
  static cv::Mat1b read(const std::string& file) {
    const cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE);
    if (image.empty()) throw std::runtime_error(file + ": cannot be read as an image");
    return image;
  }

  int frames_;
  cv::Mat1b left_, right_;
};

}  // namespace

std::unique_ptr<Sequence> misalignedStreet(int frames, cv::Size size) {
  StreetParams params;
  params.scene = "misaligned";
  params.width = size.width;
  params.height = size.height;
  params.frames = frames;
  return streetSequence(params);
}

std::unique_ptr<Sequence> pairSequence(const std::string& left_file, const std::string& right_file,
                                       int frames) {
  return std::make_unique<PairSequence>(left_file, right_file, frames);
}

std::unique_ptr<Sequence> openSequence(const std::string& first, const std::string& second,
                                       int frames) {
  if (!std::filesystem::is_directory(first)) return pairSequence(first, second, frames);
  if (std::filesystem::is_directory(std::filesystem::path(first) / "disp_occ"))
    return kittiScene(KittiStereo::k2012, first, second);
  return kittiDriveSequence(first, second);
}

}  // namespace predictive_stereo
