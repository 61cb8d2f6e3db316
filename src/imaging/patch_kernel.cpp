#include "imaging/patch_kernel.h"

#include <algorithm>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "imaging/patch_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

PREDICTIVE_STEREO_BEGIN_KERNELS;

namespace {

#if PREDICTIVE_STEREO_HAS_VECTORS

// A row of twelve columns is 8 + 4 or 4 + 4 + 4.
using D = hn::CappedTag<float, 8>;
using V = hn::VFromD<D>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
constexpr int kVectors = (kPatchSize + kLanes - 1) / kLanes;
constexpr int kFramedVectors = kPatchStride / kLanes;
static_assert(kLanes == 4 || kLanes == 8, "rows are written for these");

HWY_INLINE V load(const uint8_t* grey) {
  const hn::Rebind<uint8_t, D> d8;
  const hn::Rebind<int32_t, D> d32;
  return hn::ConvertTo(D(), hn::PromoteTo(d32, hn::LoadU(d8, grey)));
}

// Sets the lanes of a row's last vector that are beyond the patch to zero.
HWY_INLINE V withinPatch(int vector, V v) {
  if ((vector + 1) * kLanes <= kPatchSize) return v;
  return hn::IfThenElseZero(hn::FirstN(D(), kPatchSize - kLanes), v);
}

template <class V4>
HWY_INLINE float sumOfFour(V4 v) {
  v = hn::Add(v, hn::Shuffle1032(v));
  return hn::GetLane(hn::Add(v, hn::Shuffle2301(v)));
}

// In the same order as the reference.
template <class V8>
HWY_INLINE float sumOfColumns(const V8 (&v)[2]) {
  const hn::CappedTag<float, 4> d4;
  const V8 sum = hn::Add(v[0], v[1]);
  return sumOfFour(hn::Add(hn::LowerHalf(d4, sum), hn::UpperHalf(d4, sum)));
}
template <class V4>
HWY_INLINE float sumOfColumns(const V4 (&v)[3]) {
  return sumOfFour(hn::Add(hn::Add(v[0], v[2]), v[1]));
}

// The sum of each column, and their total.
struct ColumnSums {
  V v[kVectors];

