/// Camera messages with any field changed, as hostile bags and broken drivers send them: through
/// what replay and the nodelets run, and through what reads bags.
#include <console_bridge/console.h>
#include <ros/console.h>
#include <rosbag/bag.h>
#include <sensor_msgs/image_encodings.h>
#include <tf2_msgs/TFMessage.h>

#include <boost/make_shared.hpp>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "bytes.h"
#include "evaluation/tools/bag_sequence.h"
#include "nodelets/message_checks.h"
#include "nodelets/rectifier.h"
#include "nodelets/views.h"
#include "tools/bag_check.h"
#include "tools/pipeline_processor.h"

using namespace predictive_stereo;

namespace {

namespace encodings = sensor_msgs::image_encodings;

constexpr unsigned kWidth = 48, kHeight = 24;

uint32_t anyUnsigned(Bytes& bytes) {
  const uint8_t kind = bytes.byte();
  if (kind % 4 == 0) return bytes.raw<uint32_t>();
  if (kind % 4 == 1) return std::numeric_limits<uint32_t>::max() >> (kind / 4 % 32);
  return bytes.raw<uint8_t>();
}

std::string anyEncoding(Bytes& bytes) {
  static const std::string known[] = {encodings::MONO8,
                                      encodings::MONO16,
                                      encodings::BGR8,
                                      encodings::RGB8,
                                      encodings::BGRA8,
                                      encodings::RGBA8,
                                      encodings::TYPE_8UC1,
                                      encodings::TYPE_8UC3,
                                      encodings::TYPE_8UC4,
                                      encodings::TYPE_32FC1,
                                      encodings::TYPE_64FC4,
                                      encodings::BAYER_RGGB8,
                                      encodings::BAYER_BGGR8,
                                      encodings::BAYER_GBRG8,
                                      encodings::BAYER_GRBG8,
                                      encodings::YUV422,
                                      "",
                                      "8UC",
                                      "$(true)",
                                      "mono8\n"};
  return known[bytes.byte() % std::size(known)];
}

void changeStamp(Bytes& bytes, ros::Time& stamp) {
  static const uint32_t extremes[] = {0, 1, 0x7fffffffu, 0x80000000u, 4200000000u, 0xffffffffu};
  if (bytes.byte() % 2) {
    stamp.sec = extremes[bytes.byte() % std::size(extremes)];
    stamp.nsec = bytes.byte() % 2 ? 999999999 : bytes.raw<uint32_t>();
    return;
  }
  stamp.sec = bytes.byte() % 2 ? stamp.sec + bytes.byte() : bytes.raw<uint32_t>();
  stamp.nsec = bytes.byte() % 2 ? bytes.raw<uint32_t>() % 1000000000 : 0;
}

void changeImage(Bytes& bytes, sensor_msgs::Image& image) {
  switch (bytes.byte() % 9) {
    case 0:
      image.width = anyUnsigned(bytes);
      break;
    case 1:
      image.height = anyUnsigned(bytes);
      break;
    case 2:
      image.step = anyUnsigned(bytes);
      break;
    case 3:
      image.encoding = anyEncoding(bytes);
      break;
    case 4:
      image.data.resize(anyUnsigned(bytes) % 20000);
      break;
    case 5:
      image.is_bigendian = bytes.byte();
      break;
    case 6:
      image.header.frame_id = std::string(bytes.byte() % 4, static_cast<char>(bytes.byte()));
      break;
    case 7:
      changeStamp(bytes, image.header.stamp);
      break;
    case 8:  // everything, as it should be: another size or encoding
      image.encoding = anyEncoding(bytes);
      image.width = bytes.whole(0, 70);
      image.height = bytes.whole(0, 30);
      image.step = image.width * static_cast<uint32_t>(bytes.whole(1, 4));
      image.data.resize(size_t{image.step} * image.height, 100);
      break;
  }
}

void changeInfo(Bytes& bytes, sensor_msgs::CameraInfo& info) {
  switch (bytes.byte() % 10) {
    case 0:
      info.width = anyUnsigned(bytes);
      break;
    case 1:
      info.height = anyUnsigned(bytes);
      break;
    case 2:
      info.P[bytes.byte() % 12] = bytes.number(50);
      break;
    case 3:
      info.K[bytes.byte() % 9] = bytes.number(50);
      break;
    case 4:
      info.R[bytes.byte() % 9] = bytes.number(1);
      break;
    case 5:
      info.D.resize(bytes.byte() % 16);
      for (double& d : info.D) d = bytes.number(0.1);
      break;
    case 6: {
      static const char* const models[] = {
          "plumb_bob", "rational_polynomial", "equidistant", "fisheye", "", "unknown"};
      info.distortion_model = models[bytes.byte() % std::size(models)];
      break;
    }
    case 7:
      info.binning_x = anyUnsigned(bytes);
      info.binning_y = anyUnsigned(bytes);
      break;
    case 8:
      info.roi.x_offset = anyUnsigned(bytes);
      info.roi.y_offset = anyUnsigned(bytes);
      info.roi.width = anyUnsigned(bytes);
      info.roi.height = anyUnsigned(bytes);
      break;
    case 9:
      changeStamp(bytes, info.header.stamp);
      break;
  }
}

void changeTransform(Bytes& bytes, geometry_msgs::TransformStamped& message) {
  double* const numbers[] = {&message.transform.translation.x, &message.transform.translation.y,
                             &message.transform.translation.z, &message.transform.rotation.x,
                             &message.transform.rotation.y,    &message.transform.rotation.z,
                             &message.transform.rotation.w};
  const uint8_t kind = bytes.byte() % 8;
  if (kind == 0) message.header.frame_id = message.child_frame_id;
  if (kind == 1) message.child_frame_id.clear();
  if (kind < 4) return changeStamp(bytes, message.header.stamp);
  *numbers[bytes.byte() % std::size(numbers)] = bytes.number(1);
}

/// Messages that may be changed, and the pair that they are.
struct Camera {
  Camera(Bytes& bytes, int index) {
    const uint8_t texture = bytes.byte();
    for (int side = 0; side < 2; ++side) {
      image[side] = boost::make_shared<sensor_msgs::Image>();
      sensor_msgs::Image& message = *image[side];
      message.header.stamp = ros::Time(1000) + ros::Duration(0.1 * index);
      message.header.frame_id = "camera";
      message.encoding = encodings::MONO8;
      message.width = message.step = kWidth;
      message.height = kHeight;
      message.data.resize(kWidth * kHeight);
      for (unsigned i = 0; i < message.data.size(); ++i) {
        const unsigned x = i % kWidth + (side ? 5u : 0u) + static_cast<unsigned>(index);
        message.data[i] = static_cast<uint8_t>(x * 37 % 101 * (i / kWidth + texture) * 53 % 251);
      }
      info[side] = boost::make_shared<sensor_msgs::CameraInfo>();
      info[side]->header = message.header;
      info[side]->width = kWidth;
      info[side]->height = kHeight;
      info[side]->distortion_model = "plumb_bob";
      info[side]->D.assign(5, 0.01);
      info[side]->K = {50, 0, 24, 0, 50, 12, 0, 0, 1};
      info[side]->R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
      info[side]->P = {50, 0, 24, side ? -20.0 : 0.0, 0, 50, 12, 0, 0, 0, 1, 0};
    }
  }

