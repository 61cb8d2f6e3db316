#include "detection/long_residual.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detection/dense_channel.h"

namespace predictive_stereo {
namespace {

constexpr float kLargest_px = 8.0f;

// Parallax since the camera was at a place, from its position in the current camera's frame.
class Parallax {
 public:
  Parallax(const StereoRig& rig, const PastFrame& past)
      : position_(past.T_past_cam.inverse().translation().cast<float>()),
        focal_px_(static_cast<float>(rig.fx_px)),
        cx_px_(static_cast<float>(rig.cx_left_px)),
        cy_px_(static_cast<float>(rig.cy_px)),
        disparity_times_depth_(static_cast<float>(rig.disparityTimesDepth())) {}
  float operator()(float x, float y, float d) const {
    const float depth = disparity_times_depth_ - d * position_.z();  // then, times d
    const float across = std::abs((x - cx_px_) * position_.z() - focal_px_ * position_.x());
    const float down = std::abs((y - cy_px_) * position_.z() - focal_px_ * position_.y());
    return depth > 0 ? d * std::max(across, down) / depth : std::numeric_limits<float>::infinity();
  }

 private:
  Eigen::Vector3f position_;
  float focal_px_, cx_px_, cy_px_, disparity_times_depth_;
};

// Static disparity less measured one; false where unknown.
bool residualAt(const Eigen::Vector3f& source, const cv::Mat1f& measured_px,
                const DisparityRange& range, float& residual_px) {
  const float x = source.x() + 0.5f, y = source.y() + 0.5f;
  if (!(source.z() > 0 && x >= 0 && y >= 0 && x < static_cast<float>(measured_px.cols) &&
        y < static_cast<float>(measured_px.rows)))
    return false;
  const float before = measured_px(static_cast<int>(y), static_cast<int>(x));
  residual_px = std::clamp(source.z() - before, -kLargest_px, kLargest_px);
  return range.isValid(before);
}

}  // namespace

float parallaxSince(const StereoRig& rig, const PastFrame& past, const Eigen::Vector3f& point_px) {
  return Parallax(rig, past)(point_px.x(), point_px.y(), point_px.z());
}

int pairWithin(const StereoRig& rig, const std::vector<PastPair>& pairs,
               const Eigen::Vector3d& point_px, double most_px) {
  for (size_t k = 0; k < pairs.size(); ++k)
    if (parallaxSince(rig, pairs[k].past, point_px.cast<float>()) <= most_px)
      return static_cast<int>(k);
  return -1;
}

void longResidual(const StereoRig& rig, const cv::Mat1f& disparity_px, const DisparityRange& range,
                  const std::vector<PastPair>& pairs, double most_px, cv::Size lattice,
                  cv::Mat1f& residual_px, cv::Mat1b& pair) {
  struct Sources {
    Parallax parallax;
    SourceOf past, halfway;
    const cv::Mat1f &past_px, &halfway_px;
    float scale;
  };
  std::vector<Sources> sources;
  for (const PastPair& p : pairs)
    sources.push_back({Parallax(rig, p.past), SourceOf(disparityMotion(rig, p.past.T_past_cam)),
                       SourceOf(disparityMotion(rig, p.halfway.T_past_cam)),
                       p.past.frame->disparity_px, p.halfway.frame->disparity_px,
                       static_cast<float>(p.past.seconds / p.halfway.seconds)});
  residual_px.create(lattice);
  pair.create(lattice);
  const auto most = static_cast<float>(most_px);
  cv::parallel_for_(cv::Range(0, (lattice.height + 1) / 2), [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row) {
      const int v = 2 * row;
      for (int u = 0; u < lattice.width; u += 2) {
        float out = kUnknownResidual;
        uchar of_pair = kNoPair;
        const float d = disparity_px(2 * v, 2 * u);
        const auto x = static_cast<float>(2 * u), y = static_cast<float>(2 * v);
        for (size_t k = 0; range.isValid(d) && k < sources.size(); ++k) {
          const Sources& s = sources[k];
          if (s.parallax(x, y, d) > most) continue;
          of_pair = static_cast<uchar>(k);
          float far = 0, near = 0;
          if (residualAt(s.past(x, y, d), s.past_px, range, far) &&
              residualAt(s.halfway(x, y, d), s.halfway_px, range, near)) {
            near *= s.scale;
            out = near * far <= 0 ? 0.0f : (std::abs(near) < std::abs(far) ? near : far);
          }
          break;
        }
        const cv::Rect block = cv::Rect(u, v, 2, 2) & cv::Rect(cv::Point(), lattice);
        for (int j = v; j < block.br().y; ++j)
          for (int i = u; i < block.br().x; ++i) {
            residual_px(j, i) = out;
            pair(j, i) = of_pair;
          }
      }
    }
  });
}

}  // namespace predictive_stereo