  HWY_INLINE ColumnSums() {
    for (V& sum : v) sum = hn::Zero(D());
  }
  HWY_INLINE void add(int vector, V values) { v[vector] = hn::Add(v[vector], values); }
  HWY_INLINE float total() const { return sumOfColumns(v); }
};

HWY_INLINE V blend(const V (&weights)[4], V upper, V upper_next, V lower, V lower_next) {
  return hn::Add(hn::Add(hn::Add(hn::Mul(weights[0], upper), hn::Mul(weights[1], upper_next)),
                         hn::Mul(weights[2], lower)),
                 hn::Mul(weights[3], lower_next));
}

void multiply(const PatchImages& patch, const uint8_t* corner, size_t step,
              const BilinearWeights& weights, PatchProducts& products) {
  const D d;
  const V w[4] = {hn::Set(d, weights.w00), hn::Set(d, weights.w01), hn::Set(d, weights.w10),
                  hn::Set(d, weights.w11)};
  ColumnSums grey, grey_grey, texture_grey, x_grey, y_grey;
  for (int k = 0; k < kVectors; ++k) {
    const uint8_t* row = corner + k * kLanes;
    V upper = load(row), upper_next = load(row + 1);
    for (int y = 0; y < kPatchSize; ++y) {
      row += step;
      const V lower = load(row), lower_next = load(row + 1);
      const V g = withinPatch(k, blend(w, upper, upper_next, lower, lower_next));
      const int i = y * kPatchStride + k * kLanes;
      grey.add(k, g);
      grey_grey.add(k, hn::Mul(g, g));
      texture_grey.add(k, hn::Mul(hn::Load(d, patch.texture + i), g));
      x_grey.add(k, hn::Mul(hn::Load(d, patch.gradient_x + i), g));
      y_grey.add(k, hn::Mul(hn::Load(d, patch.gradient_y + i), g));
      upper = lower;
      upper_next = lower_next;
    }
  }
  products = {grey.total(), grey_grey.total(), texture_grey.total(), x_grey.total(),
              y_grey.total()};
}

void sample(const uint8_t* corner, size_t step, const BilinearWeights& weights,
            FramedPatch& framed) {
  const D d;
  const V w[4] = {hn::Set(d, weights.w00), hn::Set(d, weights.w01), hn::Set(d, weights.w10),
                  hn::Set(d, weights.w11)};
  for (int k = 0; k < kFramedVectors; ++k) {
    const uint8_t* row = corner + k * kLanes;
    V upper = load(row), upper_next = load(row + 1);
    for (int y = 0; y < kFramedSize; ++y) {
      row += step;
      const V lower = load(row), lower_next = load(row + 1);
      hn::Store(blend(w, upper, upper_next, lower, lower_next), d,
                framed.grey + y * kPatchStride + k * kLanes);
      upper = lower;
      upper_next = lower_next;
    }
  }
}

// Looks columns up in bytes: gathering floats took 1.5 times as long.
void sampleGrid(const uint8_t* image, size_t step, const SampleGrid& grid, FramedPatch& framed) {
  const D d;
  const hn::FixedTag<uint8_t, kPatchStride> d8;
  static_assert(kReadGridColumns == 2 * kPatchStride + 1, "of two tables, and those beside");
  const int first = grid.column[0];
  // An index above 127 gives 0.
  alignas(16) uint8_t in_low[kPatchStride], in_high[kPatchStride];
  for (int i = 0; i < kPatchStride; ++i) {
    const int column = grid.column[i] - first;
    in_low[i] = static_cast<uint8_t>(column < kPatchStride ? column : 255);
    in_high[i] = static_cast<uint8_t>(column - kPatchStride);
  }
  const auto low = hn::Load(d8, in_low), high = hn::Load(d8, in_high);
  const auto pick = [&](const uint8_t* row, uint8_t* picked) HWY_ATTR {
    hn::Store(hn::Or(hn::TableLookupBytesOr0(hn::LoadU(d8, row), low),
                     hn::TableLookupBytesOr0(hn::LoadU(d8, row + kPatchStride), high)),
              d8, picked);
  };
  alignas(16) uint8_t upper[kPatchStride], upper_next[kPatchStride], lower[kPatchStride],
      lower_next[kPatchStride];
  for (int y = 0; y < kFramedSize; ++y) {
    const uint8_t* row = image + grid.row[y] * step + first;
    pick(row, upper);
    pick(row + 1, upper_next);
    pick(row + step, lower);
    pick(row + step + 1, lower_next);
    const V down = hn::Set(d, grid.row_fraction[y]);
    for (int i = 0; i < kPatchStride; i += kLanes) {
      const V top = load(upper + i), top_next = load(upper_next + i);
      const V left = hn::Add(top, hn::Mul(down, hn::Sub(load(lower + i), top)));
      const V right = hn::Add(top_next, hn::Mul(down, hn::Sub(load(lower_next + i), top_next)));
      const V across = hn::LoadU(d, grid.column_fraction + i);
      hn::Store(hn::Add(left, hn::Mul(across, hn::Sub(right, left))), d,
                framed.grey + y * kPatchStride + i);
    }
  }
}

void differentiate(const FramedPatch& framed, PatchImages& images, PatchMoments& moments) {
  const D d;
  const V half = hn::Set(d, 0.5f);
  ColumnSums t, x, y;
  for (int k = 0; k < kVectors; ++k)
    for (int row = 0; row < kPatchSize; ++row) {
      const float* middle = framed.grey + (row + 1) * kPatchStride + k * kLanes;
      const V grey = withinPatch(k, hn::LoadU(d, middle + 1));
      const V gx =
          withinPatch(k, hn::Mul(half, hn::Sub(hn::LoadU(d, middle + 2), hn::Load(d, middle))));
      const V gy = withinPatch(k, hn::Mul(half, hn::Sub(hn::LoadU(d, middle + 1 + kPatchStride),
                                                        hn::LoadU(d, middle + 1 - kPatchStride))));
      const int i = row * kPatchStride + k * kLanes;
      hn::Store(grey, d, images.texture + i);
      hn::Store(gx, d, images.gradient_x + i);
      hn::Store(gy, d, images.gradient_y + i);
      t.add(k, grey);
      x.add(k, gx);
      y.add(k, gy);
    }
  constexpr float kArea = kPatchSize * kPatchSize;
  const V mean_t = hn::Set(d, t.total() / kArea), mean_x = hn::Set(d, x.total() / kArea),
          mean_y = hn::Set(d, y.total() / kArea);
  ColumnSums tt, xx, xy, yy, xt, yt;
  for (int k = 0; k < kVectors; ++k)
    for (int row = 0; row < kPatchSize; ++row) {
      const int i = row * kPatchStride + k * kLanes;
      const V grey = withinPatch(k, hn::Sub(hn::Load(d, images.texture + i), mean_t));
      const V gx = withinPatch(k, hn::Sub(hn::Load(d, images.gradient_x + i), mean_x));
      const V gy = withinPatch(k, hn::Sub(hn::Load(d, images.gradient_y + i), mean_y));
      hn::Store(grey, d, images.texture + i);
      hn::Store(gx, d, images.gradient_x + i);
      hn::Store(gy, d, images.gradient_y + i);
      tt.add(k, hn::Mul(grey, grey));
      xx.add(k, hn::Mul(gx, gx));
      xy.add(k, hn::Mul(gx, gy));
      yy.add(k, hn::Mul(gy, gy));
      xt.add(k, hn::Mul(gx, grey));
      yt.add(k, hn::Mul(gy, grey));
    }
  moments = {tt.total(), xx.total(), xy.total(), yy.total(), xt.total(), yt.total()};
}

const PatchKernel& kernel() {
  static const PatchKernel vectors = {multiply, sample, sampleGrid, differentiate};
  return vectors;
}

#else

const PatchKernel& kernel() { return referencePatchKernel(); }

#endif

}  // namespace
PREDICTIVE_STEREO_END_KERNELS;

