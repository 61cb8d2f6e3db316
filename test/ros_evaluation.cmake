# Tests that need ROS and synthetic cameras.

# Tools, run like a user on bags of streets.
foreach(name street_to_bag replay evaluate_detection evaluate_odometry)
  predictive_stereo_unit_test(tools ${name}_test
    predictive_stereo_bag_tools predictive_stereo_simulation)
  set(target predictive_stereo_tools_${name}_test)
  add_dependencies(${target}
    predictive_stereo_evaluate_detection predictive_stereo_evaluate_odometry
    predictive_stereo_replay predictive_stereo_street_to_bag
  )
  target_compile_definitions(${target} PRIVATE
    EVALUATE_DETECTION="$<TARGET_FILE:predictive_stereo_evaluate_detection>"
    EVALUATE_ODOMETRY="$<TARGET_FILE:predictive_stereo_evaluate_odometry>"
    REPLAY="$<TARGET_FILE:predictive_stereo_replay>"
    STREET_TO_BAG="$<TARGET_FILE:predictive_stereo_street_to_bag>"
  )
endforeach()

predictive_stereo_unit_test(tools pipeline_processor_test
  predictive_stereo_ros predictive_stereo_simulation
)
predictive_stereo_unit_test(nodelets moving_objects_processor_test
  predictive_stereo_ros predictive_stereo_simulation
)

# Nodelets; each .test file starts the nodelets under test.
find_package(rostest REQUIRED)
# Further arguments are add_rostest's.
function(predictive_stereo_rostest name launch_file source)
  set(target predictive_stereo_${name})
  add_executable(${target} EXCLUDE_FROM_ALL ${source})
  add_dependencies(tests ${target})
  add_rostest(${launch_file} DEPENDENCIES ${target} ${ARGN})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name})
  target_sources(${target} PRIVATE ${predictive_stereo_thread_backend})
  target_include_directories(${target} PRIVATE
    ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/nodelets
  )
  target_link_libraries(${target} predictive_stereo_bag_tools predictive_stereo_evaluation gtest)
  add_dependencies(${target} predictive_stereo_nodelets)
endfunction()
predictive_stereo_rostest(all_outputs_test
  nodelets/all_outputs_nodelets.test nodelets/all_outputs_test.cpp
)
predictive_stereo_rostest(diagnosis_test nodelets/diagnosis.test nodelets/diagnosis_test.cpp)
predictive_stereo_rostest(scenarios_test nodelets/scenarios.test nodelets/scenarios_test.cpp)
predictive_stereo_rostest(foreign_odometry_test
  nodelets/foreign_odometry.test nodelets/foreign_odometry_test.cpp)
predictive_stereo_rostest(ego_motion_scenarios_test
  nodelets/ego_motion_scenarios.test nodelets/ego_motion_scenarios_test.cpp
)
if(SANITIZE)  # there is time, and no manager with a sanitizer
  set(live_faults_args ARGS loads:=200 manager:=false)
endif()
predictive_stereo_rostest(live_faults_test
  nodelets/live_faults.test nodelets/live_faults_test.cpp ${live_faults_args}
)
add_rostest(nodelets/live_faults_no_clock.test DEPENDENCIES predictive_stereo_live_faults_test)
predictive_stereo_rostest(hostile_messages_test
  nodelets/hostile_messages.test nodelets/hostile_messages_test.cpp
)
target_link_libraries(predictive_stereo_hostile_messages_test predictive_stereo_nodelets)
predictive_stereo_rostest(neighbours_test nodelets/neighbours.test nodelets/neighbours_test.cpp)
target_link_libraries(predictive_stereo_neighbours_test ${CMAKE_DL_LIBS})
predictive_stereo_rostest(on_demand_test nodelets/on_demand.test nodelets/on_demand_test.cpp)
predictive_stereo_rostest(rectify_test nodelets/rectify.test nodelets/rectify_test.cpp)
predictive_stereo_rostest(stereo_input_test
  nodelets/stereo_input.test nodelets/stereo_input_test.cpp
)
target_link_libraries(predictive_stereo_stereo_input_test predictive_stereo_nodelets)
predictive_stereo_rostest(two_cameras_test
  nodelets/two_cameras.test nodelets/two_cameras_test.cpp
)
predictive_stereo_rostest(live_params_test nodelets/live_params.test nodelets/live_params_test.cpp)
add_rostest(nodelets/all_outputs_nodes.test DEPENDENCIES
  predictive_stereo_all_outputs_test predictive_stereo_disparity_node
  predictive_stereo_ego_motion_node predictive_stereo_moving_objects_node
)
add_custom_target(predictive_stereo_nodelet_tests)
foreach(name diagnosis ego_motion_scenarios foreign_odometry hostile_messages live_faults live_params
    scenarios stereo_input)
  add_dependencies(predictive_stereo_nodelet_tests predictive_stereo_${name}_test)
