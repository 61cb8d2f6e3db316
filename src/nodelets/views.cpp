#include "nodelets/views.h"

#include <sensor_msgs/point_cloud2_iterator.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "predictive_stereo/residual.h"

namespace predictive_stereo {
namespace {

// Half the pixel's own colour, half red.
cv::Vec3b tinted(const cv::Vec3b& bgr) {
  return {static_cast<uint8_t>(bgr[0] / 2), static_cast<uint8_t>(bgr[1] / 2),
          static_cast<uint8_t>(128 + bgr[2] / 2)};
}

using visualization_msgs::Marker;

constexpr double kTint = 90;  // grey levels of red on moving pixels

// A colour per track; those of consecutive ids are very different.
cv::Vec3b colourOf(uint32_t id) {
  const double hue = std::fmod(id * 0.618033988749895, 1.0);
  const cv::Mat3b hsv(1, 1, cv::Vec3b(static_cast<uint8_t>(hue * 180), 220, 255));
  cv::Mat3b bgr;
  cv::cvtColor(hsv, bgr, cv::COLOR_HSV2BGR);
  return bgr(0, 0);
}

bool hasVelocity(const MovingObject& object) { return object.velocity_covariance[0] >= 0; }

Eigen::Vector3d velocityOf(const MovingObject& object) {
  return {object.velocity.x, object.velocity.y, object.velocity.z};
}

std::string label(const MovingObject& object) {
  const std::string text = cv::format("%u: %.1f m", object.id, object.distance);
  return hasVelocity(object) ? text + cv::format(", %.1f m/s", velocityOf(object).norm()) : text;
}

Marker marker(const MovingObjectArray& objects, const MovingObject& object, const char* ns,
              int type) {
  const cv::Vec3b bgr = colourOf(object.id);
  Marker result;
  result.header = objects.header;
  result.ns = ns;
  result.id = static_cast<int32_t>(object.id);
  result.type = type;
  result.action = Marker::ADD;
  result.color.r = bgr[2] / 255.0f;
  result.color.g = bgr[1] / 255.0f;
  result.color.b = bgr[0] / 255.0f;
  result.color.a = 1;
  result.pose.orientation.w = 1;
  return result;
}

// The twelve edges of the box, so that it hides nothing.
Marker box(const MovingObjectArray& objects, const MovingObject& object) {
  Marker result = marker(objects, object, "boxes", Marker::LINE_LIST);
  result.pose = object.pose;
  result.scale.x = 0.05;
  const Eigen::Vector3d half(object.size.x / 2, object.size.y / 2, object.size.z / 2);
  for (int axis = 0; axis < 3; ++axis)
    for (int edge = 0; edge < 4; ++edge) {
      Eigen::Vector3d corner = half;
      if (edge & 1) corner((axis + 1) % 3) *= -1;
      if (edge & 2) corner((axis + 2) % 3) *= -1;
      result.points.push_back(tf2::toMsg(corner));
      corner(axis) *= -1;
      result.points.push_back(tf2::toMsg(corner));
    }
  return result;
}

Marker text(const MovingObjectArray& objects, const MovingObject& object) {
  Marker result = marker(objects, object, "labels", Marker::TEXT_VIEW_FACING);
  result.pose.position = object.pose.position;
  result.pose.position.y -= object.size.y / 2 + 0.3;  // above the object, as y points down
  result.scale.z = 0.5;
  result.text = label(object);
  return result;
}

Marker arrow(const MovingObjectArray& objects, const MovingObject& object,
             const Eigen::Isometry3d& T_odom_cam) {
  Marker result = marker(objects, object, "velocities", Marker::ARROW);
  Eigen::Vector3d centre;
  tf2::fromMsg(object.pose.position, centre);
  const Eigen::Vector3d velocity_cam = T_odom_cam.linear().transpose() * velocityOf(object);
  result.points = {tf2::toMsg(centre), tf2::toMsg(Eigen::Vector3d(centre + velocity_cam))};
  result.scale.x = 0.1;
  result.scale.y = 0.25;
  return result;
}

// Above `corner`, as far as it is within the image. Letters are 14 px high.
void writeLabel(const std::string& text, const cv::Point& corner, cv::Mat3b& image) {
  constexpr double kScale = 0.65;
  constexpr int kMargin = 4;
  int below = 0;  // the letters' lower line
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kScale, 1, &below);
  cv::Rect strip(corner, cv::Size(size.width + 2 * kMargin, size.height + 2 * kMargin));
  strip.x = std::max(0, std::min(strip.x, image.cols - strip.width));
  strip.y = std::max(0, strip.y - strip.height);
  cv::rectangle(image, strip, {0, 0, 0}, cv::FILLED);
  cv::putText(image, text, {strip.x + kMargin, strip.y + kMargin + size.height},
              cv::FONT_HERSHEY_SIMPLEX, kScale, {255, 255, 255}, 1, cv::LINE_AA);
}

}  // namespace

