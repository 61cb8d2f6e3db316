# Targets with ROS: nodelets, nodes, tools for bags and topics.

# Message processing without nodes, used by the nodelets and by replay.
predictive_stereo_library(predictive_stereo_ros FILES
  src/nodelets/stereo_messages.cpp
  src/nodelets/transforms.cpp
  src/nodelets/views.cpp
)
add_dependencies(predictive_stereo_ros ${PROJECT_NAME}_generate_messages_cpp)
target_include_directories(predictive_stereo_ros SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
target_link_libraries(predictive_stereo_ros
  PUBLIC predictive_stereo opencv_calib3d opencv_imgcodecs ${catkin_LIBRARIES}
)

# The nodelets, and each of them as a separate node.
predictive_stereo_library(predictive_stereo_nodelets FILES
  src/nodelets/disparity_nodelet.cpp
  src/nodelets/ego_motion_nodelet.cpp
  src/nodelets/live_params.cpp
  src/nodelets/moving_objects_nodelet.cpp
  src/nodelets/rectify_nodelet.cpp
)
target_link_libraries(predictive_stereo_nodelets
  PRIVATE predictive_stereo_ros predictive_stereo_params)

function(predictive_stereo_node name nodelet)
  set(target predictive_stereo_${name})
  predictive_stereo_executable(${name} src/nodelets/standalone_node.cpp)
  target_compile_definitions(${target}
    PRIVATE NODE_NAME="${name}" NODELET_TYPE="${PROJECT_NAME}/${nodelet}")
  target_include_directories(${target} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
  target_link_libraries(${target} PRIVATE ${catkin_LIBRARIES})
  add_dependencies(${target} predictive_stereo_nodelets)
endfunction()
predictive_stereo_node(ego_motion_node EgoMotion)
predictive_stereo_node(disparity_node Disparity)
predictive_stereo_node(moving_objects_node MovingObjects)
predictive_stereo_node(rectify_node Rectify)

# Tools for bags and topics.
predictive_stereo_library(predictive_stereo_bag_tools FILES
  src/tools/bag_check.cpp
  src/tools/bag_file.cpp
  src/tools/bag_layouts.cpp
  src/tools/live_load.cpp
  src/tools/stamp_check.cpp
  src/tools/stereo_bag.cpp
  src/tools/tf_check.cpp
)
target_link_libraries(predictive_stereo_bag_tools
  PUBLIC predictive_stereo_ros predictive_stereo_tools
)
foreach(tool check_bag kitti_to_bag load_test replay)
  predictive_stereo_tool(${tool} src/tools/${tool}.cpp src/tools/main.cpp)
  target_link_libraries(predictive_stereo_${tool} predictive_stereo_bag_tools)
endforeach()
add_dependencies(predictive_stereo_load_test predictive_stereo_nodelets)

# Most of their compile time is headers and templates of ROS, which all files share.
set_target_properties(predictive_stereo_ros predictive_stereo_nodelets predictive_stereo_bag_tools
  PROPERTIES UNITY_BUILD ON)

install(FILES nodelets.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
install(DIRECTORY config launch DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
