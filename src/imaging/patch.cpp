#include "imaging/patch.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

constexpr int kArea = kPatchSize * kPatchSize;
constexpr float kSmallestEigenvalue = 4;  // of the mean squared gradient [grey^2 / px^2]
constexpr float kFarthestPx = 8;          // from the start; the linearisation does not hold beyond

// A sub-pixel position: the pixel above and to the left of it, and the fractions.
struct SubPixel {
  int x, y;
  float fx, fy;

  explicit SubPixel(cv::Point2f p)
      : x(static_cast<int>(p.x)),
        y(static_cast<int>(p.y)),
        fx(p.x - static_cast<float>(x)),
        fy(p.y - static_cast<float>(y)) {}
  BilinearWeights weights() const {
    return {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  }
};

// Chooses the kernel by the pixels that it reads; no other code checks them. Samples need the
// pixels from position `first` to `side` columns and rows behind position `last`. The reference
// reads only these. Vectors read the same rows, and `columns_read` columns: if the image has fewer,
// or samples need more, the reference is used. Null if samples need pixels outside the image, or if
// a position is NaN.
const PatchKernel* kernelWithin(const PatchKernel& vectors, const cv::Mat1b& image,
                                cv::Point2f first, cv::Point2f last, int side, int columns_read) {
  const bool inside = first.x >= 0 && first.y >= 0 && first.x <= last.x && first.y <= last.y &&
                      last.x < static_cast<float>(image.cols - side) &&
                      last.y < static_cast<float>(image.rows - side);
  if (!inside) return nullptr;
  const int column = static_cast<int>(first.x), end = column + columns_read;
  const bool enough = static_cast<int>(last.x) + side < end && end <= image.cols;
  return enough ? &vectors : &referencePatchKernel();
}

// Position of sample i of a row.
float sampleAt(float first, float distance, int i) {
  return first + static_cast<float>(std::min(i, kFramedSize - 1)) * distance;
}

// Splits the positions of a row of samples into pixels and fractions.
void splitPositions(float first, float distance, int (&pixel)[kPatchStride],
                    float (&fraction)[kPatchStride]) {
  for (int i = 0; i < kPatchStride; ++i) {
    const float at = sampleAt(first, distance, i);
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
  const cv::Point2f first(centre.x - half, centre.y - half);
  if (scale == 1) {
    const PatchKernel* kernel =
        kernelWithin(*kernel_, image, first, first, kFramedSize, kReadColumns);
    if (!kernel) return false;
    const SubPixel corner(first);
    kernel->sample(image.ptr<uchar>(corner.y) + corner.x, image.step, corner.weights(), framed);
  } else {
    constexpr int kLast = kFramedSize - 1;
    const cv::Point2f last(sampleAt(first.x, scale, kLast), sampleAt(first.y, scale, kLast));
    const PatchKernel* kernel = kernelWithin(*kernel_, image, first, last, 1, kReadGridColumns);
    if (!kernel) return false;
    SampleGrid grid;
    splitPositions(first.x, scale, grid.column, grid.column_fraction);
    splitPositions(first.y, scale, grid.row, grid.row_fraction);
    kernel->sampleGrid(image.data, image.step, grid, framed);
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

Patch::Match Patch::align(const cv::Mat1b& image, cv::Point2f start, int max_iterations,
                          float stop_px) const {
  constexpr float kHalf = 0.5f * (kSize - 1);
  Match match;
  match.position = start;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const cv::Point2f first(match.position.x - kHalf, match.position.y - kHalf);
    const PatchKernel* kernel = kernelWithin(*kernel_, image, first, first, kSize, kReadColumns);
    if (!kernel) return match;
    const SubPixel at(first);
    PatchProducts sum;
    kernel->multiply(images_, image.ptr<uchar>(at.y) + at.x, image.step, at.weights(), sum);
    const float norm = std::sqrt(std::max(sum.grey_grey - sum.grey * sum.grey / kArea, 1e-6f));
    match.correlation = sum.texture_grey / (norm * texture_norm_);
    // Texture and gradients have zero mean, so the brightness offset cancels.
    const float gain = std::clamp(texture_norm_ / norm, 0.4f, 2.5f);
    const float bx = gain * sum.x_grey - moments_.xt;
    const float by = gain * sum.y_grey - moments_.yt;
    const cv::Point2f step(inverse_(0, 0) * bx + inverse_(0, 1) * by,
                           inverse_(1, 0) * bx + inverse_(1, 1) * by);
    match.position -= step;
    const cv::Point2f moved = match.position - start;
    if (!(moved.dot(moved) < kFarthestPx * kFarthestPx)) return match;
    if (step.dot(step) < stop_px * stop_px) {
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
