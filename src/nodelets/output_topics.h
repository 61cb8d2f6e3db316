/// The output topics of the nodelets, but for tf, and how their messages are made: the nodelets
/// publish them, `replay` writes them. Each function calls visit(topic, make), see Outputs.
#pragma once

#include "nodelets/disparity_processor.h"
#include "nodelets/ego_motion_processor.h"
#include "nodelets/moving_objects_processor.h"
#include "nodelets/outputs.h"
#include "nodelets/views.h"

namespace predictive_stereo {

/// The row alignment comes first: a node that waits for the motion then has it for its next frame.
template <class Visit>
void visitEgoMotionOutputs(Visit&& visit) {
  using O = EgoMotionProcessor::Output;
  visit({"odometry/row_alignment", 10}, &O::row_alignment);
  visit({"odometry", 10}, &O::odometry);
  visit({"odometry/pose", 10}, &O::pose);
}

/// @param visit_input  for the inputs of MovingObjects. The row alignment comes first: it is not
///   waited for.
template <class Visit, class VisitInput>
void visitDisparityOutputs(Visit&& visit, VisitInput&& visit_input) {
  using O = DisparityMessages;
  visit({"disparity"}, &O::disparity);
  visit({"disparity_variance"}, &O::disparity_variance);
  visit_input({"row_alignment"}, &MovingObjectsInput::row_alignment);
  visit_input({"measured_disparity"}, &MovingObjectsInput::measured_disparity);
  visit_input({"measured_variance"}, &MovingObjectsInput::measured_variance);
  visit_input({"predicted_disparity"}, &MovingObjectsInput::predicted_disparity);
  visit_input({"predicted_variance"}, &MovingObjectsInput::predicted_variance);
  visit({"search_range"}, &O::search_range);
  visit({"disparity/image"}, [](const O& o) {  // shares the memory of the disparity
    return sensor_msgs::ImageConstPtr(o.disparity, &o.disparity->image);
  });
  visit({"disparity/color", 5, true}, [](const O& o) { return colourImage(*o.disparity); });
  visit({"disparity/standard_deviation"},
        [](const O& o) { return standardDeviationImage(*o.disparity_variance); });
  visit({"depth/image_rect"}, [](const O& o) { return depthImage(*o.disparity); });
  visit({"depth/camera_info"}, [](const O& o) {
    const auto info = boost::make_shared<sensor_msgs::CameraInfo>(*o.left_info);
    info->header = o.left->header;
    return info;
  });
}

/// No cloud without moving objects if these are not known: for a planner it is better than one with
/// possible moving objects.
template <class Visit>
void visitCloudOutputs(Visit&& visit) {
  using S = CloudSource;
  visit({"points2"}, [](const S& s) { return pointCloud(s, MovingPoints::kTinted); });
  visit({"points2_static"},
        [](const S& s) { return s.mask ? pointCloud(s, MovingPoints::kLeftOut) : nullptr; });
}

template <class Visit>
void visitMovingObjectsOutputs(Visit&& visit) {
  using O = MovingObjectsProcessor::Output;
  visit({"moving_objects", 10}, &O::objects);
  visit({kMaskTopic, 5, true}, &O::mask);
  visit({"moving_objects/residual"}, [](const O& o) { return residualImage(o.input); });
  visit({"moving_objects/markers"}, [](const O& o) { return markers(*o.objects, o.pose); });
  visit({"moving_objects/image", 5, true},
        [](const O& o) { return overlay(*o.input.left, *o.objects, *o.mask); });
}

}  // namespace predictive_stereo