#if HWY_ONCE
namespace predictive_stereo {
namespace {

HWY_EXPORT(kernel);

using Columns = float[kPatchStride];

float sumOfColumns(const Columns& columns) {
  float eight[8], four[4];
  for (int i = 0; i < 8; ++i) eight[i] = columns[i] + columns[i + 8];
  for (int i = 0; i < 4; ++i) four[i] = eight[i] + eight[i + 4];
  return (four[0] + four[2]) + (four[1] + four[3]);
}

float blend(const BilinearWeights& w, const uint8_t* upper, const uint8_t* lower) {
  return w.w00 * upper[0] + w.w01 * upper[1] + w.w10 * lower[0] + w.w11 * lower[1];
}

void multiplyReference(const PatchImages& patch, const uint8_t* corner, size_t step,
                       const BilinearWeights& weights, PatchProducts& products) {
  Columns grey = {}, grey_grey = {}, texture_grey = {}, x_grey = {}, y_grey = {};
  for (int y = 0; y < kPatchSize; ++y, corner += step)
    for (int x = 0; x < kPatchSize; ++x) {
      const float g = blend(weights, corner + x, corner + step + x);
      const int i = y * kPatchStride + x;
      grey[x] += g;
      grey_grey[x] += g * g;
      texture_grey[x] += patch.texture[i] * g;
      x_grey[x] += patch.gradient_x[i] * g;
      y_grey[x] += patch.gradient_y[i] * g;
    }
  products = {sumOfColumns(grey), sumOfColumns(grey_grey), sumOfColumns(texture_grey),
              sumOfColumns(x_grey), sumOfColumns(y_grey)};
}

void sampleReference(const uint8_t* corner, size_t step, const BilinearWeights& weights,
                     FramedPatch& framed) {
  for (int y = 0; y < kFramedSize; ++y, corner += step)
    for (int x = 0; x < kFramedSize; ++x)
      framed.grey[y * kPatchStride + x] = blend(weights, corner + x, corner + step + x);
}

void sampleGridReference(const uint8_t* image, size_t step, const SampleGrid& grid,
                         FramedPatch& framed) {
  for (int y = 0; y < kFramedSize; ++y)
    for (int x = 0; x < kFramedSize; ++x) {
      const uint8_t* upper = image + grid.row[y] * step + grid.column[x];
      const uint8_t* lower = upper + step;
      const float f = grid.row_fraction[y];
      const float left = static_cast<float>(upper[0]) + f * static_cast<float>(lower[0] - upper[0]);
      const float right =
          static_cast<float>(upper[1]) + f * static_cast<float>(lower[1] - upper[1]);
      framed.grey[y * kPatchStride + x] = left + grid.column_fraction[x] * (right - left);
    }
}

void differentiateReference(const FramedPatch& framed, PatchImages& images, PatchMoments& moments) {
  images = PatchImages();
  Columns t = {}, gx = {}, gy = {};
  for (int y = 0; y < kPatchSize; ++y)
    for (int x = 0; x < kPatchSize; ++x) {
      const float* at = framed.grey + (y + 1) * kPatchStride + x + 1;
      const int i = y * kPatchStride + x;
      images.texture[i] = at[0];
      images.gradient_x[i] = 0.5f * (at[1] - at[-1]);
      images.gradient_y[i] = 0.5f * (at[kPatchStride] - at[-kPatchStride]);
      t[x] += images.texture[i];
      gx[x] += images.gradient_x[i];
      gy[x] += images.gradient_y[i];
    }
  constexpr float kArea = kPatchSize * kPatchSize;
  const float mean_t = sumOfColumns(t) / kArea, mean_x = sumOfColumns(gx) / kArea,
              mean_y = sumOfColumns(gy) / kArea;
  Columns tt = {}, xx = {}, xy = {}, yy = {}, xt = {}, yt = {};
  for (int y = 0; y < kPatchSize; ++y)
    for (int x = 0; x < kPatchSize; ++x) {
      const int i = y * kPatchStride + x;
      const float grey = images.texture[i] -= mean_t;
      const float by_x = images.gradient_x[i] -= mean_x;
      const float by_y = images.gradient_y[i] -= mean_y;
      tt[x] += grey * grey;
      xx[x] += by_x * by_x;
      xy[x] += by_x * by_y;
      yy[x] += by_y * by_y;
      xt[x] += by_x * grey;
      yt[x] += by_y * grey;
    }
  moments = {sumOfColumns(tt), sumOfColumns(xx), sumOfColumns(xy),
             sumOfColumns(yy), sumOfColumns(xt), sumOfColumns(yt)};
}

}  // namespace

const PatchKernel& referencePatchKernel() {
  static const PatchKernel reference = {multiplyReference, sampleReference, sampleGridReference,
                                        differentiateReference};
  return reference;
}

const PatchKernel& patchKernel(int64_t target_bit) {
  if (target_bit == kScalarTarget) return referencePatchKernel();
  return PREDICTIVE_STEREO_DISPATCH(kernel, target_bit)();
}

const PatchKernel& patchKernelInUse() { return patchKernel(simdTargetBitInUse()); }

}  // namespace predictive_stereo
#endif
