/// Label files: any text, and what is done with the labels.
#include "bytes.h"
#include "evaluation/detection_score.h"
#include "evaluation/object_labels.h"

using namespace predictive_stereo;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  mayRefuse([&] {
    const std::vector<ObjectLabel> labels = readObjectLabels(file.path());
    DetectionScore score;
    for (int frame = 0; frame < 3; ++frame) {
      movingMask(labels, frame, {64, 48}, 5);
      const auto some = labelsOf(labels, frame);
      DetectedObject object;
      object.box_px = some.empty() ? cv::Rect2d(1, 1, 9, 9) : some[0].box_px;
      score.add(some, {object});
    }
  });
  return 0;
}
