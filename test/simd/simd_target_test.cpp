/// The choice of the SIMD target applies to every kernel of the process.
#include "predictive_stereo/simd_target.h"

#include <cstdlib>

#include "simd/simd_dispatch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/simd_target_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace predictive_stereo {
namespace HWY_NAMESPACE {

int64_t compiledFor() { return HWY_TARGET; }

}  // namespace HWY_NAMESPACE
}  // namespace predictive_stereo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "evaluation/simulation/street.h"
#include "imaging/patch_kernel.h"
#include "odometry/block_kernel.h"
#include "predictive_stereo/pipeline.h"

namespace predictive_stereo {
namespace {

HWY_EXPORT(compiledFor);

PipelineParams paramsFor(const std::string& target) {
  PipelineParams params;
  params.disparity.matcher.range.count = 64;
  params.disparity.matcher.simd_target = target;
  return params;
}

void expectAllUse(const std::string& target) {
  SCOPED_TRACE(target);
  const int64_t bit = simdTargetBit(target);
  EXPECT_EQ(simdTargetBitInUse(), bit);
  EXPECT_EQ(HWY_DYNAMIC_DISPATCH(compiledFor)(), bit == kScalarTarget ? HWY_STATIC_TARGET : bit);
  EXPECT_EQ(PREDICTIVE_STEREO_DISPATCH(compiledFor, bit)(), HWY_DYNAMIC_DISPATCH(compiledFor)());
  EXPECT_EQ(&patchKernelInUse(), &patchKernel(bit));
  EXPECT_EQ(blockKernelInUse(), blockKernel(bit));
}

class SimdTarget : public testing::Test {
 protected:
  void TearDown() override {
    unsetenv("PREDICTIVE_STEREO_SIMD");
    useSimdTarget("auto");
  }
};

TEST_F(SimdTarget, IsThatOfTheMatcherForAllKernels) {
  for (const std::string& target : availableSimdTargets()) {
    const Pipeline pipeline(paramsFor(target));
    EXPECT_EQ(pipeline.disparity().simdTarget(), target);
    expectAllUse(target);
  }
  Pipeline pipeline(paramsFor("auto"));
  expectAllUse(availableSimdTargets().front());
  pipeline.setParams(paramsFor("scalar").disparity);
  expectAllUse("scalar");
}

TEST_F(SimdTarget, IsThatOfTheEnvironmentForAllKernels) {
  setenv("PREDICTIVE_STEREO_SIMD", "scalar", 1);
  useSimdTarget("auto");
  expectAllUse("scalar");
  useSimdTarget(availableSimdTargets().front());  // a target by name has priority
  expectAllUse(availableSimdTargets().front());
}

TEST_F(SimdTarget, StaysWhereTheNameIsUnknown) {
  useSimdTarget("scalar");
  EXPECT_THROW(useSimdTarget("mmx"), std::invalid_argument);
  EXPECT_THROW(Pipeline{paramsFor("mmx")}, std::invalid_argument);
  expectAllUse("scalar");
}

TEST_F(SimdTarget, OfAutoIsAvx2RatherThanAvx512) {
  const std::vector<std::string> available = availableSimdTargets();
  const auto has = [&](const char* name) {
    return std::find(available.begin(), available.end(), name) != available.end();
  };
  if (!has("avx3")) GTEST_SKIP() << "this CPU has no AVX-512";
  ASSERT_TRUE(has("avx2"));
  useSimdTarget("auto");
  expectAllUse("avx2");
  useSimdTarget("avx3");
  expectAllUse("avx3");
}

TEST_F(SimdTarget, CanBeWhatTheCompilerMayUseEverywhere) {
  EXPECT_EQ(runnableSimdTargets(0), HWY_STATIC_TARGET);  // e.g. NEON, also if Highway detects none
  EXPECT_EQ(runnableSimdTargets(HWY_TARGETS), HWY_TARGETS);
  EXPECT_EQ(runnableSimdTargets(~int64_t{0}), HWY_TARGETS) << "what is not compiled cannot run";
}

TEST_F(SimdTarget, OfSlowProcessesIsToldWithTheCure) {
  for (const std::string& target : availableSimdTargets())
    EXPECT_EQ(slowTargetWarning("auto", target).empty(), target != "scalar") << target;
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(has(slowTargetWarning("scalar", "scalar"), "set simd_target to auto"));
  EXPECT_TRUE(has(slowTargetWarning("auto", "scalar"), "CPU"));
  setenv("PREDICTIVE_STEREO_SIMD", "scalar", 1);
  EXPECT_TRUE(has(slowTargetWarning("auto", "scalar"), "unset the environment variable"));
  setenv("PREDICTIVE_STEREO_SIMD", "auto", 1);
  EXPECT_TRUE(has(slowTargetWarning("auto", "scalar"), "CPU"));
}

TEST_F(SimdTarget, ChangesNoResult) {
  StreetParams street_params;
  street_params.scene = "near_half_moves";
  street_params.width = 434;
  street_params.height = 146;
  const Street street(street_params);
  std::vector<StreetFrame> frames;
  for (int k = 0; k < 5; ++k) frames.push_back(street.render(20 + k));
  std::vector<PipelineOutput> outputs;
  for (const std::string& target : availableSimdTargets()) {
    Pipeline pipeline(paramsFor(target));
    PipelineOutput output;
    for (const StreetFrame& frame : frames)
      pipeline.process({frame.left, frame.right, street.rig(), stampFromSeconds(frame.stamp_s)},
                       output);
    outputs.push_back(output);
  }
  const PipelineOutput& scalar = outputs.back();
  EXPECT_TRUE(scalar.disparity.predicted);
  EXPECT_GT(cv::countNonZero(scalar.detections.mask), 0) << "something moves";
  for (const PipelineOutput& output : outputs) {
    EXPECT_TRUE(output.pose.T_odom_cam.isApprox(scalar.pose.T_odom_cam, 0));
    for (const auto& [a, b] :
         {std::pair<cv::Mat, cv::Mat>{output.disparity.disparity_px, scalar.disparity.disparity_px},
          {output.disparity.disparity_variance_px2, scalar.disparity.disparity_variance_px2},
          {output.detections.mask, scalar.detections.mask}})
      EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0);
  }
}

}  // namespace
}  // namespace predictive_stereo
#endif
