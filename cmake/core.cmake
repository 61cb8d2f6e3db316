# Targets without ROS. The core: all stages of the paper's block diagram.
predictive_stereo_library(predictive_stereo
  FOLDERS pipeline geometry simd parallel imaging matching filtering odometry detection
  INSTALL EXPORT predictive_stereoTargets COMPONENT core
)
target_compile_features(predictive_stereo PUBLIC cxx_std_17)
target_include_directories(predictive_stereo PUBLIC
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>
)
target_link_libraries(predictive_stereo
  PUBLIC Eigen3::Eigen opencv_core opencv_imgproc
  PRIVATE hwy::hwy TBB::tbb
)
install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION ${predictive_stereo_include} COMPONENT core)
# So the compiler can vectorise loops with conditions; results do not change.
target_compile_options(predictive_stereo PRIVATE -fno-math-errno -fno-trapping-math)
# Most files include these.
target_precompile_headers(predictive_stereo PRIVATE <Eigen/Geometry> <opencv2/imgproc.hpp> <functional> <vector>)

# Reads and writes parameter structs as yaml and from command lines. It holds the annotated yaml, for
# the texts of dynamic_reconfigure.
predictive_stereo_library(predictive_stereo_params FOLDERS params)
file(READ config/predictive_stereo.yaml annotated_yaml)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS config/predictive_stereo.yaml)
configure_file(cmake/annotated_yaml.cpp.in annotated_yaml.cpp @ONLY)
target_sources(predictive_stereo_params PRIVATE ${PROJECT_BINARY_DIR}/annotated_yaml.cpp)
target_link_libraries(predictive_stereo_params PUBLIC predictive_stereo PRIVATE yaml-cpp)

# Common code of the tools; drives of KITTI's raw recordings.
predictive_stereo_library(predictive_stereo_tools FILES
  src/tools/command_line.cpp
  src/tools/kitti_drive.cpp
  src/tools/output_file.cpp
  src/tools/progress.cpp
)
target_link_libraries(predictive_stereo_tools PUBLIC predictive_stereo_params opencv_imgcodecs)
