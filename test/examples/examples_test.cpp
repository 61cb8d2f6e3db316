/// Builds the example with its own CMakeLists.txt against the installed package, and runs it.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "evaluation/simulation/street.h"
#include "tools/tool_fixture.h"

namespace predictive_stereo {
namespace {

struct ExamplesTest : ToolTest {
  void mustRun(const std::string& command) {
    const Result result = run(command);
    ASSERT_EQ(result.status, 0) << command << "\n" << result.out << result.errors;
  }
};

TEST_F(ExamplesTest, StereoSequenceFollowsTheCamera) {
  const std::string cmake = CMAKE_PROGRAM, installed = files_.path("installed"),
                    build = files_.path("build");
  mustRun(cmake + " --install " BUILD_FOLDER " --component core --prefix " + installed);
  mustRun(cmake + " -S " EXAMPLES_FOLDER " -B " + build + " -DCMAKE_CXX_COMPILER=" COMPILER +
          " -DCMAKE_CXX_FLAGS='" SANITIZER_FLAGS "' -DCMAKE_PREFIX_PATH=" + installed);
  mustRun(cmake + " --build " + build);
  // Without LD_LIBRARY_PATH, in which catkin's environment has the library of the build folder.
  const Result libraries = run("env -u LD_LIBRARY_PATH ldd " + build + "/stereo_sequence");
  ASSERT_NE(libraries.out.find(installed + "/lib"), std::string::npos) << libraries.out;

  StreetParams params;
  params.width = 400;
  params.height = 120;
  params.frames = 8;
  const Street street(params);
  for (int i = 0; i < params.frames; ++i) {
    const StreetFrame frame = street.render(i);
    cv::imwrite(files_.path(cv::format("left_%04d.png", i)), frame.left);
    cv::imwrite(files_.path(cv::format("right_%04d.png", i)), frame.right);
  }
  const StereoRig& rig = street.rig();
  const std::string command =
      "env -u LD_LIBRARY_PATH " + build + "/stereo_sequence " + files_.path("left_%04d.png ") +
      files_.path("right_%04d.png ") +
      cv::format("%f %f %f %f 10", rig.fx_px, rig.cx_left_px, rig.cy_px, rig.baseline_m);
  const Result result = run(command);
  ASSERT_EQ(result.status, 0) << result.errors;

  const size_t last = result.out.find("frame 7:");
  ASSERT_NE(last, std::string::npos) << result.out;
  double known_percent = 0;
  Eigen::Vector3d camera_m;
  ASSERT_EQ(std::sscanf(result.out.c_str() + last,
                        "frame 7: disparity at %lf %% of the pixels, camera at %lf %lf %lf",
                        &known_percent, &camera_m.x(), &camera_m.y(), &camera_m.z()),
            4)
      << result.out;
  EXPECT_GT(known_percent, 80);
  const Eigen::Vector3d truth_m = (street.poseOf(0).inverse() * street.poseOf(7)).translation();
  EXPECT_GT(truth_m.norm(), 3);
  EXPECT_LT((camera_m - truth_m).norm(), 0.05 * truth_m.norm()) << camera_m.transpose();

  std::filesystem::remove(files_.path("right_0004.png"));
  const Result without = run(command);
  EXPECT_EQ(without.status, 1);
  EXPECT_NE(without.errors.find("right image is 0x0 but"), std::string::npos) << without.errors;
}

}  // namespace
}  // namespace predictive_stereo
