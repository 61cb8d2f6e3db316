#include "nodelets/stereo_messages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace predictive_stereo {
namespace {

sensor_msgs::Image image(const std::string& encoding, unsigned width, unsigned height,
                         std::vector<uint8_t> data, unsigned step) {
  sensor_msgs::Image message;
  message.encoding = encoding;
  message.width = width;
  message.height = height;
  message.step = step;
  message.data = std::move(data);
  return message;
}

sensor_msgs::CameraInfo info(bool right) {
  sensor_msgs::CameraInfo message;
  message.width = 640;
  message.height = 480;
  message.P = {700, 0, right ? 330.0 : 320.0, right ? -350.0 : 0.0, 0, 710, 240, 0, 0, 0, 1, 0};
  return message;
}

StereoPair pair(const sensor_msgs::CameraInfo& left, const sensor_msgs::CameraInfo& right,
                unsigned width = 640, unsigned height = 480) {
  StereoPair result;
  result.left = boost::make_shared<sensor_msgs::Image>(image("mono8", width, height, {}, width));
  result.right = boost::make_shared<sensor_msgs::Image>(*result.left);
  result.left_info = boost::make_shared<sensor_msgs::CameraInfo>(left);
  result.right_info = boost::make_shared<sensor_msgs::CameraInfo>(right);
  return result;
}

template <class Work>
std::string errorOf(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(GreyImage, mono8_is_viewed_where_it_lies) {
  const auto message = image("mono8", 3, 2, {1, 2, 3, 99, 4, 5, 6}, 4);  // last row unpadded
  const cv::Mat1b grey = greyImage(message, "left");
  EXPECT_EQ(grey.data, message.data.data());
  EXPECT_EQ(grey(1, 2), 6);
}

TEST(GreyImage, colours_weigh_as_the_eye_sees_them) {
  const std::vector<uint8_t> pixel = {200, 0, 0};
  EXPECT_EQ(greyImage(image("rgb8", 1, 1, pixel, 3), "left")(0, 0), 60);  // 0.299 red
  EXPECT_EQ(greyImage(image("bgr8", 1, 1, pixel, 3), "left")(0, 0), 23);  // 0.114 blue
  EXPECT_EQ(greyImage(image("bgra8", 1, 1, {0, 200, 0, 9}, 4), "left")(0, 0), 117);
  EXPECT_EQ(greyImage(image("rgba8", 1, 1, {0, 200, 0, 9}, 4), "left")(0, 0), 117);
}

TEST(GreyImage, a_bayer_patterns_first_row_gives_its_name) {
  // A red surface: only red pixels of the Bayer pattern are bright.
  std::vector<uint8_t> red_first(8 * 8, 0), red_last(8 * 8, 0);
  for (int y = 0; y < 8; y += 2)
    for (int x = 0; x < 8; x += 2) {
      red_first[y * 8 + x] = 200;
      red_last[(y + 1) * 8 + x + 1] = 200;
    }
  EXPECT_EQ(greyImage(image("bayer_rggb8", 8, 8, red_first, 8), "left")(4, 4), 60);
  EXPECT_EQ(greyImage(image("bayer_bggr8", 8, 8, red_last, 8), "left")(4, 4), 60);
  // The same pixels as blue ones have a lower weight.
  EXPECT_EQ(greyImage(image("bayer_bggr8", 8, 8, red_first, 8), "left")(4, 4), 23);
}

// A grey surface of 100 in each encoding that cv_bridge converts to mono8.
TEST(GreyImage, all_encodings_that_cv_bridge_converts_are_taken) {
  for (const auto& [encoding, channels] :
       std::vector<std::pair<const char*, int>>{{"8UC1", 1},
                                                {"8UC3", 3},
                                                {"8UC4", 4},
                                                {"bgr8", 3},
                                                {"rgb8", 3},
                                                {"bgra8", 4},
                                                {"rgba8", 4},
                                                {"bayer_rggb8", 1},
                                                {"bayer_bggr8", 1},
                                                {"bayer_gbrg8", 1},
                                                {"bayer_grbg8", 1}}) {
    const std::vector<uint8_t> data(static_cast<size_t>(8 * 8 * channels), 100);
    const auto message = image(encoding, 8, 8, data, static_cast<unsigned>(8 * channels));
    const cv::Mat1b grey = greyImage(message, "left");
    EXPECT_EQ(grey.size(), cv::Size(8, 8)) << encoding;
    EXPECT_EQ(cv::countNonZero(grey != 100), 0) << encoding;
  }
  for (const auto& [encoding, channels] : std::vector<std::pair<const char*, int>>{
           {"16UC1", 1}, {"mono16", 1}, {"bgr16", 3}, {"rgb16", 3}, {"bgra16", 4}, {"rgba16", 4}}) {
    std::vector<uint8_t> data;
    for (int i = 0; i < 8 * 8 * channels; ++i)
      data.insert(data.end(), {uint8_t{100}, uint8_t{100}});
    const cv::Mat1b grey =
        greyImage(image(encoding, 8, 8, data, static_cast<unsigned>(16 * channels)), "left");
    EXPECT_EQ(cv::countNonZero(grey != 100), 0) << encoding;
  }
  // UYVY: brightness is every second byte.
  std::vector<uint8_t> yuv;
  for (int i = 0; i < 8 * 8; ++i) yuv.insert(yuv.end(), {uint8_t{128}, uint8_t{100}});
  const cv::Mat1b grey = greyImage(image("yuv422", 8, 8, yuv, 16), "left");
  EXPECT_EQ(cv::countNonZero(grey != 100), 0) << grey;
}

TEST(GreyImage, sixteen_bits_are_scaled_by_their_whole_range) {
  const cv::Mat1b expected = (cv::Mat1b(1, 4) << 0, 1, 128, 255);
  // 0, 257, 32768 and 65535, the low byte first.
  const auto message = image("mono16", 4, 1, {0, 0, 1, 1, 0, 128, 255, 255}, 8);
  EXPECT_EQ(cv::countNonZero(greyImage(message, "left") != expected), 0);
  auto big_endian = image("mono16", 4, 1, {0, 0, 1, 1, 128, 0, 255, 255}, 8);
  big_endian.is_bigendian = true;
  EXPECT_EQ(cv::countNonZero(greyImage(big_endian, "left") != expected), 0);
}

TEST(GreyImage, other_encodings_are_named_with_the_cure) {
  for (const char* encoding : {"32FC1", "jpeg", "yuv444"}) {
    const std::string error =
        errorOf([&] { greyImage(image(encoding, 1, 1, std::vector<uint8_t>(4), 4), "right"); });
    EXPECT_NE(error.find(std::string("right image has encoding '") + encoding + "'"),
              std::string::npos)
        << error;
    EXPECT_NE(error.find("set the camera driver to mono8"), std::string::npos) << error;
  }
}

TEST(Unpacked, gives_what_was_packed) {
  cv::Mat1b grey(20, 30);
  cv::Mat3b colour(20, 30);
  cv::Mat1w deep(20, 30);
  cv::RNG random(1);
  random.fill(grey, cv::RNG::UNIFORM, 0, 255);
  random.fill(colour, cv::RNG::UNIFORM, 0, 255);
  random.fill(deep, cv::RNG::UNIFORM, 0, 65535);
  const auto packed = [](const cv::Mat& image, const std::string& format) {
    sensor_msgs::CompressedImage message;
    message.header.stamp = ros::Time(7);
    message.header.frame_id = "camera";
    message.format = format;
    cv::imencode(".png", image, message.data);
    return decodedImage(message);
  };
  const auto of_grey = packed(grey, "mono8; png compressed ");
  EXPECT_EQ(of_grey->encoding, "mono8");
  EXPECT_EQ(of_grey->header.stamp, ros::Time(7));
  EXPECT_EQ(of_grey->header.frame_id, "camera");
  EXPECT_TRUE(std::equal(of_grey->data.begin(), of_grey->data.end(), grey.data));
  EXPECT_EQ(packed(grey, "png")->encoding, "mono8");
  EXPECT_EQ(packed(grey, "bayer_rggb8; png compressed ")->encoding, "bayer_rggb8");
  const auto of_colour = packed(colour, "rgb8; png compressed bgr8");
  EXPECT_EQ(of_colour->encoding, "bgr8");
  EXPECT_TRUE(std::equal(of_colour->data.begin(), of_colour->data.end(), colour.data));
  EXPECT_EQ(packed(deep, "mono16; png compressed ")->encoding, "mono16");

  sensor_msgs::CompressedImage broken;
  broken.format = "theora";
  EXPECT_NE(errorOf([&] { decodedImage(broken); }).find("format 'theora' with 0 bytes"),
            std::string::npos);
  broken.data = {1, 2, 3};
  EXPECT_NE(errorOf([&] { decodedImage(broken); }).find("neither JPEG nor PNG"), std::string::npos);
}

TEST(GreyImage, broken_messages_are_refused) {
  const std::vector<uint8_t> data(12);
  for (const auto& message :
       {image("mono8", 4, 4, data, 4), image("mono8", 4, 3, data, 3), image("mono8", 0, 3, data, 4),
        image("bgr8", 4, 3, data, 4), image("mono8", 4, 3, {}, 4)})
    EXPECT_NE(errorOf([&] { greyImage(message, "left"); }).find("left image is broken"),
              std::string::npos)
        << message.width << "x" << message.height << " step " << message.step;
}

TEST(StereoRigOfMessages, baseline_and_principal_points_come_from_both_projections) {
  const StereoRig rig = stereoRig(pair(info(false), info(true)));
  EXPECT_DOUBLE_EQ(rig.fx_px, 700);
  EXPECT_DOUBLE_EQ(rig.fy_px, 710);
  EXPECT_DOUBLE_EQ(rig.baseline_m, 0.5);
  EXPECT_DOUBLE_EQ(rig.cx_left_px, 320);
  EXPECT_DOUBLE_EQ(rig.cx_right_px, 330);
  EXPECT_EQ(rig.size, cv::Size(640, 480));
  // Both cameras of KITTI's colour pair have an offset.
  sensor_msgs::CameraInfo left = info(false), right = info(true);
  left.P[3] = 70;
  right.P[3] = -280;
  EXPECT_DOUBLE_EQ(stereoRig(pair(left, right)).baseline_m, 0.5);
}

TEST(StereoRigOfMessages, a_region_of_interest_moves_the_principal_point_and_binning_shrinks) {
  sensor_msgs::CameraInfo left = info(false), right = info(true);
  for (auto* camera : {&left, &right}) {
    camera->roi.x_offset = 40;
    camera->roi.y_offset = 20;
    camera->roi.width = 400;
    camera->roi.height = 300;
    camera->binning_x = camera->binning_y = 2;
  }
  const StereoRig rig = stereoRig(pair(left, right, 200, 150));
  EXPECT_DOUBLE_EQ(rig.fx_px, 350);
  EXPECT_DOUBLE_EQ(rig.cx_left_px, 140);
  EXPECT_DOUBLE_EQ(rig.cy_px, 110);
  EXPECT_DOUBLE_EQ(rig.baseline_m, 0.5);
  EXPECT_EQ(rig.size, cv::Size(200, 150));
}

TEST(StereoRigOfMessages, what_does_not_belong_together_is_refused) {
  StereoPair different = pair(info(false), info(true));
  different.right = boost::make_shared<sensor_msgs::Image>(image("mono8", 320, 240, {}, 320));
  EXPECT_NE(errorOf([&] {
              stereoRig(different);
            }).find("left image is 640x480 but the right one is 320x240"),
            std::string::npos);
  EXPECT_NE(errorOf([] {
              stereoRig(pair(info(false), info(true), 320, 240));
            }).find("left image is 320x240 but its camera_info is for 640x480"),
            std::string::npos);
  const std::string swapped = errorOf([] { stereoRig(pair(info(true), info(false))); });
  EXPECT_NE(swapped.find("swapped"), std::string::npos) << swapped;
}

TEST(RobotMaskFile, is_grey_or_refused_by_its_name) {
  EXPECT_TRUE(readRobotMask("").empty());
  const std::string file = testing::TempDir() + "robot mask.png";
  cv::Mat3b coloured(4, 6, cv::Vec3b(255, 255, 255));
  coloured(1, 2) = cv::Vec3b();
  cv::imwrite(file, coloured);
  const cv::Mat1b mask = readRobotMask(file);
  EXPECT_EQ(mask.size(), cv::Size(6, 4));
  EXPECT_EQ(cv::countNonZero(mask), 23);
  EXPECT_EQ(mask(1, 2), 0);
  try {
    readRobotMask("no_mask.png");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("robot_mask = 'no_mask.png'"), std::string::npos);
  }
}

}  // namespace
}  // namespace predictive_stereo
