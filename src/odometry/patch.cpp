#include "odometry/patch.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

constexpr int kArea = kPatchSize * kPatchSize;
constexpr float kSmallestEigenvalue = 4;  // of the mean squared gradient [grey^2 / px^2]
constexpr float kStopPx = 0.015f;
constexpr float kFarthestPx = 8;  // from the start: beyond, the linearisation does not hold

// Without SSE4, std::floor is a call.
int floorOf(float value) {
  const int towards_zero = static_cast<int>(value);
  return towards_zero - (static_cast<float>(towards_zero) > value ? 1 : 0);
}

// The pixel above and to the left of a sub-pixel position, and how far it is.
struct SubPixel {
  int x, y;
  float fx, fy;

  SubPixel(float px, float py)
      : x(floorOf(px)),
        y(floorOf(py)),
        fx(px - static_cast<float>(x)),
        fy(py - static_cast<float>(y)) {}
  BilinearWeights weights() const {
    return {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  }
  // Whether a square of samples from here on lies in the image.
  bool inside(const cv::Mat1b& image, int side) const {
    return x >= 0 && y >= 0 && x + side < image.cols && y + side < image.rows;
  }
};

// Vectors are read beyond the patch, but never beyond the image's memory.
const PatchKernel& kernelAt(const PatchKernel& kernel, const cv::Mat1b& image, int first_column,
                            int columns_read) {
  return first_column + columns_read <= image.cols ? kernel : referencePatchKernel();
}

// Pixels and fractions of a row of samples.
void spread(float first, float distance, int (&pixel)[kPatchStride],
            float (&fraction)[kPatchStride]) {
  for (int i = 0; i < kPatchStride; ++i) {
    const float at = first + static_cast<float>(std::min(i, kFramedSize - 1)) * distance;
    pixel[i] = static_cast<int>(at);
    fraction[i] = at - static_cast<float>(pixel[i]);
  }
}

}  // namespace

void Patch::prefetch(const cv::Mat1b& image, cv::Point2f centre) {
  constexpr int kHalf = kFramedSize / 2 + 1;
  const int x = std::clamp(static_cast<int>(centre.x) - kHalf, 0, image.cols - 1);
  const int last = std::min(x + 2 * kHalf, image.cols - 1);
  const int y = static_cast<int>(centre.y);
  for (int v = std::max(y - kHalf, 0); v <= std::min(y + kHalf, image.rows - 1); ++v) {
    hwy::Prefetch(image[v] + x);
    hwy::Prefetch(image[v] + last);
  }
}

bool Patch::sample(const cv::Mat1b& image, cv::Point2f centre, float scale) {
  FramedPatch framed;
  const float half = 0.5f * (kFramedSize - 1) * scale;
  const SubPixel first(centre.x - half, centre.y - half);
  if (scale == 1) {
    if (!first.inside(image, kFramedSize)) return false;
    kernelAt(*kernel_, image, first.x, kReadColumns)
        .sample(image.ptr<uchar>(first.y) + first.x, image.step, first.weights(), framed);
  } else {
    if (!first.inside(image, 1) || !SubPixel(centre.x + half, centre.y + half).inside(image, 1))
      return false;
    SampleGrid grid;
    spread(centre.x - half, scale, grid.column, grid.column_fraction);
    spread(centre.y - half, scale, grid.row, grid.row_fraction);
    const bool wide = grid.column[kFramedSize - 1] + 2 - first.x > kReadGridColumns;
    const PatchKernel& kernel =
        wide ? referencePatchKernel() : kernelAt(*kernel_, image, first.x, kReadGridColumns);
    kernel.sampleGrid(image.data, image.step, grid, framed);
  }

  kernel_->differentiate(framed, images_, moments_);
  texture_norm_ = std::sqrt(moments_.tt);
  const float determinant = moments_.xx * moments_.yy - moments_.xy * moments_.xy;
  const float trace = moments_.xx + moments_.yy;
  const float smaller = 0.5f * (trace - std::sqrt(std::max(0.f, trace * trace - 4 * determinant)));
  if (!(smaller >= kSmallestEigenvalue * kArea * 0.1f) || !(determinant > 0)) return false;
  inverse_ = cv::Matx22f(moments_.yy, -moments_.xy, -moments_.xy, moments_.xx) * (1 / determinant);
  return true;
}

Patch::Match Patch::align(const cv::Mat1b& image, cv::Point2f start, int max_iterations) const {
  constexpr float kHalf = 0.5f * (kSize - 1);
  Match match;
  match.position = start;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const SubPixel at(match.position.x - kHalf, match.position.y - kHalf);
    if (!at.inside(image, kSize)) return match;
    PatchProducts sum;
    kernelAt(*kernel_, image, at.x, kReadColumns)
        .multiply(images_, image.ptr<uchar>(at.y) + at.x, image.step, at.weights(), sum);
    const float norm = std::sqrt(std::max(sum.grey_grey - sum.grey * sum.grey / kArea, 1e-6f));
    match.correlation = sum.texture_grey / (norm * texture_norm_);
    // Texture and gradients have zero mean, so the offset of brightness cancels by itself.
    const float gain = std::clamp(texture_norm_ / norm, 0.4f, 2.5f);
    const float bx = gain * sum.x_grey - moments_.xt;
    const float by = gain * sum.y_grey - moments_.yt;
    const cv::Point2f step(inverse_(0, 0) * bx + inverse_(0, 1) * by,
                           inverse_(1, 0) * bx + inverse_(1, 1) * by);
    match.position -= step;
    const cv::Point2f moved = match.position - start;
    if (!(moved.dot(moved) < kFarthestPx * kFarthestPx)) return match;
    if (step.dot(step) < kStopPx * kStopPx) {
      match.converged = true;
      return match;
    }
  }
  return match;
}

float Patch::columnErrorFromRowError(float row_error_px) const {
  return -moments_.xy / moments_.xx * row_error_px;
}

}  // namespace predictive_stereo
