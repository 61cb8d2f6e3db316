/// KITTI's calibration files: any text.
#include "bytes.h"
#include "tools/kitti_drive.h"

using namespace predictive_stereo;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const MemoryFile file(data, size);
  mayRefuse([&] {
    const KittiCalibrationFile calibration(file.path());
    mayRefuse([&] { calibration.rigidMotion(); });
    const KittiCamera left = kittiCamera(calibration, 0), right = kittiCamera(calibration, 1);
    StereoRig::fromProjections(left.P_rect, right.P_rect, {64, 32});
  });
  return 0;
}
