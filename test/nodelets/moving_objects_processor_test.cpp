#include "nodelets/moving_objects_processor.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "nodelets/disparity_processor.h"
#include "street_camera.h"

namespace predictive_stereo {
namespace {

const StreetCamera& street() {
  static const StreetCamera street(2);
  return street;
}

MovingObjectsInput inputAt(int index) {
  DisparityProcessor disparity{DisparityNodeletParams()};
  disparity.begin(street().pair(index));
  return disparity.process({});
}

MovingObjectsInput withLargestDisparity(MovingObjectsInput input, float max_px) {
  for (auto* disparity : {&input.measured_disparity, &input.predicted_disparity}) {
    const auto changed = boost::make_shared<stereo_msgs::DisparityImage>(**disparity);
    changed->max_disparity = max_px;
    *disparity = changed;
  }
  return input;
}

TEST(MovingObjectsProcessor, a_range_that_is_refused_is_refused_each_time_and_changes_nothing) {
  MovingObjectsProcessor processor{MovingObjectsNodeletParams()};
  ASSERT_TRUE(processor.process(inputAt(0), {}).objects);
  const MovingObjectsInput next = inputAt(1), refused = withLargestDisparity(next, 299);
  EXPECT_THROW(processor.process(refused, {}), std::invalid_argument);
  EXPECT_THROW(processor.process(refused, {}), std::invalid_argument);
  const MovingObjectsProcessor::Output output = processor.process(next, {});
  EXPECT_EQ(output.sequence.verdict, SequenceGuard::Verdict::kContinues);
  EXPECT_TRUE(output.objects);
}

}  // namespace
}  // namespace predictive_stereo
