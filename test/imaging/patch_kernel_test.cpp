/// The SIMD kernels of patches are bit-identical to the plain reference.
#include "imaging/patch_kernel.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "imaging/patch.h"
#include "predictive_stereo/simd_target.h"
#include "simd/simd_dispatch.h"

namespace predictive_stereo {
namespace {

cv::Mat1b noise(cv::Size size) {
  cv::Mat1b image(size);
  cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

template <class Check>
void onEveryTarget(const Check& check) {
  for (const std::string& target : availableSimdTargets()) {
    SCOPED_TRACE(target);
    check(patchKernel(simdTargetBit(target)));
  }
}

void expectEqual(const FramedPatch& a, const FramedPatch& b) {
  for (int y = 0; y < kFramedSize; ++y)
    for (int x = 0; x < kFramedSize; ++x)
      ASSERT_EQ(a.grey[y * kPatchStride + x], b.grey[y * kPatchStride + x]) << x << ' ' << y;
}

TEST(PatchKernel, SamplesAsTheReference) {
  const cv::Mat1b image = noise({64, 40});
  const BilinearWeights weights{0.42f, 0.28f, 0.18f, 0.12f};
  onEveryTarget([&](const PatchKernel& kernel) {
    FramedPatch expected, framed;
    referencePatchKernel().sample(image.ptr(7) + 11, image.step, weights, expected);
    kernel.sample(image.ptr(7) + 11, image.step, weights, framed);
    expectEqual(framed, expected);
  });
}

TEST(PatchKernel, SamplesGridsAsTheReference) {
  const cv::Mat1b image = noise({64, 60});
  for (const float distance : {0.6f, 0.83f, 1.f, 1.27f, 1.6f, 2.2f}) {
    SampleGrid grid;
    for (int i = 0; i < kPatchStride; ++i) {
      const float at = 9.3f + distance * static_cast<float>(std::min(i, kFramedSize - 1));
      grid.column[i] = grid.row[i] = static_cast<int>(at);
      grid.column_fraction[i] = grid.row_fraction[i] = at - static_cast<float>(grid.row[i]);
    }
    onEveryTarget([&](const PatchKernel& kernel) {
      FramedPatch expected, framed;
      referencePatchKernel().sampleGrid(image.data, image.step, grid, expected);
      kernel.sampleGrid(image.data, image.step, grid, framed);
      expectEqual(framed, expected);
    });
  }
}

TEST(PatchKernel, DifferentiatesAndMultipliesAsTheReference) {
  const cv::Mat1b image = noise({64, 40});
  const BilinearWeights weights{0.42f, 0.28f, 0.18f, 0.12f};
  FramedPatch framed;
  referencePatchKernel().sample(image.ptr(7) + 11, image.step, weights, framed);
  PatchImages expected;
  PatchMoments moments;
  referencePatchKernel().differentiate(framed, expected, moments);
  PatchProducts products;
  referencePatchKernel().multiply(expected, image.ptr(9) + 30, image.step, weights, products);
  onEveryTarget([&](const PatchKernel& kernel) {
    PatchImages images;
    PatchMoments m;
    kernel.differentiate(framed, images, m);
    for (int i = 0; i < kPatchSize * kPatchStride; ++i) {
      if (i % kPatchStride >= kPatchSize) continue;  // short vectors do not write the padding
      ASSERT_EQ(images.texture[i], expected.texture[i]) << i;
      ASSERT_EQ(images.gradient_x[i], expected.gradient_x[i]) << i;
      ASSERT_EQ(images.gradient_y[i], expected.gradient_y[i]) << i;
    }
    EXPECT_EQ(m.tt, moments.tt);
    EXPECT_EQ(m.xx, moments.xx);
    EXPECT_EQ(m.xy, moments.xy);
    EXPECT_EQ(m.yy, moments.yy);
    EXPECT_EQ(m.xt, moments.xt);
    EXPECT_EQ(m.yt, moments.yt);
    PatchProducts p;
    kernel.multiply(images, image.ptr(9) + 30, image.step, weights, p);
    EXPECT_EQ(p.grey, products.grey);
    EXPECT_EQ(p.grey_grey, products.grey_grey);
    EXPECT_EQ(p.texture_grey, products.texture_grey);
    EXPECT_EQ(p.x_grey, products.x_grey);
    EXPECT_EQ(p.y_grey, products.y_grey);
  });
}

// At an image's border, where vectors would reach beyond it: a separate image gives the same result
// as a part of a larger one (and address sanitizers detect reads outside).
TEST(PatchKernel, PatchesAtTheBorderAreTheSame) {
  const cv::Mat1b large = noise({80, 60});
  const cv::Mat1b small = large(cv::Rect(0, 0, 50, 40)).clone();
  for (const float scale : {1.f, 0.7f, 1.3f})
    for (int column = 30; column < 50; ++column) {
      const cv::Point2f centre(static_cast<float>(column) + 0.3f, 27.4f);
      Patch in_small, in_large;
      if (!in_small.sample(small, centre, scale)) continue;
      ASSERT_TRUE(in_large.sample(large, centre, scale));
      EXPECT_EQ(in_small.covariance(), in_large.covariance());
      const cv::Point2f start = centre + cv::Point2f(0.4f, -0.3f);
      const Patch::Match a = in_small.align(small, start, 1), b = in_large.align(large, start, 1);
      if (a.correlation != 0) {
        EXPECT_EQ(a.position, b.position);
      }
    }
}

}  // namespace
}  // namespace predictive_stereo