endforeach()
# Load: what is lost is counted, and memory does not grow.
predictive_stereo_rostest(live_load_test nodelets/live_load.test nodelets/live_load_test.cpp)
target_compile_definitions(predictive_stereo_live_load_test PRIVATE
  STREET_TO_BAG="$<TARGET_FILE:predictive_stereo_street_to_bag>"
)
add_dependencies(predictive_stereo_live_load_test predictive_stereo_street_to_bag)

# Bags, with nodelets in one manager and as separate nodes.
add_executable(predictive_stereo_bag_test EXCLUDE_FROM_ALL nodelets/bag_test.cpp)
set_target_properties(predictive_stereo_bag_test PROPERTIES OUTPUT_NAME bag_test)
target_compile_definitions(predictive_stereo_bag_test PRIVATE
  KITTI_TO_BAG="$<TARGET_FILE:predictive_stereo_kitti_to_bag>"
  REPLAY="$<TARGET_FILE:predictive_stereo_replay>"
  STREET_TO_BAG="$<TARGET_FILE:predictive_stereo_street_to_bag>"
)
target_include_directories(predictive_stereo_bag_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(predictive_stereo_bag_test predictive_stereo_bag_sequences gtest)
add_dependencies(predictive_stereo_bag_test
  predictive_stereo_kitti_to_bag predictive_stereo_nodelets predictive_stereo_replay
  predictive_stereo_street_to_bag
)
add_dependencies(tests predictive_stereo_bag_test)
foreach(source street kitti_0009)
  foreach(standalone false true)
    add_rostest(nodelets/bag.test ARGS source:=${source} standalone:=${standalone}
      DEPENDENCIES predictive_stereo_bag_test)
  endforeach()
endforeach()
add_rostest(nodelets/bag.test ARGS source:=kitti_0002 DEPENDENCIES predictive_stereo_bag_test)
add_rostest(nodelets/bag.test ARGS source:=kitti_0020 DEPENDENCIES predictive_stereo_bag_test)

# Scripts that are tests; only ctest runs them.
add_test(NAME rviz
  COMMAND ${CATKIN_ENV} ${CMAKE_CURRENT_SOURCE_DIR}/tooling/rviz_test.py
    ${PROJECT_SOURCE_DIR} ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}
)
set_tests_properties(rviz PROPERTIES RUN_SERIAL TRUE SKIP_RETURN_CODE 77)
add_test(NAME docs
  COMMAND ${CATKIN_ENV} ${CMAKE_CURRENT_SOURCE_DIR}/tooling/docs_test.py
    ${PROJECT_SOURCE_DIR} ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}
)
add_test(NAME prepare_data
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/tooling/prepare_data_test.py ${PROJECT_SOURCE_DIR}
)
add_test(NAME benchmark
  COMMAND ${CATKIN_ENV} ${CMAKE_CURRENT_SOURCE_DIR}/tooling/benchmark_test.py
    ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR}
)
add_test(NAME report
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/tooling/report_test.py ${PROJECT_SOURCE_DIR}
)
add_test(NAME leave_one_out
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/tooling/leave_one_out_test.py ${PROJECT_SOURCE_DIR}
)
# Exit status 77, skipped: no permission to mount a small disk.
add_test(NAME hostile_files
  COMMAND ${CATKIN_ENV} ${CMAKE_CURRENT_SOURCE_DIR}/tooling/hostile_files_test.py
    ${PROJECT_SOURCE_DIR} ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}
)
add_test(NAME hostile_sizes
  COMMAND ${CATKIN_ENV} ${CMAKE_CURRENT_SOURCE_DIR}/tooling/hostile_sizes_test.py
    ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}
)
# Exit status 77, skipped: no Snakemake, which is not a dependency because it needs 680 MB.
add_test(NAME evaluate_many
  COMMAND ${CATKIN_ENV} ${CMAKE_CURRENT_SOURCE_DIR}/tooling/evaluate_many_test.py
    ${PROJECT_SOURCE_DIR} ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}
)
set_tests_properties(evaluate_many hostile_files PROPERTIES SKIP_RETURN_CODE 77)
