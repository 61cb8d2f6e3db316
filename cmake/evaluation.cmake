# What proves the package: simulation, evaluation and their programs. A robot needs none of it.

# Synthetic sequences with exact ground truth.
predictive_stereo_library(predictive_stereo_simulation FOLDERS evaluation/simulation)
target_link_libraries(predictive_stereo_simulation PUBLIC predictive_stereo)

# Sequences with ground truth (KITTI, synthetic), metrics, and the programs' common command line.
predictive_stereo_library(predictive_stereo_evaluation
  FOLDERS evaluation
  FILES src/evaluation/tools/tool_input.cpp
)
target_link_libraries(predictive_stereo_evaluation
  PUBLIC predictive_stereo_simulation predictive_stereo_tools opencv_calib3d yaml-cpp
)

foreach(tool estimate_noise evaluate_kitti evaluate_odometry)
  predictive_stereo_tool(${tool} src/evaluation/tools/${tool}.cpp src/tools/main.cpp)
  target_link_libraries(predictive_stereo_${tool} predictive_stereo_evaluation)
endforeach()

if(PREDICTIVE_STEREO_ROS)
  # Bags as sequences.
  predictive_stereo_library(predictive_stereo_bag_sequences FILES
    src/evaluation/tools/bag_sequence.cpp
  )
  target_link_libraries(predictive_stereo_bag_sequences
    PUBLIC predictive_stereo_evaluation predictive_stereo_bag_tools
  )
  predictive_stereo_tool(evaluate_detection
    src/evaluation/tools/evaluate_detection.cpp src/tools/main.cpp)
  target_link_libraries(predictive_stereo_evaluate_detection predictive_stereo_bag_sequences)
  # Its help lists the scenes, so it has its own main().
  predictive_stereo_tool(street_to_bag src/evaluation/tools/street_to_bag.cpp)
  target_link_libraries(predictive_stereo_street_to_bag
    predictive_stereo_simulation predictive_stereo_bag_tools)
endif()
