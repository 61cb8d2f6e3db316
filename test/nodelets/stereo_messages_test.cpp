#include "nodelets/stereo_messages.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
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
  cv::Mat1b buffer;
  const cv::Mat1b grey = greyImage(message, "left", buffer);
  EXPECT_EQ(grey.data, message.data.data());
  EXPECT_EQ(grey(1, 2), 6);
  EXPECT_TRUE(buffer.empty());
}

TEST(GreyImage, colours_weigh_as_the_eye_sees_them) {
  cv::Mat1b buffer;
  const std::vector<uint8_t> pixel = {200, 0, 0};
  EXPECT_EQ(greyImage(image("rgb8", 1, 1, pixel, 3), "left", buffer)(0, 0), 60);  // 0.299 red
  EXPECT_EQ(greyImage(image("bgr8", 1, 1, pixel, 3), "left", buffer)(0, 0), 23);  // 0.114 blue
  EXPECT_EQ(greyImage(image("bgra8", 1, 1, {0, 200, 0, 9}, 4), "left", buffer)(0, 0), 117);
  EXPECT_EQ(greyImage(image("rgba8", 1, 1, {0, 200, 0, 9}, 4), "left", buffer)(0, 0), 117);
}

TEST(GreyImage, a_bayer_patterns_first_row_gives_its_name) {
  // A red surface: only red cells are bright.
  std::vector<uint8_t> red_first(8 * 8, 0), red_last(8 * 8, 0);
  for (int y = 0; y < 8; y += 2)
    for (int x = 0; x < 8; x += 2) {
      red_first[y * 8 + x] = 200;
      red_last[(y + 1) * 8 + x + 1] = 200;
    }
  cv::Mat1b buffer;
  EXPECT_EQ(greyImage(image("bayer_rggb8", 8, 8, red_first, 8), "left", buffer)(4, 4), 60);
  EXPECT_EQ(greyImage(image("bayer_bggr8", 8, 8, red_last, 8), "left", buffer)(4, 4), 60);
  // The same cells taken for blue ones weigh less.
  EXPECT_EQ(greyImage(image("bayer_bggr8", 8, 8, red_first, 8), "left", buffer)(4, 4), 23);
}

TEST(GreyImage, other_encodings_are_named_with_the_cure) {
  cv::Mat1b buffer;
  const std::string error = errorOf([&] {
    greyImage(image("mono16", 1, 1, {0, 0}, 2), "right", buffer);
  });
  EXPECT_NE(error.find("right image has encoding 'mono16'"), std::string::npos) << error;
  EXPECT_NE(error.find("set the camera driver to"), std::string::npos) << error;
}

TEST(GreyImage, broken_messages_are_refused) {
  cv::Mat1b buffer;
  const std::vector<uint8_t> data(12);
  for (const auto& message :
       {image("mono8", 4, 4, data, 4), image("mono8", 4, 3, data, 3), image("mono8", 0, 3, data, 4),
        image("bgr8", 4, 3, data, 4), image("mono8", 4, 3, {}, 4)})
    EXPECT_NE(errorOf([&] { greyImage(message, "left", buffer); }).find("left image is broken"),
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
  // KITTI's colour pair has an offset in both.
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

}  // namespace
}  // namespace predictive_stereo
