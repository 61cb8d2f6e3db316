/// KITTI's timestamps.txt: any text. All that is taken lies within the years that it can be of.
#include "bytes.h"
#include "tools/kitti_drive.h"

using namespace predictive_stereo;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  mayRefuse([&] {
    for (const int64_t stamp_ns : readKittiTimestamps(file.path(), 1000))
      if (stamp_ns < 0 || stamp_ns / 1000000000 > std::numeric_limits<uint32_t>::max())
        finding("a stamp that ROS cannot hold: " + std::to_string(stamp_ns) + " ns");
  });
  return 0;
}
