#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "evaluation/disparity_metrics.h"
#include "evaluation/kitti_evaluation_2015.h"
#include "evaluation/sequence.h"
#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

const DisparityRange kRange;
constexpr float kX = -1.0f;  // invalid

cv::Mat1f map(int rows, int cols, const std::vector<float>& values) {
  return cv::Mat1f(values, true).reshape(1, rows).colRange(0, cols).clone();
}

void expectEqual(const cv::Mat1f& expected, const cv::Mat1f& actual) {
  ASSERT_EQ(expected.size(), actual.size());
  for (int y = 0; y < expected.rows; ++y)
    for (int x = 0; x < expected.cols; ++x)
      EXPECT_EQ(expected(y, x), actual(y, x)) << "at " << x << ", " << y;
}

TEST(InterpolateAsKitti, TakesTheSmallerSideAndTheNearestAtTheEnds) {
  cv::Mat1f disparity = map(1, 9, {kX, 7, kX, kX, 4, 9, kX, kX, kX});
  interpolateAsKitti(kRange, disparity);
  expectEqual(map(1, 9, {7, 7, 4, 4, 4, 9, 9, 9, 9}), disparity);
}

TEST(InterpolateAsKitti, TakesRowsWithoutAnyFromTheNearestRow) {
  cv::Mat1f disparity = map(7, 2,
                            {kX, kX,  //
                             1, kX,   //
                             kX, kX,  //
                             kX, kX,  //
                             kX, kX,  //
                             kX, 5,   //
                             kX, kX});
  interpolateAsKitti(kRange, disparity);
  expectEqual(map(7, 2, {1, 1, 1, 1, 1, 1, 1, 1, 5, 5, 5, 5, 5, 5}), disparity);
}

TEST(InterpolateAsKitti, LeavesAMapWithoutAny) {
  cv::Mat1f disparity = map(2, 2, {kX, kX, kX, kX});
  interpolateAsKitti(kRange, disparity);
  expectEqual(map(2, 2, {kX, kX, kX, kX}), disparity);
}

TEST(InterpolateAsKitti, KeepsDisparityZero) {
  cv::Mat1f disparity = map(1, 3, {0, kX, 3});
  interpolateAsKitti(kRange, disparity);
  expectEqual(map(1, 3, {0, 0, 3}), disparity);
}

TEST(ScoreAsKitti, CountsBackgroundAndVehicles) {
  // Errors up to 3 px, and at 100 px up to 5 %, are inliers. One pixel has no truth. Two have no
  // disparity: interpolated, one is an inlier and one is an outlier.
  const cv::Mat1f truth = map(2, 4, {10, 10, 10, kNoTruth, 100, 100, 20, 50});
  const cv::Mat1f disparity = map(2, 4, {13, 13.5, kX, 10, 104.5, 106, kX, 50});
  const cv::Mat1b vehicles = (cv::Mat1b(2, 4) << 0, 0, 0, 0, 1, 1, 1, 1);
  const KittiScore score = scoreAsKitti(disparity, kRange, truth, vehicles);
  EXPECT_EQ(3, score.background.found.truth_pixels);
  EXPECT_EQ(2, score.background.found.valid_pixels);
  EXPECT_EQ(1, score.background.found.outliers);
  EXPECT_EQ(1, score.background.interpolated.wrong());
  EXPECT_EQ(4, score.vehicles.found.truth_pixels);
  EXPECT_EQ(3, score.vehicles.found.valid_pixels);
  EXPECT_EQ(1, score.vehicles.found.outliers);
  EXPECT_EQ(2, score.vehicles.interpolated.wrong());
  EXPECT_NEAR(100.0 * 3 / 7, score.all.d1_percent(), 1e-9);
  EXPECT_NEAR(100.0 * 2 / 5, score.all.d1_valid_percent(), 1e-9);
  EXPECT_NEAR(100.0 * 5 / 7, score.all.density_percent(), 1e-9);
}

TEST(ScoreAsKitti, CountsWhatCouldNotBeInterpolatedAsWrong) {
  const cv::Mat1f truth = map(1, 2, {10, 10}), nothing = map(1, 2, {kX, kX});
  const KittiScore score = scoreAsKitti(nothing, kRange, truth, cv::Mat1b::zeros(1, 2));
  EXPECT_EQ(2, score.background.interpolated.wrong());
  EXPECT_EQ(0, score.background.found.valid_pixels);
  EXPECT_EQ(0, score.background.found.outliers);
}

TEST(ScoreAsKitti, RefusesDifferentSizes) {
  const cv::Mat1f one = map(1, 2, {1, 1}), other = map(1, 1, {1});
  EXPECT_THROW(scoreAsKitti(one, kRange, other, cv::Mat1b::zeros(1, 2)), std::invalid_argument);
  EXPECT_THROW(scoreAsKitti(one, kRange, one, cv::Mat1b::zeros(2, 2)), std::invalid_argument);
}

