# Package config of the core for CMake without catkin: find_package(predictive_stereo) provides the
# target predictive_stereo::predictive_stereo. In a build with ROS, catkin_package() makes another
# package config, so this one is installed only on request: cmake --install build --component core.
include(CMakePackageConfigHelpers)
file(READ package.xml manifest)
string(REGEX MATCH "<version>([^<]+)</version>" manifest "${manifest}")
set(version ${CMAKE_MATCH_1})

set(destination ${predictive_stereo_lib}/cmake/${PROJECT_NAME})
set(made ${PROJECT_BINARY_DIR}/package_config)
configure_package_config_file(cmake/predictive_stereoConfig.cmake.in
  ${made}/predictive_stereoConfig.cmake INSTALL_DESTINATION ${destination}
)
write_basic_package_version_file(${made}/predictive_stereoConfigVersion.cmake
  VERSION ${version} COMPATIBILITY SameMinorVersion
)
if(PREDICTIVE_STEREO_ROS)
  set(only_asked_for EXCLUDE_FROM_ALL)
endif()
#catkin_lint: ignore_once missing_file
install(FILES ${made}/predictive_stereoConfig.cmake ${made}/predictive_stereoConfigVersion.cmake
  DESTINATION ${destination} COMPONENT core ${only_asked_for}
)
install(EXPORT predictive_stereoTargets NAMESPACE predictive_stereo::
  DESTINATION ${destination} COMPONENT core ${only_asked_for}
)
