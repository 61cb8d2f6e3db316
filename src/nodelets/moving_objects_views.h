/// Moving objects as images and as rviz markers, on demand.
#pragma once

#include <predictive_stereo/MovingObjectArray.h>
#include <sensor_msgs/Image.h>
#include <stereo_msgs/DisparityImage.h>
#include <visualization_msgs/MarkerArray.h>

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <optional>

#include "predictive_stereo/disparity_motion.h"

namespace predictive_stereo {

/// The first marker deletes those of the previous frame. Then each object has a 3-D box, a label
/// with id, distance and speed, and an arrow for its motion in one second (if its velocity and the
/// camera's pose are known).
visualization_msgs::MarkerArrayPtr markers(const MovingObjectArray& objects,
                                           const std::optional<CameraPose>& pose);

/// The left image (bgr8) with moving pixels tinted red, and the boxes and labels of the objects.
/// @throws std::invalid_argument for an image that is not 8-bit, or a mask with another size.
sensor_msgs::ImagePtr overlay(const sensor_msgs::Image& left, const MovingObjectArray& objects,
                              const sensor_msgs::Image& mask);

/// The residual of normalizedResidual as 32FC1.
/// @throws std::invalid_argument for maps that are not 32FC1 or differ in size.
sensor_msgs::ImagePtr residualImage(const stereo_msgs::DisparityImage& measured,
                                    const sensor_msgs::Image& measured_variance,
                                    const stereo_msgs::DisparityImage& predicted,
                                    const sensor_msgs::Image& predicted_variance);

/// Moving objects as vision_msgs/Detection3DArray, which has no fields for velocity and distance.
/// `results` has one hypothesis: the object's id, score and pose, whose covariance is zero
/// (unknown).
///
/// The message type is a template argument because vision_msgs is optional at build time.
template <class Detection3DArray>
boost::shared_ptr<Detection3DArray> detections3d(const MovingObjectArray& objects) {
  auto array = boost::make_shared<Detection3DArray>();
  array->header = objects.header;
  array->detections.resize(objects.objects.size());
  for (size_t i = 0; i < objects.objects.size(); ++i) {
    const MovingObject& object = objects.objects[i];
    auto& detection = array->detections[i];
    detection.header = objects.header;
    detection.bbox.center = object.pose;
    detection.bbox.size = object.size;
    detection.results.resize(1);
    detection.results[0].id = object.id;
    detection.results[0].score = object.score;
    detection.results[0].pose.pose = object.pose;
  }
  return array;
}

}  // namespace predictive_stereo
