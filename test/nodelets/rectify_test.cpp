/// rectify:=true for cameras that publish raw images.
#include <gtest/gtest.h>
#include <ros/ros.h>
#include <sensor_msgs/CompressedImage.h>

#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "nodelets/disparity_processor.h"
#include "nodelets/rectifier.h"
#include "nodelets/stereo_messages.h"
#include "recorder.h"
#include "street_camera.h"

namespace predictive_stereo {
namespace {

const StreetCamera& street() {
  static const StreetCamera street(2);
  return street;
}

/// A rotated camera with lens distortion, whose images need rectification.
struct RawCamera {
  std::string model;
  std::vector<double> D;
  cv::Vec3d rotation_rad;

  sensor_msgs::CameraInfoPtr info(const sensor_msgs::CameraInfo& rectified) const {
    auto info = boost::make_shared<sensor_msgs::CameraInfo>(rectified);
    const double f = 0.97 * rectified.P[0];
    info->K = {f, 0, rectified.P[2] + 4, 0, 1.01 * f, rectified.P[6] - 3, 0, 0, 1};
    cv::Matx33d R;
    cv::Rodrigues(rotation_rad, R);
    std::copy_n(R.val, 9, info->R.begin());
    info->distortion_model = model;
    info->D = D;
    return info;
  }

