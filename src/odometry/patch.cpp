#include "odometry/patch.h"

#include <algorithm>
#include <cmath>

namespace predictive_stereo {
namespace {

constexpr float kSmallestEigenvalue = 4;  // of the mean squared gradient [grey^2 / px^2]
constexpr float kStopPx = 0.015f;
constexpr float kFarthestPx = 8;  // from the start: beyond, the linearisation does not hold

// Weights of the four pixels around a sub-pixel position.
struct Bilinear {
  int x, y;
  float w00, w01, w10, w11;

  Bilinear(float px, float py)
      : x(static_cast<int>(std::floor(px))), y(static_cast<int>(std::floor(py))) {
    const float fx = px - x, fy = py - y;
    w00 = (1 - fx) * (1 - fy);
    w01 = fx * (1 - fy);
    w10 = (1 - fx) * fy;
    w11 = fx * fy;
  }
  bool inside(const cv::Mat1b& image, int columns, int rows) const {
    return x >= 0 && y >= 0 && x + columns < image.cols && y + rows < image.rows;
  }
};

// `kColumns` neighbouring samples of one row.
template <int kColumns>
void sampleRow(const cv::Mat1b& image, const Bilinear& at, int row, float* out) {
  const uchar* upper = image.ptr<uchar>(at.y + row) + at.x;
  const uchar* lower = image.ptr<uchar>(at.y + row + 1) + at.x;
  for (int i = 0; i < kColumns; ++i)
    out[i] = at.w00 * upper[i] + at.w01 * upper[i + 1] + at.w10 * lower[i] + at.w11 * lower[i + 1];
}

float sum(const float (&lanes)[Patch::kSize]) {
  float total = 0;
  for (float lane : lanes) total += lane;
  return total;
}

}  // namespace

bool Patch::sample(const cv::Mat1b& image, cv::Point2f centre, float scale) {
  constexpr int kBorder = kSize + 2;  // one more on every side, for the gradients
  float grey[kBorder][kBorder];
  const float half = 0.5f * (kBorder - 1) * scale;
  if (scale == 1) {
    const Bilinear at(centre.x - half, centre.y - half);
    if (!at.inside(image, kBorder, kBorder)) return false;
    for (int y = 0; y < kBorder; ++y) sampleRow<kBorder>(image, at, y, grey[y]);
  } else {
    if (!Bilinear(centre.x - half, centre.y - half).inside(image, 1, 1) ||
        !Bilinear(centre.x + half, centre.y + half).inside(image, 1, 1))
      return false;
    int column[kBorder];
    float column_fraction[kBorder];
    for (int x = 0; x < kBorder; ++x) {
      const float at = centre.x - half + static_cast<float>(x) * scale;
      column[x] = static_cast<int>(at);
      column_fraction[x] = at - static_cast<float>(column[x]);
    }
    for (int y = 0; y < kBorder; ++y) {
      const float at = centre.y - half + static_cast<float>(y) * scale;
      const int row = static_cast<int>(at);
      const float f = at - static_cast<float>(row);
      const uchar* upper = image.ptr<uchar>(row);
      const uchar* lower = image.ptr<uchar>(row + 1);
      for (int x = 0; x < kBorder; ++x) {
        const int c = column[x];
        const float top = upper[c] + column_fraction[x] * (upper[c + 1] - upper[c]);
        const float bottom = lower[c] + column_fraction[x] * (lower[c + 1] - lower[c]);
        grey[y][x] = top + f * (bottom - top);
      }
    }
  }

  float sum_t[kSize] = {}, sum_x[kSize] = {}, sum_y[kSize] = {};
  for (int y = 0; y < kSize; ++y) {
    const float* above = grey[y] + 1;
    const float* row = grey[y + 1] + 1;
    const float* below = grey[y + 2] + 1;
    for (int x = 0; x < kSize; ++x) {
      const float gx = 0.5f * (row[x + 1] - row[x - 1]);
      const float gy = 0.5f * (below[x] - above[x]);
      texture_[y * kSize + x] = row[x];
      gradient_x_[y * kSize + x] = gx;
      gradient_y_[y * kSize + x] = gy;
      sum_t[x] += row[x];
      sum_x[x] += gx;
      sum_y[x] += gy;
    }
  }
  const float mean_t = sum(sum_t) / kArea, mean_x = sum(sum_x) / kArea, mean_y = sum(sum_y) / kArea;
  float tt[kSize] = {}, xx[kSize] = {}, xy[kSize] = {}, yy[kSize] = {}, xt[kSize] = {},
        yt[kSize] = {};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const int i = y * kSize + x;
      const float t = texture_[i] -= mean_t;
      const float gx = gradient_x_[i] -= mean_x;
      const float gy = gradient_y_[i] -= mean_y;
      tt[x] += t * t;
      xx[x] += gx * gx;
      xy[x] += gx * gy;
      yy[x] += gy * gy;
      xt[x] += gx * t;
      yt[x] += gy * t;
    }
  texture_norm_ = std::sqrt(sum(tt));
  gradient_x_texture_ = sum(xt);
  gradient_y_texture_ = sum(yt);
  xx_ = sum(xx);
  xy_ = sum(xy);
  const float s_yy = sum(yy);
  const float determinant = xx_ * s_yy - xy_ * xy_;
  const float trace = xx_ + s_yy;
  const float smaller = 0.5f * (trace - std::sqrt(std::max(0.f, trace * trace - 4 * determinant)));
  if (!(smaller >= kSmallestEigenvalue * kArea * 0.1f) || !(determinant > 0)) return false;
  inverse_ = cv::Matx22f(s_yy, -xy_, -xy_, xx_) * (1 / determinant);
  return true;
}

Patch::Match Patch::align(const cv::Mat1b& image, cv::Point2f start, int max_iterations) const {
  constexpr float kHalf = 0.5f * (kSize - 1);
  Match match;
  match.position = start;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const Bilinear at(match.position.x - kHalf, match.position.y - kHalf);
    if (!at.inside(image, kSize, kSize)) return match;
    float s[kSize] = {}, ss[kSize] = {}, ts[kSize] = {}, xs[kSize] = {}, ys[kSize] = {};
    for (int y = 0; y < kSize; ++y) {
      float grey[kSize];
      sampleRow<kSize>(image, at, y, grey);
      const float* t = texture_ + y * kSize;
      const float* gx = gradient_x_ + y * kSize;
      const float* gy = gradient_y_ + y * kSize;
      for (int x = 0; x < kSize; ++x) {
        s[x] += grey[x];
        ss[x] += grey[x] * grey[x];
        ts[x] += t[x] * grey[x];
        xs[x] += gx[x] * grey[x];
        ys[x] += gy[x] * grey[x];
      }
    }
    const float total = sum(s);
    const float norm = std::sqrt(std::max(sum(ss) - total * total / kArea, 1e-6f));
    match.correlation = sum(ts) / (norm * texture_norm_);
    // Texture and gradients have zero mean, so the offset of brightness cancels by itself.
    const float gain = std::clamp(texture_norm_ / norm, 0.4f, 2.5f);
    const float bx = gain * sum(xs) - gradient_x_texture_;
    const float by = gain * sum(ys) - gradient_y_texture_;
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

float Patch::columnErrorFromRowError(float row_error_px) const { return -xy_ / xx_ * row_error_px; }

}  // namespace predictive_stereo
