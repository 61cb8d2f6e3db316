#include "nodelets/disparity_views.h"

#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "nodelets/image_messages.h"

namespace predictive_stereo {
namespace {

namespace encodings = sensor_msgs::image_encodings;

sensor_msgs::PointField field(const char* name, uint32_t offset) {
  sensor_msgs::PointField result;
  result.name = name;
  result.offset = offset;
  result.datatype = sensor_msgs::PointField::FLOAT32;
  result.count = 1;
  return result;
}

// Half the pixel's own colour, half red.
cv::Vec3b tinted(const cv::Vec3b& bgr) {
  return {static_cast<uint8_t>(bgr[0] / 2), static_cast<uint8_t>(bgr[1] / 2),
          static_cast<uint8_t>(128 + bgr[2] / 2)};
}

void requireSize(const char* name, cv::Size size, cv::Size expected) {
  if (size == expected) return;
  const auto text = [](cv::Size s) {
    return std::to_string(s.width) + "x" + std::to_string(s.height);
  };
  throw std::invalid_argument(std::string(name) + " is " + text(size) + " but disparity is " +
                              text(expected) + "; do the topics belong to one camera?");
}

}  // namespace

sensor_msgs::ImageConstPtr innerImage(const stereo_msgs::DisparityImageConstPtr& disparity) {
  return sensor_msgs::ImageConstPtr(disparity, &disparity->image);
}

sensor_msgs::ImagePtr colourImage(const stereo_msgs::DisparityImage& disparity) {
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  auto message = boost::make_shared<sensor_msgs::Image>();
  allocateImage(disparity.header, map.size(), encodings::BGR8, *message);
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
  auto message = boost::make_shared<sensor_msgs::Image>();
  allocateImage(variance.header, variance_px2.size(), encodings::TYPE_32FC1, *message);
  cv::Mat1f deviation_px = writableView<float>(*message);
  cv::sqrt(variance_px2, deviation_px);
  return message;
}

sensor_msgs::ImagePtr depthImage(const stereo_msgs::DisparityImage& disparity) {
  const cv::Mat1f map = floatView(disparity.image, "disparity");
  auto message = boost::make_shared<sensor_msgs::Image>();
  allocateImage(disparity.header, map.size(), encodings::TYPE_32FC1, *message);
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
  requireSize("left image", bgr.size(), map.size());
  if (!mask.empty()) requireSize("moving_objects/mask", mask.size(), map.size());

  constexpr uint32_t kPointBytes = 16;
  const int stride = params.stride;
  auto cloud = boost::make_shared<sensor_msgs::PointCloud2>();
  cloud->header = disparity.header;
  cloud->width = static_cast<uint32_t>((map.cols + stride - 1) / stride);
  cloud->height = static_cast<uint32_t>((map.rows + stride - 1) / stride);
  cloud->fields = {field("x", 0), field("y", 4), field("z", 8), field("rgb", 12)};
  cloud->is_bigendian = false;
  cloud->is_dense = false;
  cloud->point_step = kPointBytes;
  cloud->row_step = kPointBytes * cloud->width;
  cloud->data.resize(static_cast<size_t>(cloud->row_step) * cloud->height);

  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto fB = static_cast<float>(rig.disparityTimesDepth());
  const auto fx = static_cast<float>(rig.fx_px), fy = static_cast<float>(rig.fy_px);
  const auto cx = static_cast<float>(rig.cx_left_px), cy = static_cast<float>(rig.cy_px);
  const double max_range_m =
      params.max_range_m > 0 ? params.max_range_m : std::numeric_limits<double>::infinity();
  const auto max_range2 = static_cast<float>(max_range_m * max_range_m);
  uint8_t* out = cloud->data.data();
  for (int y = 0; y < map.rows; y += stride)
    for (int x = 0; x < map.cols; x += stride, out += kPointBytes) {
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
      const uint8_t rgb[4] = {colour[0], colour[1], colour[2], 0};
      std::memcpy(out, point.val, sizeof(point.val));
      std::memcpy(out + 12, rgb, sizeof(rgb));
    }
  return cloud;
}

}  // namespace predictive_stereo
