#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "nodelets/stereo_messages.h"
#include "nodelets/views.h"

namespace predictive_stereo {
namespace {

constexpr int kWidth = 7, kHeight = 5;

StereoRig rig() {
  StereoRig result;
  result.size = {kWidth, kHeight};
  result.fx_px = result.fy_px = 10;
  result.cx_left_px = result.cx_right_px = 3;
  result.cy_px = 2;
  result.baseline_m = 1;
  return result;
}

template <class Pixel>
sensor_msgs::Image image(const cv::Mat_<Pixel>& pixels) {
  sensor_msgs::Image message;
  pixels.copyTo(allocateImage<Pixel>({}, pixels.size(), message));
  return message;
}

/// Depth grows to the right: 10 m / (7 - column); the first pixel is unknown.
stereo_msgs::DisparityImage disparity() {
  cv::Mat1f map(kHeight, kWidth);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) map(y, x) = static_cast<float>(kWidth - x);
  map(0, 0) = -1;
  stereo_msgs::DisparityImage message;
  message.header.frame_id = "camera";
  message.image = image(map);
  message.f = 10;
  message.T = 1;
  message.max_disparity = 15;
  return message;
}

sensor_msgs::Image grey() { return image(cv::Mat1b(kHeight, kWidth, uint8_t{100})); }

/// The two columns at the right move.
sensor_msgs::Image mask() {
  cv::Mat1b moving(kHeight, kWidth, uint8_t{0});
  moving.colRange(5, 7).setTo(255);
  return image(moving);
}

sensor_msgs::PointCloud2Ptr cloudOf(const sensor_msgs::Image& left, const sensor_msgs::Image* mask,
                                    const PointsParams& params = {},
                                    MovingPoints moving = MovingPoints::kTinted) {
  CloudSource source{boost::make_shared<stereo_msgs::DisparityImage>(disparity()),
                     boost::make_shared<sensor_msgs::Image>(left), rig(), params, nullptr};
  if (mask) source.mask = boost::make_shared<sensor_msgs::Image>(*mask);
  return pointCloud(source, moving);
}

struct Point {
  cv::Vec3f xyz;
  cv::Vec3b bgr;
  bool known() const { return std::isfinite(xyz[0]); }
};

// Reads a point by the names of its fields, like costmap_2d and PCL.
Point at(const sensor_msgs::PointCloud2& cloud, uint32_t row, uint32_t column) {
  const uint8_t* data = &cloud.data.at(row * cloud.row_step + column * cloud.point_step);
  Point point;
  for (const sensor_msgs::PointField& field : cloud.fields) {
    EXPECT_EQ(field.datatype, sensor_msgs::PointField::FLOAT32);
    const size_t axis = std::string("xyz").find(field.name);
    if (axis == std::string::npos)
      std::memcpy(point.bgr.val, data + field.offset, 3);
    else
      std::memcpy(&point.xyz[static_cast<int>(axis)], data + field.offset, sizeof(float));
  }
  return point;
}

TEST(DepthImage, of_a_disparity_of_zero_is_infinite) {
  stereo_msgs::DisparityImage message = disparity();
  writableView<float>(message.image)(0, 1) = 0;
  writableView<float>(message.image)(0, 2) = 0.5f;
  const auto image = depthImage(message);
  const cv::Mat1f depth_m = floatView(*image, "depth");
  EXPECT_TRUE(std::isnan(depth_m(0, 0)));  // disparity -1: unknown
  EXPECT_EQ(depth_m(0, 1), std::numeric_limits<float>::infinity());
  EXPECT_EQ(depth_m(0, 2), 20);
}

TEST(DepthImage, below_the_range_is_unknown) {
  stereo_msgs::DisparityImage message = disparity();
  message.min_disparity = 2;
  const auto image = depthImage(message);
  const cv::Mat1f depth_m = floatView(*image, "depth");
  EXPECT_TRUE(std::isnan(depth_m(0, 6)));
  EXPECT_EQ(depth_m(0, 5), 5);
}

TEST(PointCloud, is_organised_as_the_image) {
  const auto cloud = cloudOf(grey(), nullptr);
  EXPECT_EQ(cloud->header.frame_id, "camera");
  EXPECT_EQ(cloud->width, 7u);
  EXPECT_EQ(cloud->height, 5u);
  EXPECT_EQ(cloud->data.size(), cloud->row_step * cloud->height);
  EXPECT_FALSE(cloud->is_dense);
  EXPECT_FALSE(at(*cloud, 0, 0).known());
  const Point point = at(*cloud, 4, 5);  // 10 m / 2
  EXPECT_EQ(point.xyz, cv::Vec3f(1, 1, 5));
  EXPECT_EQ(point.bgr, cv::Vec3b(100, 100, 100));
}

TEST(PointCloud, with_a_stride_has_every_so_many_rows_and_columns) {
  const auto all = cloudOf(grey(), nullptr);
  PointsParams params;
  params.stride = 3;
  const auto few = cloudOf(grey(), nullptr, params);
  ASSERT_EQ(few->width, 3u);
  ASSERT_EQ(few->height, 2u);
  EXPECT_EQ(few->row_step, few->width * few->point_step);
  EXPECT_EQ(few->data.size(), few->row_step * few->height);
  for (uint32_t row = 0; row < 2; ++row)
    for (uint32_t column = 0; column < 3; ++column)
      if (row + column > 0) {
        EXPECT_EQ(at(*few, row, column).xyz, at(*all, 3 * row, 3 * column).xyz);
      }
  EXPECT_FALSE(at(*few, 0, 0).known());
}

TEST(PointCloud, ends_at_the_range) {
  PointsParams params;
  params.max_range_m = 5.1;
  const auto cloud = cloudOf(grey(), nullptr, params);
  EXPECT_TRUE(at(*cloud, 2, 4).known());  // (0.33, 0, 3.33)
  EXPECT_FALSE(at(*cloud, 2, 6).known());
  // Depth 5 m, but (1, 1, 5) is 5.2 m away.
  EXPECT_FALSE(at(*cloud, 4, 5).known());
  EXPECT_TRUE(at(*cloud, 2, 5).known());
}

TEST(PointCloud, tints_or_leaves_out_what_moves) {
  const sensor_msgs::Image moving = mask();
  const auto tinted = cloudOf(grey(), &moving);
  const auto without = cloudOf(grey(), &moving, {}, MovingPoints::kLeftOut);
  for (uint32_t row = 1; row < kHeight; ++row)
    for (uint32_t column = 0; column < kWidth; ++column) {
      EXPECT_TRUE(at(*tinted, row, column).known());
      EXPECT_EQ(at(*tinted, row, column).bgr[2] > 100, column >= 5) << column;
      EXPECT_EQ(at(*without, row, column).known(), column < 5) << column;
      if (column < 5) {
        EXPECT_EQ(at(*without, row, column).xyz, at(*tinted, row, column).xyz);
      }
    }
}

TEST(PointCloud, refuses_a_mask_of_another_size) {
  const sensor_msgs::Image other = image(cv::Mat1b(3, 3, uint8_t{0}));
  EXPECT_THROW(cloudOf(grey(), &other), std::invalid_argument);
  EXPECT_THROW(cloudOf(other, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
