/// What a view of the current frame refers to: a test sets what it needs.
#pragma once

#include "detection/frame_history.h"

namespace predictive_stereo {

struct FrameParts {
  DetectionInput input;
  DisparityRange range;
  MotionDetectionParams params;
  RememberedFrame current;
  DepthCells cells;
  std::optional<GroundPlane> ground;
  Obstacles obstacles;
  const FrameView frame{input, range, params, current, cells, ground, obstacles};
};

}  // namespace predictive_stereo
