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

function(predictive_stereo_evaluation_tool name)
  predictive_stereo_tool(${name} src/evaluation/tools/${name}.cpp)
  target_link_libraries(predictive_stereo_${name} predictive_stereo_evaluation ${ARGN})
endfunction()
foreach(tool estimate_noise evaluate_kitti evaluate_odometry)
  predictive_stereo_evaluation_tool(${tool})
endforeach()

if(PREDICTIVE_STEREO_ROS)
  # Bags as sequences.
  predictive_stereo_library(predictive_stereo_bag_sequences FILES
    src/evaluation/tools/bag_sequence.cpp
  )
  target_link_libraries(predictive_stereo_bag_sequences
    PUBLIC predictive_stereo_evaluation predictive_stereo_bag_tools
  )
  predictive_stereo_evaluation_tool(evaluate_detection predictive_stereo_bag_sequences)
  predictive_stereo_evaluation_tool(street_to_bag predictive_stereo_bag_tools)
endif()