  /// The raw image of this camera for the scene of the image `rectified`.
  cv::Mat1b see(const cv::Mat1b& rectified, const sensor_msgs::CameraInfo& info) const {
    const cv::Matx33d K(info.K.data()), R(info.R.data());
    const cv::Matx33d P(info.P[0], 0, info.P[2], 0, info.P[5], info.P[6], 0, 0, 1);
    std::vector<cv::Point2f> pixels, seen;
    for (int y = 0; y < rectified.rows; ++y)
      for (int x = 0; x < rectified.cols; ++x)
        pixels.emplace_back(static_cast<float>(x), static_cast<float>(y));
    if (model == "equidistant")
      cv::fisheye::undistortPoints(pixels, seen, K, D, R, P);
    else
      cv::undistortPoints(pixels, seen, K, D, R, P);
    cv::Mat1b raw;
    cv::remap(rectified, raw, cv::Mat(seen).reshape(2, rectified.rows), cv::Mat(), cv::INTER_CUBIC,
              cv::BORDER_REPLICATE);
    return raw;
  }
};

const RawCamera kLeft{"plumb_bob", {-0.25, 0.08, 0.002, -0.001, 0.0}, {0.01, -0.02, 0.015}};
const RawCamera kRight{"plumb_bob", {-0.22, 0.06, -0.001, 0.001, 0.0}, {-0.012, 0.01, -0.02}};

cv::Mat1b pixels(const sensor_msgs::Image& message) { return greyImage(message, "left"); }

StereoPair rawPair(int index) {
  StereoPair pair = street().pair(index);
  const auto left_info = kLeft.info(*pair.left_info), right_info = kRight.info(*pair.right_info);
  pair.left = street().image(kLeft.see(pixels(*pair.left), *left_info), street().stamp(index));
  pair.right = street().image(kRight.see(pixels(*pair.right), *right_info), street().stamp(index));
  pair.left_info = left_info;
  pair.right_info = right_info;
  return pair;
}

cv::Mat1f disparityOf(const StereoPair& pair) {
  DisparityProcessor processor{DisparityNodeletParams()};
  processor.begin(pair);
  const DisparityMessages messages = processor.process({});
  return floatView(messages.disparity->image, "disparity").clone();
}

/// Share of the pixels with truth whose disparity in `map` is right within 1 px.
double agreement(const cv::Mat1f& map, const cv::Mat1f& truth) {
  const cv::Rect inside(20, 10, truth.cols - 40, truth.rows - 20);
  const cv::Mat known = truth(inside) >= 0;
  const cv::Mat close = known & (cv::abs(map(inside) - truth(inside)) < 1);
  return static_cast<double>(cv::countNonZero(close)) / cv::countNonZero(known);
}

TEST(Rectifier, undoes_lenses_of_all_models) {
  const StereoPair pair = street().pair(0);
  // Smooth, so that two interpolations change little.
  cv::Mat1b truth;
  cv::GaussianBlur(pixels(*pair.left), truth, cv::Size(), 2);
  for (const RawCamera& camera :
       {kLeft, RawCamera{"rational_polynomial", {-0.2, 0.1, 0, 0, 0.01, 0.02, 0.03, 0.01}, {}},
        RawCamera{"equidistant", {-0.02, 0.01, -0.004, 0.001}, {0.01, 0.0, 0.02}},
        RawCamera{"", {}, {0.02, 0.01, 0.0}}}) {
    const auto info = camera.info(*pair.left_info);
    const cv::Mat1b raw = camera.see(truth, *info);
    Rectifier rectifier;
    const auto result = rectifier.rectify(*street().image(raw, street().stamp(0)), *info);
    EXPECT_EQ(result->header.frame_id, pair.left->header.frame_id);
    EXPECT_EQ(result->header.stamp, pair.left->header.stamp);
    const cv::Rect inside(40, 20, truth.cols - 80, truth.rows - 40);
    const cv::Mat1b rectified = writableView<uint8_t>(*result);
    const double before = cv::norm(raw(inside), truth(inside), cv::NORM_L1) / inside.area();
    const double after = cv::norm(rectified(inside), truth(inside), cv::NORM_L1) / inside.area();
    EXPECT_GT(before, 5) << camera.model;
    EXPECT_LT(after, 0.7) << camera.model;
  }
}

TEST(Rectifier, takes_cropped_images) {
  const StereoPair pair = street().pair(0);
  const auto info = kLeft.info(*pair.left_info);
  const cv::Mat1b raw = kLeft.see(pixels(*pair.left), *info);
  Rectifier whole;
  const auto expected = whole.rectify(*street().image(raw, street().stamp(0)), *info);

  auto cropped_info = boost::make_shared<sensor_msgs::CameraInfo>(*info);
  cropped_info->roi.x_offset = 32;
  cropped_info->roi.y_offset = 8;
  cropped_info->roi.width = 320;
  cropped_info->roi.height = 112;
  const cv::Rect crop(32, 8, 320, 112), inside(40, 20, 240, 72);
  Rectifier rectifier;
  const auto cropped =
      rectifier.rectify(*street().image(raw(crop).clone(), street().stamp(0)), *cropped_info);
  const cv::Mat1b expected_crop = writableView<uint8_t>(*expected)(crop);
  EXPECT_LT(cv::norm(writableView<uint8_t>(*cropped)(inside), expected_crop(inside), cv::NORM_INF),
            2);
}

TEST(Rectifier, names_what_it_cannot_use) {
  const StereoPair pair = street().pair(0);
  Rectifier rectifier;
  const auto refusal = [&](const sensor_msgs::CameraInfo& info) -> std::string {
    try {
      rectifier.rectify(*pair.left, info);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  auto info = kLeft.info(*pair.left_info);
  EXPECT_EQ(refusal(*info), "");
  const sensor_msgs::CameraInfo good = *info;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double* number : {&info->K[2], &info->D[1], &info->P[6]}) {
    const double before = std::exchange(*number, nan);
    EXPECT_NE(refusal(*info).find("is not finite"), std::string::npos);
    *number = before;
  }
  const auto expected = Rectifier().rectify(*pair.left, good);
  for (const char* model : {"plumb_bob", "equidistant"}) {
    info->distortion_model = model;
    info->D.assign(model == std::string("plumb_bob") ? 5 : 4, 1e6);
    EXPECT_NE(refusal(*info).find("shows next to nothing"), std::string::npos) << model;
    EXPECT_EQ(rectifier.rectify(*pair.left, good)->data, expected->data) << "it goes on";
  }
  *info = good;
  info->distortion_model = "kannala";
  EXPECT_NE(refusal(*info).find("distortion_model 'kannala'"), std::string::npos);
  info->distortion_model = "plumb_bob";
  info->D.resize(3);
  EXPECT_NE(refusal(*info).find("camera_info cannot be used"), std::string::npos);
  info->R.fill(0);
  EXPECT_NE(refusal(*info).find("is no rotation"), std::string::npos);
  info->K[0] = 0;
  EXPECT_NE(refusal(*info).find("no calibration"), std::string::npos);
}

/// Sends a raw pair to the nodelets of a namespace; `packed` converts an image to its message.
template <class Pack>
cv::Mat1f rectifiedDisparity(const std::string& ns, const std::string& topic, const StereoPair& raw,
                             const Pack& packed) {
  ros::NodeHandle camera(ns);
  using Message = std::decay_t<decltype(packed(*raw.left))>;
  auto left = camera.advertise<Message>("left/" + topic, 5);
  auto right = camera.advertise<Message>("right/" + topic, 5);
  auto left_info = camera.advertise<sensor_msgs::CameraInfo>("left/camera_info", 5);
  auto right_info = camera.advertise<sensor_msgs::CameraInfo>("right/camera_info", 5);
  Recorder<stereo_msgs::DisparityImage> disparity(camera, "disparity");
  // The rectifier and the nodelets subscribe to each camera_info; they share a process.
  EXPECT_TRUE(eventually([&] {
    return disparity.connected() && left.getNumSubscribers() > 0 && right.getNumSubscribers() > 0 &&
           left_info.getNumSubscribers() > 0 && right_info.getNumSubscribers() > 0;
  }));
  for (int round = 0; round < 20 && disparity.count() == 0; ++round) {
    const auto stamped = [&](const auto& message) {
      auto copy = boost::make_shared<std::decay_t<decltype(*message)>>(*message);
      copy->header.stamp += ros::Duration(0.1 * round);
      return copy;
    };
    left_info.publish(stamped(raw.left_info));
    right_info.publish(stamped(raw.right_info));
    left.publish(packed(*stamped(raw.left)));
    right.publish(packed(*stamped(raw.right)));
    eventually([&] { return disparity.count() > 0; }, 1);
  }
  if (disparity.count() == 0) return {};
  return floatView(disparity.last()->image, "disparity").clone();
}

TEST(RectifyNodelet, raw_pairs_match_after_rectification) {
  const StereoPair raw = rawPair(0);
  const cv::Mat1f rectified = rectifiedDisparity(
      "/raw", "image_raw", raw, [](const sensor_msgs::Image& image) { return image; });
  ASSERT_FALSE(rectified.empty());
  const cv::Mat1f truth = disparityOf(street().pair(0));
  EXPECT_GT(agreement(rectified, truth), 0.9);
  EXPECT_LT(agreement(disparityOf(raw), truth), 0.5) << "raw pairs match as they are";
}

TEST(RectifyNodelet, takes_compressed_images) {
  const cv::Mat1f rectified = rectifiedDisparity(
      "/packed", "image_raw/compressed", rawPair(0), [](const sensor_msgs::Image& image) {
        sensor_msgs::CompressedImage message;
        message.header = image.header;
        message.format = "mono8; png compressed ";
        cv::imencode(".png", pixels(image), message.data);
        return message;
      });
  ASSERT_FALSE(rectified.empty());
  EXPECT_GT(agreement(rectified, disparityOf(street().pair(0))), 0.9);
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "rectify_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
