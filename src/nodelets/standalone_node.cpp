/// Runs one nodelet as a separate node: NODELET_TYPE in a process named NODE_NAME.
#include <nodelet/loader.h>
#include <ros/ros.h>

#include <cstring>
#include <iostream>

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (std::strcmp(argv[i], "--help") == 0 || std::strcmp(argv[i], "-h") == 0) {
      std::cout << "Runs the nodelet " NODELET_TYPE
                   " as a node. Names and parameters are ROS arguments:\n"
                   "  rosrun predictive_stereo " NODE_NAME
                   " __ns:=/stereo _parameter:=value topic:=other_topic\n";
      return 0;
    }
  ros::init(argc, argv, NODE_NAME);
  nodelet::Loader loader(false);
  const nodelet::V_string arguments(argv + 1, argv + argc);
  if (!loader.load(ros::this_node::getName(), NODELET_TYPE, ros::names::getRemappings(), arguments))
    return 1;
  ros::spin();
  return 0;
}
