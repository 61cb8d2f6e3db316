#include "nodelets/disparity_views.h"

#include <sensor_msgs/image_encodings.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "nodelets/image_messages.h"

namespace predictive_stereo {
namespace {

namespace encodings = sensor_msgs::image_encodings;

// Half the pixel's own colour, half red.
cv::Vec3b tinted(const cv::Vec3b& bgr) {
  return {static_cast<uint8_t>(bgr[0] / 2), static_cast<uint8_t>(bgr[1] / 2),
          static_cast<uint8_t>(128 + bgr[2] / 2)};
}

}  // namespace

sensor_msgs::ImageConstPtr innerImage(const stereo_msgs::DisparityImageConstPtr& disparity) {
  return sensor_msgs::ImageConstPtr(disparity, &disparity->image);
}

sensor_msgs::ImagePtr colourImage(const stereo_msgs::DisparityImage& disparity) {
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  const auto message = newImage(disparity.header, map.size(), encodings::BGR8);
  cv::Mat3b colour = writableView<cv::Vec3b>(*message);
  const double scale = 255.0 / (disparity.max_disparity - disparity.min_disparity);
  cv::Mat1b level;
  map.convertTo(level, CV_8U, scale, -disparity.min_disparity * scale);
  cv::applyColorMap(level, colour, cv::COLORMAP_TURBO);
  colour.setTo(cv::Scalar::all(0), map < disparity.min_disparity);
  return message;
}

sensor_msgs::ImagePtr standardDeviationImage(const sensor_msgs::Image& variance) {
  const cv::Mat1f variance_px2 = floatView(variance, "disparity_variance");
  const auto message = newImage(variance.header, variance_px2.size(), encodings::TYPE_32FC1);
  cv::sqrt(variance_px2, writableView<float>(*message));
  return message;
}

sensor_msgs::ImagePtr depthImage(const stereo_msgs::DisparityImage& disparity) {
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  const auto message = newImage(disparity.header, map.size(), encodings::TYPE_32FC1);
  cv::Mat1f depth_m = writableView<float>(*message);
  const float disparity_times_depth = disparity.f * disparity.T;
  for (int y = 0; y < map.rows; ++y)
    for (int x = 0; x < map.cols; ++x) {
      const float d = map(y, x);
      if (d < disparity.min_disparity || d < 0)
        depth_m(y, x) = std::numeric_limits<float>::quiet_NaN();
      else
        depth_m(y, x) = d > 0 ? disparity_times_depth / d : std::numeric_limits<float>::infinity();
    }
  return message;
}

sensor_msgs::CameraInfoPtr depthCameraInfo(const StereoPair& pair) {
  auto info = boost::make_shared<sensor_msgs::CameraInfo>(*pair.left_info);
  info->header = pair.left->header;
  return info;
}

sensor_msgs::PointCloud2Ptr pointCloud(const stereo_msgs::DisparityImage& disparity,
                                       const StereoRig& rig, const sensor_msgs::Image& left,
                                       const sensor_msgs::Image* moving_mask,
                                       const PointsParams& params, MovingPoints moving) {
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  const cv::Mat3b bgr = bgrImage(left, "left");
  cv::Mat1b unused;
  const cv::Mat1b mask =
      moving_mask ? greyImage(*moving_mask, "moving_objects/mask", unused) : cv::Mat1b();
  requireOneCamera("left image", bgr.size(), "disparity", map.size());
  if (!mask.empty()) requireOneCamera("moving_objects/mask", mask.size(), "disparity", map.size());

  const int stride = params.stride;
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
  const auto fB = static_cast<float>(rig.disparityTimesDepth());
  const auto fx = static_cast<float>(rig.fx_px), fy = static_cast<float>(rig.fy_px);
  const auto cx = static_cast<float>(rig.cx_left_px), cy = static_cast<float>(rig.cy_px);
  const double max_range_m =
      params.max_range_m > 0 ? params.max_range_m : std::numeric_limits<double>::infinity();
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

}  // namespace predictive_stereo
