#include "tools/kitti_drive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(KittiDrive, ReadsRigImagesAndCapsToImages) {
  const KittiFixture files(3);
  const KittiDrive drive(files.path(), KittiFixture::kDrive);
  EXPECT_EQ(drive.frames(), 3);
  EXPECT_EQ(drive.rig().size, cv::Size(64, 32));
  EXPECT_DOUBLE_EQ(drive.rig().baseline_m, 0.5);
  EXPECT_EQ(drive.left(2)(0, 0), 20);
  EXPECT_EQ(drive.right(2)(0, 0), 21);
  EXPECT_EQ(drive.stamps("image_00").size(), 3u);
}

TEST(KittiDrive, ColourPairHasItsOwnBaselineAndPosition) {
  const KittiFixture files;
  const KittiDrive drive(files.path(), KittiFixture::kDrive, 2);
  EXPECT_DOUBLE_EQ(drive.rig().baseline_m, 0.5);
  EXPECT_NEAR(drive.T_cam_velo().translation().x(), 0.06, 1e-12);
  EXPECT_EQ(drive.left(1)(0, 0), 12);
}

TEST(KittiDrive, FramesMayStartLater) {
  const KittiFixture files(3);
  std::filesystem::remove(files.file("image_00", 0, "png"));
  std::filesystem::remove(files.file("image_01", 0, "png"));
  const KittiDrive drive(files.path(), KittiFixture::kDrive);
  EXPECT_EQ(drive.frames(), 2);
  EXPECT_EQ(drive.fileNumber(0), 1);
  EXPECT_EQ(drive.left(0)(0, 0), 10);
  EXPECT_EQ(drive.stamps("image_00")[0] % 10000000000, 1500000001);
}

TEST(KittiDrive, NamesWhatIsMissing) {
  const KittiFixture files(3);
  EXPECT_EQ(messageOf([&] { KittiDrive("/no/such/folder", "x"); }),
            "/no/such/folder: folder not found");
  EXPECT_EQ(messageOf([&] { KittiDrive(files.path(), "no_drive"); }),
            files.path("no_drive: folder not found"));
  std::filesystem::remove(files.file("image_01", 1, "png"));
  EXPECT_TRUE(contains(messageOf([&] { KittiDrive(files.path(), KittiFixture::kDrive); }),
                       "image_01/data/0000000001.png: is missing"));
  std::filesystem::remove(files.path("calib_cam_to_cam.txt"));
  EXPECT_TRUE(contains(messageOf([&] { KittiDrive(files.path(), KittiFixture::kDrive); }),
                       "calib_cam_to_cam.txt: cannot be read"));
}

TEST(KittiDrive, NamesBrokenCalibrationEntries) {
  const KittiFixture files;
  files.write("calib_cam_to_cam.txt", "K_00: 1 2 3\n");
  EXPECT_TRUE(contains(messageOf([&] { KittiDrive(files.path(), KittiFixture::kDrive); }),
                       "K_00 has 3 numbers, expected 9"));
}

TEST(KittiDrive, NamesFilesWithNumbersThatAreNone) {
  const KittiFixture files;
  files.write(KittiFixture::data("image_00/data/9999999999.png"), "");
  EXPECT_TRUE(contains(messageOf([&] { KittiDrive(files.path(), KittiFixture::kDrive); }),
                       "9999999999.png: its number is too large"));
}

TEST(KittiDrive, NamesBrokenScansAndImages) {
  const KittiFixture files;
  const KittiDrive drive(files.path(), KittiFixture::kDrive);
  EXPECT_FALSE(drive.hasLidar(0));
  files.write(KittiFixture::data("velodyne_points/data/0000000000.bin"), "abc");
  EXPECT_TRUE(drive.hasLidar(0));
  EXPECT_TRUE(contains(messageOf([&] { drive.lidar(0); }), "has 3 bytes"));
  files.write(KittiFixture::data("image_00/data/0000000001.png"), "no image");
  EXPECT_TRUE(
      contains(messageOf([&] { drive.left(1); }), "0000000001.png: cannot be read as an image"));
  files.write(KittiFixture::data("image_00/data/0000000000.png"), "no image");
  EXPECT_TRUE(contains(messageOf([&] { KittiDrive(files.path(), KittiFixture::kDrive); }),
                       "0000000000.png: cannot be read as an image"));
}

TEST(KittiTimestamps, ReadsNanosecondsAndStopsBeforeWhatIsNotNeeded) {
  const TemporaryDirectory files;
  const std::string path = files.write("timestamps.txt",
                                       "1970-01-02 00:00:01.000000002\r\n"
                                       "\n"
                                       "2011-09-26 13:08:24.973999360\n"
                                       "2011-09-26 13:08:25\n"
                                       "garbage\n");
  EXPECT_EQ(readKittiTimestamps(path, 3),
            (std::vector<int64_t>{86401000000002, 1317042504973999360, 1317042505000000000}));
  EXPECT_TRUE(contains(messageOf([&] { readKittiTimestamps(path, 4); }), "line 5 \"garbage\""));
}

