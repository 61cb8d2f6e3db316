/// Converts a drive of KITTI's raw recordings to a bag in kitti2bag's layout.
#include <cstdio>

#include "tools/command_line.h"
#include "tools/interruption.h"
#include "tools/kitti_bag.h"
#include "tools/progress.h"

namespace predictive_stereo {
namespace {

constexpr char kHelp[] = R"(Usage: kitti_to_bag DATE_DIR DRIVE OUT.bag [--cameras gray|color]

Converts a rectified ("sync") drive of KITTI's raw recordings to a bag in the layout of kitti2bag's
raw_synced bags. Needs no ROS master. An existing OUT.bag is replaced.

  DATE_DIR            a day's folder with calib_cam_to_cam.txt, e.g. 2011_09_26
  DRIVE               a drive's folder in it, e.g. 2011_09_26_drive_0009_sync
  --cameras           the pair to convert (default: gray)

Topics: /kitti/camera_gray_left/{image_raw,camera_info} and the right one's (or camera_color_...),
/kitti/oxts/{imu,gps/fix,gps/vel}, /kitti/velo/pointcloud, /tf (world -> base_link), /tf_static.
The images are rectified, although they are named image_raw.
)";

int convert(const CommandLine& command_line) {
  const auto& arguments = command_line.positional();
  if (arguments.size() != 3) throw UsageError("expected DATE_DIR DRIVE OUT.bag");
  const std::string cameras = command_line.get("cameras", "gray");
  if (cameras != "gray" && cameras != "color")
    throw UsageError("--cameras = " + cameras + ": must be gray or color");

  catchInterruptions();
  const KittiDrive drive(arguments[0], arguments[1],
                         cameras == "gray" ? KittiCameras::kGray : KittiCameras::kColor);
  {
    Progress progress(drive.name(), drive.frames());
    writeKittiBag(drive, arguments[2], [&](int frame) {
      progress.update(frame);
      throwIfInterrupted();
    });
  }
  std::printf("%s: %d frames of %s\n", arguments[2].c_str(), drive.frames(), drive.name().c_str());
  return 0;
}

}  // namespace
}  // namespace predictive_stereo

int main(int argc, char** argv) {
  return predictive_stereo::runTool(argc, argv, predictive_stereo::kHelp, {"cameras"}, {},
                                    predictive_stereo::convert);
}