  StereoPair pair() const { return {image[0], image[1], info[0], info[1]}; }

  sensor_msgs::ImagePtr image[2];
  sensor_msgs::CameraInfoPtr info[2];
};

geometry_msgs::TransformStamped extrinsic(double stamp_s) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = ros::Time(stamp_s);
  message.header.frame_id = "base_link";
  message.child_frame_id = "camera";
  message.transform.rotation.w = 1;
  return message;
}

// Messages of a foreign Disparity nodelet.
void changeMaps(Bytes& bytes, stereo_msgs::DisparityImage& disparity,
                sensor_msgs::Image& variance) {
  const auto value = [&] { return static_cast<float>(bytes.number(10)); };
  switch (bytes.byte() % 8) {
    case 0:
      disparity.min_disparity = value();
      break;
    case 1:
      disparity.max_disparity = value();
      break;
    case 2:
      disparity.f = value();
      break;
    case 3:
      disparity.T = value();
      break;
    case 4:
      changeImage(bytes, disparity.image);
      break;
    case 5:
      changeImage(bytes, variance);
      break;
    default:
      for (auto* data : {&disparity.image.data, &variance.data})
        for (int i = 0; i < 16 && data->size() >= 4; ++i) {
          const float written = value();
          const size_t at = bytes.raw<uint16_t>() % (data->size() / 4) * 4;
          std::memcpy(data->data() + at, &written, 4);
        }
  }
}

void lookAt(const PipelineProcessor::Output& frame, const StereoPair& pair) {
  const stereo_msgs::DisparityImage& disparity = *frame.disparity.disparity;
  colourImage(disparity);
  standardDeviationImage(*frame.disparity.disparity_variance);
  depthImage(disparity);
  pointCloud({frame.disparity.disparity, pair.left, stereoRig(pair), {}, frame.moving_objects.mask},
             MovingPoints::kTinted);
  overlay(*pair.left, *frame.moving_objects.objects, *frame.moving_objects.mask);
  markers(*frame.moving_objects.objects, frame.moving_objects.pose);
}