/// A folder with one small scene: truth 8 px on the left half, 4 px on the vehicle's right half.
class Scene2015 : public TemporaryDirectory {
 public:
  static constexpr int kWidth = 64, kHeight = 24;

  Scene2015() {
    write("calib_cam_to_cam/000003.txt",
          "P_rect_02: 100 0 32 0 0 100 12 0 0 0 1 0\nP_rect_03: 100 0 32 -50 0 100 12 0 0 0 1 0\n");
    cv::Mat1b image(kHeight, kWidth), vehicles = cv::Mat1b::zeros(kHeight, kWidth);
    cv::RNG(1).fill(image, cv::RNG::UNIFORM, 0, 256);
    vehicles.colRange(kWidth / 2, kWidth) = 3;
    cv::Mat1w truth(kHeight, kWidth, uint16_t{8 * 256});
    truth.colRange(kWidth / 2, kWidth) = 4 * 256;
    truth.row(0) = 0;
    save("image_2", image);
    save("image_3", image);
    save("obj_map", vehicles);
    save("disp_occ_0", truth);
  }
  void save(const std::string& folder, const cv::Mat& image) const {
    std::filesystem::create_directories(path(folder));
    cv::imwrite(path(folder) + "/000003_10.png", image);
  }
};

TEST(KittiScene2015, IsReadFromItsFolder) {
  const Scene2015 folder;
  ASSERT_EQ(std::vector<std::string>{"000003"}, listKittiScenes(KittiStereo::k2015, folder.path()));
  const auto scene = kittiScene(KittiStereo::k2015, folder.path(), "000003");
  ASSERT_EQ(1, scene->frames());
  const SequenceFrame pair = scene->frame(0);
  EXPECT_EQ(kNoTruth, pair.truth_px(0, 5));
  EXPECT_EQ(8.0f, pair.truth_px(1, 5));
  EXPECT_EQ(4.0f, pair.truth_px(2, 40));
  EXPECT_EQ(0, pair.vehicles(2, 5));
  EXPECT_NE(0, pair.vehicles(2, 40));
  EXPECT_NEAR(0.5, scene->rig().baseline_m, 1e-9);
}

TEST(KittiScene2015, NamesWhatIsMissing) {
  const Scene2015 folder;
  std::filesystem::remove(folder.path("obj_map/000003_10.png"));
  EXPECT_NE(std::string::npos, messageOf([&] {
                                 kittiScene(KittiStereo::k2015, folder.path(), "000003")->frame(0);
                               }).find("obj_map/000003_10.png"));
  EXPECT_THROW(listKittiScenes(KittiStereo::k2015, folder.path("image_2")), std::runtime_error);
}

/// Gives the same disparity everywhere, invalid in the first columns.
void runConstant(const MethodInput& input, MethodOutput& output) {
  EXPECT_EQ(PoseState::kLost, input.camera.ego_motion.state);
  output.maps.disparity_px = cv::Mat1f(input.frame.left.size(), 8.0f);
  output.maps.disparity_px.colRange(0, 8) = kX;
}

TEST(KittiEvaluation2015, PoolsScenes) {
  const Scene2015 folder;
  const auto scene = kittiScene(KittiStereo::k2015, folder.path(), "000003");
  const SequenceFrame pair = scene->frame(0);
  const std::vector<NamedMethod> methods = {{"constant", [] { return runConstant; }}};
  KittiEvaluation2015 evaluation(methods);
  for (int i = 0; i < 2; ++i)
    evaluation.add(scene->name(), pair, {i, stereoFrame(*scene, i, pair), {}},
                   startMethods(methods), kRange);
  ASSERT_EQ(2u, evaluation.worst().size());
  const KittiScore& score = evaluation.worst()[0].second;
  const int half = Scene2015::kWidth / 2 * (Scene2015::kHeight - 1);
  EXPECT_EQ(half, score.background.found.truth_pixels);
  EXPECT_EQ(half - 8 * (Scene2015::kHeight - 1), score.background.found.valid_pixels);
  EXPECT_EQ(0, score.background.interpolated.wrong());
  EXPECT_EQ(half, score.vehicles.interpolated.wrong());  // off by 4 px

  const Table table = evaluation.table();
  EXPECT_EQ("50.00 / 0.00 / 100.00", table.rows.at(0).at(2));
  EXPECT_EQ("57.14 / 0.00 / 100.00", table.rows.at(0).at(3));
  EXPECT_EQ("87.50 / 75.00 / 100.00", table.rows.at(0).at(4));
}

}  // namespace
}  // namespace predictive_stereo
