#include <geometry_msgs/PoseWithCovariance.h>
#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>
#include <set>
#include <string>
#include <vector>

#include "nodelets/stereo_messages.h"
#include "nodelets/views.h"

namespace predictive_stereo {
namespace {

using visualization_msgs::Marker;

// Two objects; the velocity of the second one is unknown.
MovingObjectArray someObjects() {
  MovingObjectArray objects;
  objects.header.frame_id = "camera";
  objects.header.stamp = ros::Time(7, 8);
  MovingObject car;
  car.id = 4;
  car.bbox.center.x = 60;
  car.bbox.center.y = 50;
  car.bbox.size_x = 40;
  car.bbox.size_y = 20;
  car.pose.position.x = 1;
  car.pose.position.y = 0.5;
  car.pose.position.z = 12;
  car.pose.orientation.w = 1;
  car.size.x = 1.8;
  car.size.y = 1.4;
  car.size.z = 4;
  car.velocity.x = 3;
  car.velocity.y = 4;
  car.velocity_covariance[0] = 0.1;
  car.distance = 10.04;
  objects.objects.push_back(car);
  car.id = 5;
  car.velocity_covariance[0] = -1;
  objects.objects.push_back(car);
  return objects;
}

TEST(MovingObjectMarkers, ShowBoxLabelAndVelocity) {
  const MovingObjectArray objects = someObjects();
  CameraPose pose;
  pose.T_odom_cam.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // odom: x ahead, y left, z up
  pose.T_odom_cam.translation() = Eigen::Vector3d(100, 50, 2);
  const auto array = markers(objects, pose);
  ASSERT_EQ(array->markers.size(), 6u);
  EXPECT_EQ(array->markers[0].action, Marker::DELETEALL);
  std::set<std::pair<std::string, int>> names;
  for (const Marker& marker : array->markers) {
    EXPECT_EQ(marker.header.frame_id, "camera");
    EXPECT_EQ(marker.header.stamp, objects.header.stamp);
    EXPECT_NEAR(marker.pose.orientation.w, 1, 1e-9);
    if (marker.action == Marker::DELETEALL) continue;
    EXPECT_EQ(marker.action, Marker::ADD);
    EXPECT_GT(marker.color.a, 0);
    EXPECT_TRUE(names.emplace(marker.ns, marker.id).second) << "rviz would replace it";
  }

  const Marker& box = array->markers[1];
  EXPECT_EQ(box.type, Marker::LINE_LIST);
  EXPECT_EQ(box.pose.position.z, 12);
  EXPECT_GT(box.scale.x, 0);
  ASSERT_EQ(box.points.size(), 24u);
  std::set<std::set<std::tuple<double, double, double>>> edges;
  for (size_t i = 0; i < 24; i += 2) {
    std::set<std::tuple<double, double, double>> edge;
    for (size_t k = i; k < i + 2; ++k) {
      const geometry_msgs::Point& p = box.points[k];
      EXPECT_EQ(std::abs(p.x), 0.9);
      EXPECT_EQ(std::abs(p.y), 0.7);
      EXPECT_EQ(std::abs(p.z), 2.0);
      edge.emplace(p.x, p.y, p.z);
    }
    const geometry_msgs::Point &a = box.points[i], &b = box.points[i + 1];
    EXPECT_EQ((a.x != b.x) + (a.y != b.y) + (a.z != b.z), 1) << "an edge, no diagonal";
    edges.insert(edge);
  }
  EXPECT_EQ(edges.size(), 12u);

  const Marker& label = array->markers[2];
  EXPECT_EQ(label.type, Marker::TEXT_VIEW_FACING);
  EXPECT_EQ(label.text, "4: 10.0 m, 5.0 m/s");
  EXPECT_LT(label.pose.position.y, 0.5 - 0.7) << "above the box";
  EXPECT_GT(label.scale.z, 0);

  const Marker& arrow = array->markers[3];
  EXPECT_EQ(arrow.type, Marker::ARROW);
  ASSERT_EQ(arrow.points.size(), 2u);
  EXPECT_EQ(arrow.points[0].z, 12);
  // 3 m/s ahead and 4 m/s to the left.
  EXPECT_NEAR(arrow.points[1].x - arrow.points[0].x, -4, 1e-9);
  EXPECT_NEAR(arrow.points[1].y - arrow.points[0].y, 0, 1e-9);
  EXPECT_NEAR(arrow.points[1].z - arrow.points[0].z, 3, 1e-9);

  EXPECT_EQ(array->markers[5].text, "5: 10.0 m") << "no speed where it is not known";
}

TEST(MovingObjectMarkers, HaveNoArrowsWithoutPose) {
  const auto array = markers(someObjects(), std::nullopt);
  for (const Marker& marker : array->markers)
    EXPECT_NE(marker.type == Marker::ARROW && marker.action == Marker::ADD, true);
}

TEST(MovingObjectMarkers, DeleteTheOldOnesWhereNothingMoves) {
  MovingObjectArray none;
  none.header.frame_id = "camera";
  const auto array = markers(none, std::nullopt);
  ASSERT_EQ(array->markers.size(), 1u);
  EXPECT_EQ(array->markers[0].action, Marker::DELETEALL);
}

sensor_msgs::Image image(cv::Size size, uint8_t grey) {
  sensor_msgs::Image message;
  std_msgs::Header header;
  header.frame_id = "camera";
  allocateImage<uint8_t>(header, size, message);
  std::fill(message.data.begin(), message.data.end(), grey);
  return message;
}

TEST(MovingObjectOverlay, TintsTheMaskAndDrawsBoxes) {
  const sensor_msgs::Image left = image({160, 100}, 100);
  sensor_msgs::Image mask = image({160, 100}, 0);
  writableView<uint8_t>(mask)(cv::Rect(50, 45, 20, 10)).setTo(255);
  const auto result = overlay(left, someObjects(), mask);
  EXPECT_EQ(result->encoding, "bgr8");
  EXPECT_EQ(result->header.frame_id, "camera");
  const cv::Mat3b pixels = writableView<cv::Vec3b>(*result);
  ASSERT_EQ(pixels.size(), cv::Size(160, 100));
  EXPECT_EQ(pixels(50, 60), cv::Vec3b(100, 100, 190)) << "moving";
  EXPECT_EQ(pixels(57, 60), cv::Vec3b(100, 100, 100)) << "within the box, not moving";
  EXPECT_EQ(pixels(90, 150), cv::Vec3b(100, 100, 100));
  EXPECT_NE(pixels(50, 40), cv::Vec3b(100, 100, 100)) << "the box's left edge";
  EXPECT_NE(pixels(50, 80), cv::Vec3b(100, 100, 100)) << "its right edge";
}

TEST(MovingObjectOverlay, RefusesWhatDoesNotFit) {
  const sensor_msgs::Image left = image({160, 100}, 100);
  EXPECT_THROW(overlay(left, someObjects(), image({80, 100}, 0)), std::invalid_argument);
  sensor_msgs::Image deep = left;
  deep.encoding = sensor_msgs::image_encodings::MONO16;
  EXPECT_THROW(overlay(deep, someObjects(), left), std::invalid_argument);
}

sensor_msgs::Image floats(cv::Size size, float value) {
  sensor_msgs::Image message;
  std_msgs::Header header;
  header.frame_id = "camera";
  allocateImage<float>(header, size, message) = value;
  return message;
}

stereo_msgs::DisparityImage disparities(cv::Size size, float value) {
  stereo_msgs::DisparityImage message;
  message.header.frame_id = "camera";
  message.image = floats(size, value);
  message.min_disparity = 0;
  message.max_disparity = 63;
  return message;
}

sensor_msgs::ImagePtr residual(const stereo_msgs::DisparityImage& measured,
                               const sensor_msgs::Image& measured_variance,
                               const stereo_msgs::DisparityImage& predicted,
                               const sensor_msgs::Image& predicted_variance) {
  MovingObjectsInput frame;
  frame.measured_disparity = boost::make_shared<stereo_msgs::DisparityImage>(measured);
  frame.measured_variance = boost::make_shared<sensor_msgs::Image>(measured_variance);
  frame.predicted_disparity = boost::make_shared<stereo_msgs::DisparityImage>(predicted);
  frame.predicted_variance = boost::make_shared<sensor_msgs::Image>(predicted_variance);
  return residualImage(frame);
}

TEST(MovingObjectResidual, IsInStandardDeviations) {
  stereo_msgs::DisparityImage measured = disparities({40, 20}, 10);
  writableView<float>(measured.image)(3, 5) = -1;
  const auto result = residual(measured, floats({40, 20}, 0.36f), disparities({40, 20}, 8),
                               floats({40, 20}, 0.64f));
  EXPECT_EQ(result->encoding, "32FC1");
  EXPECT_EQ(result->header.frame_id, "camera");
  EXPECT_FLOAT_EQ(writableView<float>(*result)(10, 10), 2.0f);
  EXPECT_EQ(writableView<float>(*result)(3, 5), 0.0f);
  EXPECT_THROW(residual(measured, floats({40, 10}, 1), measured, floats({40, 20}, 1)),
               std::invalid_argument);
}

TEST(MovingObjectResidual, RangesThatNoDisparityHasAreRefused) {
  for (const float limit :
       {1e30f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
    stereo_msgs::DisparityImage measured = disparities({40, 20}, 10);
    measured.max_disparity = limit;
    EXPECT_THROW(rangeOf(measured), std::invalid_argument) << limit;
  }
}

}  // namespace
}  // namespace predictive_stereo
