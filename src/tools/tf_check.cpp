#include "tools/tf_check.h"

#include <algorithm>
#include <boost/algorithm/string/join.hpp>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "nodelets/nodelet_params.h"
#include "tools/stereo_bag.h"

namespace predictive_stereo {
namespace {

// Adds launch arguments, and returns them as a text.
std::string give(const std::vector<std::string>& arguments, BagCheck& result) {
  result.arguments.insert(result.arguments.end(), arguments.begin(), arguments.end());
  return "give " + boost::algorithm::join(arguments, " ");
}

void useMotion(const std::string& moved, const std::string& parent, const std::string& odometries,
               BagCheck& result) {
  std::vector<std::string> arguments{"ego_motion:=false", "odom_frame:=" + parent};
  const bool is_one = !odometries.empty() && odometries.find(',') == std::string::npos;
  if (is_one) arguments.push_back("odometry:=" + odometries);
  result.advice("the bag's own tf moves " + moved + " in " + parent + ": " +
                give(arguments, result) + " to use this motion" +
                (is_one || odometries.empty()
                     ? ""
                     : ", and odometry:= the topic with its covariance, of " + odometries));
}

// A frame waits for tf no longer than transform_timeout.
void checkDelays(double begin_s, double late_s, BagCheck& result) {
  const double timeout_s = FrameNodeletParams().transform_timeout;
  if (begin_s > timeout_s)
    result.advice(
        cv::format("this motion begins %.2f s after the images: the frames before are "
                   "matched without prediction",
                   begin_s));
  if (late_s > timeout_s)
    result.advice(
        cv::format("this motion was recorded %.2f s or more after the images of its stamps: "
                   "raise transform_timeout of disparity and moving_objects above that",
                   late_s));
}

// Chooses the frame that the ego-motion moves, where tf has no motion of the camera.
// @param root  above the base, or above the camera if there is no path between them.
void chooseBase(const std::string& frame, const std::string& base, const std::string& root,
                bool has_path, BagCheck& result) {
  const std::string no_path = "tf has no path from " + base + " to " + frame;
  if (!has_path && root == frame) {
    result.arguments.push_back("camera_is_base:=true");
    result.advice(no_path +
                  ": give camera_is_base:=true, which makes the left camera the base, or "
                  "base_frame:=");
  } else if (root != base) {
    std::vector<std::string> arguments{"base_frame:=" + root};
    if (root == FrameNodeletParams().odom_frame)  // a frame does not move in itself
      arguments.push_back(std::string("odom_frame:=") + kOtherOdomFrame);
    const std::string cure = ": " + give(arguments, result);
    result.advice(has_path ? "tf has " + base + " fixed to " + root + cure +
                                 ", as a frame has one parent only"
                           : no_path + cure + ", the frame that the camera is fixed to");
  }
}

}  // namespace

void TfCheck::add(const geometry_msgs::TransformStamped& transform, bool is_static,
                  ros::Time recorded) {
  tf_.setTransform(transform, "bag", is_static);
  const std::string parent = withoutSlash(transform.header.frame_id);
  if (is_static) return fixed_.add(transform.child_frame_id, parent);
  MovingFrame& moving = moving_[withoutSlash(transform.child_frame_id)];
  if (moving.parent.empty()) moving.first = transform.header.stamp;
  moving.parent = parent;
  moving.least_delay_s =
      std::min(moving.least_delay_s, secondsBetween(transform.header.stamp, recorded));
}

void TfCheck::check(const std_msgs::Header& left, double image_delay_s,
                    const std::string& odometries, BagCheck& result) const {
  const std::string frame = withoutSlash(left.frame_id);
  const std::string base = EgoMotionNodeletParams().base_frame;
  const bool has_path = tf_.canTransform(base, frame, ros::Time(0));
  if (has_path) result.good("tf: has the transform from " + base + " to " + frame);
  const std::string root = fixed_.rootOf(has_path ? base : frame);
  const std::string mounted_on = has_path ? base : root;
  std::string error;
  if (const auto mount = lookUpTransform(tf_, mounted_on, frame, ros::Time(0), error))
    if (const std::string doubt = doubtAboutMount(*mount, mounted_on, frame); !doubt.empty())
      result.advice(doubt);
  const auto motion = moving_.find(root);
  if (motion == moving_.end()) return chooseBase(frame, base, root, has_path, result);
  const MovingFrame& moving = motion->second;
  useMotion(root, moving.parent, odometries, result);
  checkDelays(secondsBetween(left.stamp, moving.first), moving.least_delay_s - image_delay_s,
              result);
}

}  // namespace predictive_stereo
