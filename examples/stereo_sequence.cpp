// Runs the whole pipeline on a rectified stereo sequence, without ROS:
//   stereo_sequence left_%04d.png right_%04d.png FOCAL_PX CX_PX CY_PX BASELINE_M RATE_HZ
#include <predictive_stereo/pipeline.h>

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <opencv2/imgcodecs.hpp>

int main(int argc, char** argv) try {
  using namespace predictive_stereo;
  if (argc != 8) return std::fputs("arguments: see the first lines of the source\n", stderr), 2;
  Pipeline pipeline(PipelineParams{});
  PipelineOutput output;  // outside the loop, to reuse its buffers
  for (int i = 0;; ++i) {
    StereoFrame frame;
    frame.left = cv::imread(cv::format(argv[1], i), cv::IMREAD_GRAYSCALE);
    frame.right = cv::imread(cv::format(argv[2], i), cv::IMREAD_GRAYSCALE);
    if (frame.left.empty()) return i > 0 ? 0 : 1;
    frame.rig.size = frame.left.size();
    frame.rig.fx_px = frame.rig.fy_px = std::atof(argv[3]);
    frame.rig.cx_left_px = frame.rig.cx_right_px = std::atof(argv[4]);
    frame.rig.cy_px = std::atof(argv[5]);
    frame.rig.baseline_m = std::atof(argv[6]);
    frame.stamp = stampFromSeconds(i / std::atof(argv[7]));
    if (!pipeline.process(frame, output)) continue;  // a duplicate: the stamp of the previous frame

    const cv::Mat1f& disparity_px = output.disparity.disparity_px;
    const int known = cv::countNonZero(disparity_px >= 0);  // unknown: -1, variance 0
    const Eigen::Vector3d camera_m = output.pose.T_odom_cam.translation();
    std::printf("frame %d: disparity at %.1f %% of the pixels, camera at %.2f %.2f %.2f m\n", i,
                100.0 * known / disparity_px.total(), camera_m.x(), camera_m.y(), camera_m.z());
    for (const DetectedObject& object : output.detections.objects)
      std::printf("  object %d: %.1f m away, %.1f m/s\n", object.id, object.distance_m,
                  object.velocity_mps.norm());
  }
} catch (const std::exception& error) {  // e.g. the right image is missing
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
