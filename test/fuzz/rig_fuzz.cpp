/// StereoRig::fromProjections: any two matrices and sizes.
#include <cmath>

#include "bytes.h"
#include "predictive_stereo/stereo_rig.h"

using namespace predictive_stereo;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Bytes bytes(data, size);
  const cv::Size image(bytes.raw<int32_t>(), bytes.raw<int32_t>());
  Matrix34d P[2];
  for (Matrix34d& matrix : P)
    for (int i = 0; i < 12; ++i) matrix(i / 4, i % 4) = bytes.number(i == 3 ? -300 : 500);
  mayRefuse([&] {
    const StereoRig rig = StereoRig::fromProjections(P[0], P[1], image);
    if (!(rig.fx_px > 0 && rig.fy_px > 0 && rig.baseline_m > 0 && !rig.size.empty()))
      finding("a rig that its own rules refuse");
    if (!std::isfinite(rig.baseline_m) || !std::isfinite(rig.disparityTimesDepth()))
      finding("a baseline that is not finite");
    if (rig != rig) finding("a rig that is not itself");
    rig.disparityFromPoint(rig.pointFromDisparity(1, 1, 1));
  });
  return 0;
}
