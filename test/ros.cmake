# Tests that need ROS.

# Parameters and the installed parameter files.
predictive_stereo_unit_tests(params predictive_stereo_ros predictive_stereo_params yaml-cpp)
target_compile_definitions(predictive_stereo_params_config_files_test
  PRIVATE CONFIG_FOLDER="${PROJECT_SOURCE_DIR}/config"
)

# Tools.
foreach(name check_bag kitti_to_bag)
  predictive_stereo_unit_test(tools ${name}_test predictive_stereo_bag_tools)
endforeach()
add_dependencies(predictive_stereo_tools_kitti_to_bag_test predictive_stereo_kitti_to_bag)
target_compile_definitions(predictive_stereo_tools_kitti_to_bag_test
  PRIVATE KITTI_TO_BAG="$<TARGET_FILE:predictive_stereo_kitti_to_bag>"
)

# Message processing, and parts of the nodelets.
foreach(name camera_motion disparity_views message_checks message_pool moving_objects_views
    stamp_matcher stereo_messages threads transforms)
  predictive_stereo_unit_test(nodelets ${name}_test predictive_stereo_ros)
endforeach()
foreach(name imu_rotation tf_history tf_output)
  predictive_stereo_unit_test(nodelets ${name}_test predictive_stereo_nodelets predictive_stereo_ros)
endforeach()

# Scripts that are tests; only ctest runs them.
add_test(NAME launch_files
  COMMAND ${CATKIN_ENV} ${CMAKE_CURRENT_SOURCE_DIR}/tooling/launch_files_test.py
    ${PROJECT_SOURCE_DIR} ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}
)
add_test(NAME troubleshooting
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/tooling/troubleshooting_test.py ${PROJECT_SOURCE_DIR}
)
# Reasons of the ignored warnings: scripts run from the repository, and benchmarks from the build
# folder; Debian's headers are system headers; a checkout may have any name; names of targets are
# written in full, so that a search finds them; options have the package's name in capitals, or are for
# the whole workspace; FetchContent's commands are written as in CMake's documentation.
add_test(NAME catkin_lint
  COMMAND /usr/bin/catkin_lint -q -W2 --strict --ignore uninstalled_script
    --ignore uninstalled_target --ignore external_interface_path --ignore package_path_name
    --ignore literal_project_name --ignore global_var_collision --ignore cmd_case
    ${PROJECT_SOURCE_DIR}
)
