#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <filesystem>

#include "recording.h"
#include "tools/bag_check.h"

namespace predictive_stereo {
namespace {

class CheckBag : public testing::Test {
 protected:
  CheckBag()
      : path_(std::filesystem::temp_directory_path() /
              ("check_bag_test_" + std::to_string(getpid()) + ".bag")) {}
  ~CheckBag() override { std::filesystem::remove(path_); }

  BagCheck check(const Recording& recording, const StereoTopicChoice& choice = {}) {
    write(recording, path_.string());
    const rosbag::Bag bag(path_.string());
    return checkBag(bag, choice);
  }

  const std::filesystem::path path_;
};

std::string findingsOf(const BagCheck& check, BagFinding::Level level) {
  std::string text;
  for (const BagFinding& finding : check.findings)
    if (finding.level == level) text += finding.text + "\n";
  return text;
}
std::string faults(const BagCheck& check) { return findingsOf(check, BagFinding::Level::kFault); }
std::string advice(const BagCheck& check) { return findingsOf(check, BagFinding::Level::kAdvice); }

bool hasArgument(const BagCheck& check, const std::string& argument) {
  return std::count(check.arguments.begin(), check.arguments.end(), argument) == 1;
}

#define EXPECT_SAYS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST_F(CheckBag, FindsNothingWrongWithAGoodBag) {
  const BagCheck result = check({});
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_EQ(advice(result), "");
  EXPECT_SAYS(findingsOf(result, BagFinding::Level::kGood), "nearer than 0.24 m");
  EXPECT_EQ(result.launch_file, "predictive_stereo.launch");
  EXPECT_EQ(result.arguments, std::vector<std::string>{"camera:=/stereo"});
}

TEST_F(CheckBag, PutsRectificationInFrontOfRawImages) {
  Recording raw;
  raw.left = "/stereo/left/image_raw";
  raw.right = "/stereo/right/image_raw";
  const BagCheck result = check(raw);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_TRUE(hasArgument(result, "rectify:=true"));
}

TEST_F(CheckBag, RefusesRawImagesThatCannotBeRectified) {
  Recording raw;
  raw.left = "/stereo/left/image_raw";
  raw.right = "/stereo/right/image_raw";
  raw.R = {};
  EXPECT_SAYS(faults(check(raw)), "is no rotation");
  raw = {};
  raw.R = {};
  EXPECT_TRUE(check(raw).isUsable()) << "rectified ones do not need it";
}

TEST_F(CheckBag, KnowsAnInfraredPairWithoutANamespace) {
  Recording infrared;
  infrared.left = "/infra1/image_rect_raw";
  infrared.left_info = "/infra1/camera_info";
  infrared.right = "/infra2/image_rect_raw";
  infrared.right_info = "/infra2/camera_info";
  const BagCheck result = check(infrared);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_TRUE(hasArgument(result, "camera:=/"));
}

TEST_F(CheckBag, KnowsGreyAndColourImagesOfOneCamera) {
  Recording zed;
  for (const std::string image : {"image_rect_gray", "image_rect_color"}) {
    zed.left = "/stereo/left/" + image;
    zed.right = "/stereo/right/" + image;
    const BagCheck result = check(zed);
    EXPECT_TRUE(result.isUsable()) << faults(result);
    EXPECT_TRUE(hasArgument(result, "left_image:=" + zed.left));
  }
}

TEST_F(CheckBag, KnowsKittisLayouts) {
  struct Layout {
    const char* left_folder;
    const char* right_folder;
    const char* image;
    const char* profile;
    const char* cameras;
  };
  for (const Layout& layout : {
           Layout{"/kitti/camera_gray_left", "/kitti/camera_gray_right", "image_raw", "raw",
                  "gray"},
           Layout{"/kitti/camera_color_left", "/kitti/camera_color_right", "image_raw", "raw",
                  "color"},
           Layout{"/kitti/camera_gray_left", "/kitti/camera_gray_right", "image_rect", "odom",
                  "gray"},
           Layout{"/cam00", "/cam01", "image_raw", "eth", "gray"},
           Layout{"/cam02", "/cam03", "image_raw", "eth", "color"},
       }) {
    Recording kitti;
    const std::string left = layout.left_folder, right = layout.right_folder;
    kitti.left = left + "/" + layout.image;
    kitti.left_info = left + "/camera_info";
    kitti.right = right + "/" + layout.image;
    kitti.right_info = right + "/camera_info";
    kitti.extrinsic = false;
    kitti.base_parent = "world";
    const BagCheck result = check(kitti);
    EXPECT_TRUE(result.isUsable()) << faults(result);
    EXPECT_EQ(result.launch_file, "kitti.launch");
    EXPECT_EQ(result.arguments,
              (std::vector<std::string>{std::string("profile:=") + layout.profile,
                                        std::string("cameras:=") + layout.cameras}));
  }
}

TEST_F(CheckBag, TakesOtherTopicsWhenTold) {
  Recording other;
  other.left = "/a/picture";
  other.left_info = "/a/camera_info";
  other.right = "/b/picture";
  other.right_info = "/b/camera_info";
  const BagCheck unknown = check(other);
  EXPECT_FALSE(unknown.isUsable());
  EXPECT_SAYS(faults(unknown), "/a/picture, /b/picture");
  const BagCheck told = check(other, {"", "/a/picture", "/b/picture"});
  EXPECT_TRUE(told.isUsable()) << faults(told);
  EXPECT_TRUE(hasArgument(told, "left_image:=/a/picture"));
  EXPECT_TRUE(hasArgument(told, "right_info:=/b/camera_info"));
}

TEST_F(CheckBag, NamesTopicsThatAreMissing) {
  Recording no_info;
  no_info.right_info = "";
  const BagCheck result = check(no_info, {"/stereo", "", ""});
  EXPECT_FALSE(result.isUsable());
  EXPECT_SAYS(faults(result), "no messages on /stereo/right/camera_info");
  EXPECT_SAYS(faults(result), "right_info:=");
}

TEST_F(CheckBag, NamesACalibrationThatWasNotRecorded) {
  Recording no_info;
  no_info.left_info = no_info.right_info = "";
  const BagCheck unknown = check(no_info, {});
  EXPECT_FALSE(unknown.isUsable());
  EXPECT_SAYS(faults(unknown), "record the camera_info topics too");
  EXPECT_SAYS(faults(check(no_info, {"/stereo", "", ""})), "Record the calibration too");
}

TEST_F(CheckBag, OffersTheTransportOfCompressedImages) {
  Recording packed;
  packed.compressed = true;
  for (const StereoTopicChoice& choice :
       {StereoTopicChoice(), StereoTopicChoice{"/stereo", "", ""},
        StereoTopicChoice{"", "/stereo/left/image_rect", "/stereo/right/image_rect"}}) {
    const BagCheck result = check(packed, choice);
    EXPECT_TRUE(result.isUsable()) << faults(result);
    EXPECT_EQ(
        std::count(result.arguments.begin(), result.arguments.end(), "image_transport:=compressed"),
        1);
    for (const std::string& argument : result.arguments)
      EXPECT_EQ(argument.find("/compressed"), std::string::npos) << argument;
  }
  packed.broken = true;
  const BagCheck broken = check(packed);
  EXPECT_FALSE(broken.isUsable());
  EXPECT_SAYS(faults(broken), "neither JPEG nor PNG");
  packed.left_info = packed.right_info = "";
  EXPECT_SAYS(faults(check(packed)), "record the camera_info topics too");
}

TEST_F(CheckBag, TellsThatImagesAreDark) {
  Recording dark;
  dark.encoding = "mono16";
  dark.grey = 10;
  const BagCheck result = check(dark);
  EXPECT_TRUE(result.isUsable());
  EXPECT_SAYS(advice(result), "no pixel is brighter than 10 of 255");
  EXPECT_SAYS(advice(result), "set its driver to mono8");
}

TEST_F(CheckBag, RefusesAnEmptyBag) {
  { rosbag::Bag bag(path_.string(), rosbag::bagmode::Write); }
  const rosbag::Bag bag(path_.string());
  const BagCheck result = checkBag(bag);
  EXPECT_FALSE(result.isUsable());
  EXPECT_SAYS(faults(result), "empty");
}

TEST_F(CheckBag, RefusesEncodingsThatAreNoGreyAndNoColours) {
  Recording depth;
  depth.encoding = "32FC1";
  EXPECT_SAYS(faults(check(depth)), "32FC1");
}

TEST_F(CheckBag, RefusesDifferentSizes) {
  Recording different;
  different.right_width = 48;
  EXPECT_SAYS(faults(check(different)), "48x32");
  Recording uncalibrated;
  uncalibrated.calibrated_width = 128;
  EXPECT_SAYS(faults(check(uncalibrated)), "128x32");
}

TEST_F(CheckBag, RefusesABaselineThatIsNotPositive) {
  Recording swapped;
  swapped.right_P3 = 30;
  EXPECT_FALSE(check(swapped).isUsable());
  Recording single;
  single.right_P3 = 0;
  EXPECT_FALSE(check(single).isUsable());
}

TEST_F(CheckBag, TellsSynchronisationsApart) {
  Recording slightly;
  slightly.right_delay_s = 0.003;
  const BagCheck within = check(slightly);
  EXPECT_TRUE(within.isUsable()) << faults(within);
  EXPECT_EQ(within.arguments.size(), 1u);
  EXPECT_SAYS(findingsOf(within, BagFinding::Level::kGood), "approximate_sync");

  Recording more;
  more.right_delay_s = 0.02;
  const BagCheck beyond = check(more);
  EXPECT_TRUE(beyond.isUsable()) << faults(beyond);
  EXPECT_TRUE(hasArgument(beyond, "sync_tolerance:=0.0240")) << advice(beyond);

  Recording never;
  never.right_delay_s = 0.05;
  EXPECT_SAYS(faults(check(never)), "not synchronised");

  Recording seldom;
  seldom.infos = 2;
  EXPECT_SAYS(faults(check(seldom)), "/stereo/left/camera_info");
  EXPECT_SAYS(faults(check(seldom)), "each image needs a camera_info with its stamp");
}

TEST_F(CheckBag, RefusesStampsOfZero) {
  Recording unstamped;
  unstamped.zero_stamps = true;
  EXPECT_SAYS(faults(check(unstamped)), "stamps of zero");
}

// Nodelets go on without these messages, so the bag can be used.
TEST_F(CheckBag, NamesMessagesThatTheNodeletsRefuse) {
  const Recording recording;
  const BagCheck good = check(recording);
  const ros::Time hostile(4200000000u, 0), now(1000.5);
  {
    rosbag::Bag bag(path_.string(), rosbag::bagmode::Append);
    sensor_msgs::Image left = image(recording, 0, hostile);
    bag.write("/stereo/left/image_rect", now, left);
    sensor_msgs::CameraInfo info;
    info.header.stamp = hostile;
    bag.write("/stereo/right/camera_info", now, info);
    bag.write("/tf", now, transform("base_link", "wheel", hostile));
  }
  const BagCheck result = checkBag(rosbag::Bag(path_.string()), {});
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_EQ(result.arguments, good.arguments);
  for (const char* text :
       {"/stereo/left/image_rect: stamp 4200000000.000000000 s",
        "/stereo/right/camera_info: stamp 4200000000.000000000 s",
        "/tf: transform of 'wheel' in 'base_link' from the bag: stamp 4200000000.000000000 s"})
    EXPECT_SAYS(advice(result), text);
}

TEST_F(CheckBag, LooksAtBagsThatWereRecordedAtTheEndOfTime) {
  {
    rosbag::Bag bag(path_.string(), rosbag::bagmode::Write);
    const ros::Time end(4294967290u, 0);
    bag.write("/stereo/left/image_rect", end, image(Recording(), 0, end));
  }
  EXPECT_SAYS(advice(checkBag(rosbag::Bag(path_.string()), {"/stereo", "", ""})),
              "stamp 4294967290.000000000 s");
}

TEST_F(CheckBag, NoticesGapsAndStampsThatGoBack) {
  Recording uneven;
  uneven.stamps_s = {0, 0.1, 0.2, 2.5, 2.6, 2.7, 0.3, 0.4};
  const BagCheck result = check(uneven);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_SAYS(advice(result), "1 gaps");
  EXPECT_SAYS(advice(result), "go back 1 times");
  EXPECT_EQ(advice(result).find("older than the one before"), std::string::npos);
}

TEST_F(CheckBag, NoticesSwappedImages) {
  Recording swapped;
  swapped.stamps_s = {0, 0.1, 0.3, 0.2, 0.4, 0.5};
  const BagCheck result = check(swapped);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_SAYS(advice(result), "1 left images are older than the one before, and are ignored");
  EXPECT_EQ(advice(result).find("go back"), std::string::npos);
}

TEST_F(CheckBag, NoticesATopicThatWasRecordedTwice) {
  Recording twice;
  twice.stamps_s = {0, 0, 0.1, 0.1, 0.2, 0.2, 0.3, 0.3};
  const BagCheck result = check(twice);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_SAYS(advice(result), "4 left images have the stamp of the one before, and are ignored");
  EXPECT_EQ(advice(result).find("go back"), std::string::npos);
}

TEST_F(CheckBag, TakesTheCameraAsTheBaseWhereTfDoesNotKnowIt) {
  Recording no_tf;
  no_tf.extrinsic = false;
  const BagCheck result = check(no_tf);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_TRUE(hasArgument(result, "camera_is_base:=true"));
}

// A frame that has a parent must not get another one.
TEST_F(CheckBag, TakesWhatTheCameraIsFixedToAsTheBase) {
  Recording mounted;
  mounted.base = "camera_link";
  const BagCheck result = check(mounted);
  EXPECT_TRUE(result.isUsable());
  EXPECT_EQ(std::count(result.arguments.begin(), result.arguments.end(), "base_frame:=camera_link"),
            1);
  EXPECT_EQ(std::count(result.arguments.begin(), result.arguments.end(), "camera_is_base:=true"),
            0);
  EXPECT_FALSE(hasArgument(result, "odom_frame:=visual_odom"));
  mounted.base = "odom";
  const BagCheck fixed = check(mounted);
  EXPECT_TRUE(hasArgument(fixed, "base_frame:=odom"));
  EXPECT_TRUE(hasArgument(fixed, "odom_frame:=visual_odom"));
  EXPECT_SAYS(advice(fixed), "give base_frame:=odom odom_frame:=visual_odom, the frame that");
}

TEST_F(CheckBag, UsesAnOdometryOfTheBag) {
  Recording own;
  own.base_parent = "map";
  const BagCheck result = check(own);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_TRUE(hasArgument(result, "ego_motion:=false"));
  EXPECT_TRUE(hasArgument(result, "odom_frame:=map"));
  EXPECT_EQ(advice(result).find("odometry:="), std::string::npos) << "the bag has no topic of it";
  EXPECT_EQ(advice(result).find("this motion begins"), std::string::npos);
  EXPECT_EQ(advice(result).find("this motion was recorded"), std::string::npos);
}

TEST_F(CheckBag, NamesTheTopicOfAnOdometry) {
  Recording own;
  own.base_parent = "odom";
  own.odometries = {"/wheels/odom"};
  EXPECT_TRUE(hasArgument(check(own), "odometry:=/wheels/odom"));
  own.others = {"/stereo/disparity/image"};
  EXPECT_SAYS(advice(check(own)), "'/wheels/odom', '/tf'") << "of the inputs";
  own.odometries = {"/wheels/odom", "/fused/odom"};
  const BagCheck result = check(own);
  EXPECT_SAYS(advice(result), "of /fused/odom, /wheels/odom");
  EXPECT_FALSE(hasArgument(result, "odometry:=/wheels/odom"));
}

TEST_F(CheckBag, TellsThatTheBagHasOutputsOfTheNodelets) {
  Recording own;
  EXPECT_EQ(advice(check(own)).find("outputs of the nodelets"), std::string::npos);
  own.others = {"/stereo/disparity/image", "/stereo/odometry"};
  EXPECT_SAYS(advice(check(own)), "the bag has 2 outputs of the nodelets");
  own.others = {"/stereo/odometry"};
  own.base_parent = "odom";
  EXPECT_EQ(advice(check(own)).find("outputs of the nodelets"), std::string::npos)
      << "it may be that of the wheels";
  own.others = {"/stereo/disparity/image", "/stereo/odometry"};
  EXPECT_SAYS(advice(check(own)), "'/stereo/odometry', '/tf'") << "its covariance is needed";
}

TEST_F(CheckBag, TellsThatAnOdometryOfTheBagIsLate) {
  Recording late;
  late.base_parent = "map";
  late.tf_late_s = 0.3;
  late.first_tf = 4;
  const BagCheck result = check(late);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_SAYS(advice(result), "this motion begins 0.40 s after the images");
  EXPECT_SAYS(advice(result), "this motion was recorded 0.30 s or more after the images");
}

TEST_F(CheckBag, UsesAnOdometryThatMovesWhatTheBaseIsFixedTo) {
  Recording own;
  own.base_parent = "odom";
  own.footprint = "base_footprint";
  const BagCheck result = check(own);
  EXPECT_TRUE(result.isUsable()) << faults(result);
  EXPECT_TRUE(hasArgument(result, "ego_motion:=false"));
  EXPECT_TRUE(hasArgument(result, "odom_frame:=odom"));
}

TEST_F(CheckBag, DoubtsACameraThatLooksUp) {
  Recording own;
  EXPECT_EQ(advice(check(own)).find("looks up"), std::string::npos);
  own.optical = false;
  EXPECT_SAYS(advice(check(own)), "'left_optical_frame' looks up from 'base_link'");
}

TEST_F(CheckBag, RefusesAnEmptyFrame) {
  Recording nameless;
  nameless.left_frame = "";
  nameless.extrinsic = false;
  EXPECT_SAYS(faults(check(nameless)), "frame_id");
}

}  // namespace
}  // namespace predictive_stereo