AllNodeletParams params() {
  AllNodeletParams params;
  params.disparity.disparity.matcher.range.count = 16;
  params.moving_objects.detection.range.count = 16;
  return params;
}

void processPairs(Bytes& bytes) {
  tf2::BufferCore tf;
  PipelineProcessor processor(params(), tf);
  MovingObjectsProcessor moving(params().moving_objects);
  Rectifier rectifiers[2];
  geometry_msgs::TransformStamped transform = extrinsic(1000);
  if (bytes.byte() % 4 == 0) changeTransform(bytes, transform);
  mayRefuse([&] {
    requireTransform(transform, ZeroStamp::kLegal, "fuzz");
    tf.setTransform(transform, "fuzz", bytes.byte() % 2);
  });
  const int pairs = 1 + bytes.byte() % 3;
  for (int i = 0; i < pairs; ++i) {
    Camera camera(bytes, i);
    for (int change = bytes.byte() % 4; change > 0; --change) {
      const uint8_t what = bytes.byte();
      if (what & 1)
        changeImage(bytes, *camera.image[what / 2 % 2]);
      else
        changeInfo(bytes, *camera.info[what / 2 % 2]);
    }
    StereoPair pair = camera.pair();
    mayRefuse([&] {
      if (bytes.byte() % 4 == 0) {
        pair.left = rectifiers[0].rectify(*pair.left, *pair.left_info);
        pair.right = rectifiers[1].rectify(*pair.right, *pair.right_info);
      }
      const auto frame = processor.process(pair);
      if (!frame) return;
      lookAt(*frame, pair);
      if (bytes.left() == 0) return;
      MovingObjectsInput input = frame->disparity;
      const auto disparity =
          boost::make_shared<stereo_msgs::DisparityImage>(*frame->disparity.measured_disparity);
      const auto variance =
          boost::make_shared<sensor_msgs::Image>(*frame->disparity.measured_variance);
      changeMaps(bytes, *disparity, *variance);
      input.measured_disparity = disparity;
      input.measured_variance = variance;
      if (bytes.byte() % 2) {
        input.predicted_disparity = disparity;
        input.predicted_variance = variance;
      }
      mayRefuse([&] { colourImage(*disparity); });
      mayRefuse([&] { depthImage(*disparity); });
      mayRefuse([&] { standardDeviationImage(*variance); });
      moving.process(input, frame->moving_objects.pose);
    });
  }
}

void readBag(Bytes& bytes) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("fuzz_" + std::to_string(getpid()) + ".bag");
  {
    rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
    const char* const ns = bytes.byte() % 2 ? "/stereo" : "/a b/$(c)/..";
    const int pairs = bytes.byte() % 4;
    for (int i = 0; i < pairs; ++i) {
      Camera camera(bytes, i);
      const ros::Time time = camera.image[0]->header.stamp;
      for (int change = bytes.byte() % 4; change > 0; --change) {
        const uint8_t what = bytes.byte();
        if (what & 1)
          changeImage(bytes, *camera.image[what / 2 % 2]);
        else
          changeInfo(bytes, *camera.info[what / 2 % 2]);
      }
      for (int side = 0; side < 2; ++side) {
        const std::string topic = std::string(ns) + (side ? "/right" : "/left");
        bag.write(topic + "/image_rect", time, *camera.image[side]);
        bag.write(topic + "/camera_info", time, *camera.info[side]);
      }
      tf2_msgs::TFMessage tf;
      tf.transforms.push_back(extrinsic(time.toSec()));
      if (bytes.byte() % 4 == 0) changeTransform(bytes, tf.transforms[0]);
      bag.write("/tf", time, tf);
    }
  }
  mayRefuse([&] {
    const rosbag::Bag bag(path.string());
    for (const BagFinding& found : checkBag(bag).findings)
      if (found.text.empty()) finding("check_bag finds something and does not say what");
  });
  mayRefuse([&] {
    const auto sequence = bagSequence(path.string(), {});
    for (int i = 0; i < sequence->frames(); ++i) sequence->frame(i);
  });
  std::filesystem::remove(path);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  cv::setNumThreads(1);
  console_bridge::noOutputHandler();
  if (ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Fatal))
    ros::console::notifyLoggerLevelsChanged();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Bytes bytes(data, size);
  if (bytes.byte() % 4 == 0)
    readBag(bytes);
  else
    processPairs(bytes);
  return 0;
}