sensor_msgs::ImagePtr colourImage(const stereo_msgs::DisparityImage& disparity) {
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  const auto message = boost::make_shared<sensor_msgs::Image>();
  cv::Mat3b colour = allocateImage<cv::Vec3b>(disparity.header, map.size(), *message);
  const double scale = 255.0 / (disparity.max_disparity - disparity.min_disparity);
  cv::Mat1b level;
  map.convertTo(level, CV_8U, scale, -disparity.min_disparity * scale);
  cv::applyColorMap(level, colour, cv::COLORMAP_TURBO);
  colour.setTo(cv::Scalar::all(0), map < disparity.min_disparity);
  return message;
}

sensor_msgs::ImagePtr standardDeviationImage(const sensor_msgs::Image& variance) {
  const cv::Mat1f variance_px2 = floatView(variance, "disparity_variance");
  const auto message = boost::make_shared<sensor_msgs::Image>();
  cv::sqrt(variance_px2, allocateImage<float>(variance.header, variance_px2.size(), *message));
  return message;
}

sensor_msgs::ImagePtr depthImage(const stereo_msgs::DisparityImage& disparity) {
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  const auto message = boost::make_shared<sensor_msgs::Image>();
  cv::Mat1f depth_m = allocateImage<float>(disparity.header, map.size(), *message);
  cv::divide(disparity.f * disparity.T, map, depth_m);
  depth_m.setTo(std::numeric_limits<float>::quiet_NaN(),
                map < std::max(0.f, disparity.min_disparity));
  return message;
}

sensor_msgs::PointCloud2Ptr pointCloud(const CloudSource& source, MovingPoints moving) {
  const stereo_msgs::DisparityImage& disparity = *source.disparity;
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  const cv::Mat3b bgr = bgrImage(*source.left, "left");
  const cv::Mat1b mask = source.mask ? greyImage(*source.mask, "moving_objects/mask") : cv::Mat1b();
  requireOneCamera("left image", bgr.size(), "disparity", map.size());
  if (!mask.empty()) requireOneCamera("moving_objects/mask", mask.size(), "disparity", map.size());

  const int stride = source.params.stride;
  auto cloud = boost::make_shared<sensor_msgs::PointCloud2>();
  cloud->header = disparity.header;
  cloud->width = static_cast<uint32_t>((map.cols + stride - 1) / stride);
  cloud->height = static_cast<uint32_t>((map.rows + stride - 1) / stride);
  cloud->is_dense = false;
  using sensor_msgs::PointField;
  sensor_msgs::PointCloud2Modifier(*cloud).setPointCloud2Fields(
      4, "x", 1, PointField::FLOAT32, "y", 1, PointField::FLOAT32, "z", 1, PointField::FLOAT32,
      "rgb", 1, PointField::FLOAT32);

  const float nan = std::numeric_limits<float>::quiet_NaN();
  const StereoRig& rig = source.rig;
  const auto fB = static_cast<float>(rig.disparityTimesDepth());
  const auto fx = static_cast<float>(rig.fx_px), fy = static_cast<float>(rig.fy_px);
  const auto cx = static_cast<float>(rig.cx_left_px), cy = static_cast<float>(rig.cy_px);
  const double max_range_m = source.params.max_range_m > 0
                                 ? source.params.max_range_m
                                 : std::numeric_limits<double>::infinity();
  const auto max_range2 = static_cast<float>(max_range_m * max_range_m);
  sensor_msgs::PointCloud2Iterator<float> xyz(*cloud, "x");
  sensor_msgs::PointCloud2Iterator<uint8_t> rgb(*cloud, "rgb");
  for (int y = 0; y < map.rows; y += stride)
    for (int x = 0; x < map.cols; x += stride, ++xyz, ++rgb) {
      const bool moves = !mask.empty() && mask(y, x);
      const float d = map(y, x);
      cv::Vec3f point(nan, nan, nan);
      if (d >= disparity.min_disparity && d > 0 && !(moves && moving == MovingPoints::kLeftOut)) {
        const float z = fB / d;
        const cv::Vec3f known((static_cast<float>(x) - cx) / fx * z,
                              (static_cast<float>(y) - cy) / fy * z, z);
        if (known.dot(known) <= max_range2) point = known;
      }
      const cv::Vec3b colour =
          moves && moving == MovingPoints::kTinted ? tinted(bgr(y, x)) : bgr(y, x);
      std::copy_n(point.val, 3, &xyz[0]);
      std::copy_n(colour.val, 3, &rgb[0]);
    }
  return cloud;
}

