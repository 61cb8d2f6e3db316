# Functions that declare and install libraries and executables. Names of targets have the package's
# name as prefix, because all packages of a catkin workspace share one set of targets.
if(NOT PREDICTIVE_STEREO_ROS)
  include(GNUInstallDirs)
  set(predictive_stereo_lib ${CMAKE_INSTALL_LIBDIR})
  set(predictive_stereo_bin ${CMAKE_INSTALL_BINDIR})
  set(predictive_stereo_include ${CMAKE_INSTALL_INCLUDEDIR}/${PROJECT_NAME})
  # So installed programs find the libraries with any prefix.
  set(CMAKE_INSTALL_RPATH $ORIGIN $ORIGIN/../${CMAKE_INSTALL_LIBDIR})
else()
  set(predictive_stereo_lib ${CATKIN_PACKAGE_LIB_DESTINATION})
  set(predictive_stereo_bin ${CATKIN_PACKAGE_BIN_DESTINATION})
  set(predictive_stereo_include ${CATKIN_PACKAGE_INCLUDE_DESTINATION})
endif()

# With FOLDERS, every .cpp in these folders belongs to the library. CONFIGURE_DEPENDS finds new ones at
# each build.
# predictive_stereo_library(name FOLDERS folder... | FILES file... [INSTALL option...])
function(predictive_stereo_library name)
  cmake_parse_arguments(ARG "" "" "FOLDERS;FILES;INSTALL" ${ARGN})
  set(sources ${ARG_FILES})
  foreach(folder ${ARG_FOLDERS})
    file(GLOB found CONFIGURE_DEPENDS src/${folder}/*.cpp)
    list(APPEND sources ${found})
  endforeach()
  add_library(${name} SHARED ${sources})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>)
  install(TARGETS ${name} ${ARG_INSTALL} LIBRARY DESTINATION ${predictive_stereo_lib})
endfunction()

# The target is predictive_stereo_NAME, the executable is NAME.
function(predictive_stereo_executable name)
  set(target predictive_stereo_${name})
  add_executable(${target} ${ARGN})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name})
  install(TARGETS ${target} RUNTIME DESTINATION ${predictive_stereo_bin})
endfunction()

# An executable with the command line of src/tools/command_line.h. Its help is docs/help/NAME.txt, where
# @sequences@ and @parameters@ stand for the files of docs/help/common.
# predictive_stereo_tool(name source...)
function(predictive_stereo_tool name)
  foreach(file common/sequences common/parameters ${name})
    get_filename_component(part ${file} NAME)
    file(READ docs/help/${file}.txt text)
    string(REGEX REPLACE "\n$" "" ${part} "${text}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS docs/help/${file}.txt)
  endforeach()
  string(CONFIGURE "${${name}}" help @ONLY)
  configure_file(cmake/help.cpp.in ${name}_help.cpp @ONLY)
  predictive_stereo_executable(${name} ${ARGN} ${CMAKE_CURRENT_BINARY_DIR}/${name}_help.cpp
    ${predictive_stereo_thread_backend})
endfunction()
