#pragma once

#include <predictive_stereo/MovingObjectArray.h>

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>

namespace predictive_stereo {

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