visualization_msgs::MarkerArrayPtr markers(const MovingObjectArray& objects,
                                           const std::optional<CameraPose>& pose) {
  auto result = boost::make_shared<visualization_msgs::MarkerArray>();
  Marker clear;
  clear.header = objects.header;
  clear.action = Marker::DELETEALL;
  clear.pose.orientation.w = 1;
  result->markers.push_back(clear);
  for (const MovingObject& object : objects.objects) {
    result->markers.push_back(box(objects, object));
    result->markers.push_back(text(objects, object));
    if (pose && hasVelocity(object))
      result->markers.push_back(arrow(objects, object, pose->T_odom_cam));
  }
  return result;
}

sensor_msgs::ImagePtr overlay(const sensor_msgs::Image& left, const MovingObjectArray& objects,
                              const sensor_msgs::Image& mask) {
  const cv::Mat1b grey = greyImage(left, "left"), moving = greyImage(mask, "mask");
  requireOneCamera("moving_objects/mask", moving.size(), "left image", grey.size());
  const auto message = boost::make_shared<sensor_msgs::Image>();
  cv::Mat3b image = allocateImage<cv::Vec3b>(left.header, grey.size(), *message);
  cv::cvtColor(grey, image, cv::COLOR_GRAY2BGR);
  cv::add(image, cv::Scalar(0, 0, kTint), image, moving);
  for (const MovingObject& object : objects.objects) {
    const cv::Scalar colour(colourOf(object.id));
    const cv::Rect2d box(object.bbox.center.x - object.bbox.size_x / 2,
                         object.bbox.center.y - object.bbox.size_y / 2, object.bbox.size_x,
                         object.bbox.size_y);
    cv::rectangle(image, box, colour, 2);
    writeLabel(label(object), cv::Point(cvRound(box.x), cvRound(box.y)), image);
  }
  return message;
}

sensor_msgs::ImagePtr residualImage(const MovingObjectsInput& frame) {
  if (!frame.predicted_disparity) return nullptr;
  const stereo_msgs::DisparityImage& measured = *frame.measured_disparity;
  const cv::Mat1f measured_px = floatView(measured.image, "measured_disparity");
  const auto view = [&](const sensor_msgs::Image& map, const char* name) {
    requireOneCamera(name, sizeOf(map), "measured_disparity", measured_px.size());
    return floatView(map, name);
  };
  const auto message = boost::make_shared<sensor_msgs::Image>();
  cv::Mat1f residual = allocateImage<float>(measured.header, measured_px.size(), *message);
  normalizedResidual(measured_px, view(*frame.measured_variance, "measured_variance"),
                     view(frame.predicted_disparity->image, "predicted_disparity"),
                     view(*frame.predicted_variance, "predicted_variance"), rangeOf(measured),
                     residual);
  return message;
}

}  // namespace predictive_stereo