TEST(KittiTimestamps, YearsThatRosCannotHoldAreRefused) {
  const TemporaryDirectory files;
  const std::string path =
      files.write("timestamps.txt", "2105-12-31 23:59:60\n9999-12-31 23:59:59\n");
  EXPECT_EQ(readKittiTimestamps(path, 1)[0], 4291747200000000000);
  EXPECT_TRUE(contains(messageOf([&] { readKittiTimestamps(path, 2); }), "line 2 \"9999-"));
}

TEST(KittiTimestamps, PartsOfAStampAreRefused) {
  const TemporaryDirectory files;
  for (const std::string line :
       {"1970-01", "2011-09-26", "2011-09-26 13:08", "2011-9-26 13:08:24", "2011-09-26 13:08:24.",
        "2011-09-26 13:08:24.0000000001", "2011-09-26 13:08:24.9x", "2011-13-26 13:08:24"}) {
    const std::string path = files.write("timestamps.txt", line + "\n");
    EXPECT_TRUE(contains(messageOf([&] { readKittiTimestamps(path, 1); }),
                         "line 1 \"" + line + "\" is not a time stamp"))
        << line;
  }
}

TEST(KittiTimestamps, TooFewAreRefused) {
  const KittiFixture files(3);
  files.write(KittiFixture::data("image_00/timestamps.txt"), "2011-09-26 13:08:24.9\n");
  const KittiDrive drive(files.path(), KittiFixture::kDrive);
  EXPECT_TRUE(contains(messageOf([&] { drive.stamps("image_00"); }), "has 1 time stamps"));
}

OxtsRecord record(double latitude_deg, double longitude_deg, double yaw_rad) {
  OxtsRecord oxts{};
  oxts.fields[0] = latitude_deg;
  oxts.fields[1] = longitude_deg;
  oxts.fields[2] = 100;
  oxts.fields[5] = yaw_rad;
  return oxts;
}

TEST(Oxts, MetresPerDegreeAreThoseOfTheGlobe) {
  // One second of arc is 30.92 m on a globe of radius 6378137 m, times cos(latitude) to the east.
  const double step_deg = 1.0 / 3600;
  const auto poses = posesFromOxts(
      {record(49, 8, 0), record(49 + step_deg, 8, 0), record(49, 8 + step_deg, M_PI / 2)});
  EXPECT_NEAR(poses[0].translation().norm(), 0, 1e-9);
  EXPECT_NEAR(poses[1].translation().y(), 30.922, 0.001);
  EXPECT_NEAR(poses[1].translation().x(), 0, 1e-6);
  EXPECT_NEAR(poses[2].translation().x(), 30.922 * std::cos(49 * M_PI / 180), 0.001);
  EXPECT_TRUE((poses[2].linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
}

TEST(KittiDrive, PosesComeFromOxtsOrFromTruthOrAreNone) {
  const KittiFixture files(2);
  const KittiDrive drive(files.path(), KittiFixture::kDrive);
  EXPECT_FALSE(drive.poses());
  files.write(KittiFixture::data("oxts/data/0000000000.txt"), oxtsText(0, 8));
  files.write(KittiFixture::data("oxts/data/0000000001.txt"), oxtsText(0, 8.00001));
  const auto from_oxts = drive.poses();
  ASSERT_TRUE(from_oxts);
  // The car moves 0.73 m to the east, which is forward (z) in the camera's frame.
  const Eigen::Isometry3d motion = (*from_oxts)[0].inverse() * (*from_oxts)[1];
  EXPECT_NEAR(motion.translation().z(), 0.7303, 1e-3);
  EXPECT_NEAR(motion.translation().head<2>().norm(), 0, 1e-5);
  // The unit is at (-0.8, 0.3, -0.8) in the scanner's frame, (-0.3, 0.8, -0.8) in camera axes. The
  // scanner is at (0, -0.1, -0.3) in the camera's frame.
  EXPECT_TRUE(((*from_oxts)[0].inverse() * Eigen::Vector3d(0, 0, 0))
                  .isApprox(Eigen::Vector3d(-0.3, 0.7, -1.1), 1e-9));

  files.write(KittiFixture::data("poses_gt_cam0.txt"),
              "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2.5\n");
  EXPECT_DOUBLE_EQ((*drive.poses())[1].translation().z(), 2.5);
  files.write(KittiFixture::data("poses_gt_cam0.txt"), "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0\n");
  EXPECT_TRUE(contains(messageOf([&] { drive.poses(); }), "line 2"));
}

}  // namespace
}  // namespace predictive_stereo
