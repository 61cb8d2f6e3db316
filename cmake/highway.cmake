# Target hwy::hwy, Google's Highway: the installed one if its version is at least 1.0. Otherwise a pinned
# release is downloaded and linked into libpredictive_stereo. Ubuntu 20.04 has no Highway, 22.04 has 0.16.
# Without a network: -DFETCHCONTENT_SOURCE_DIR_HIGHWAY=<folder of the unpacked release>.
find_package(hwy 1.0 QUIET)
if(hwy_FOUND)
  message(STATUS "Highway: uses the installed version ${hwy_VERSION}")
  return()
endif()

if(POLICY CMP0135)
  cmake_policy(SET CMP0135 NEW)  # extracted files get the time of extraction
endif()
include(FetchContent)
FetchContent_Declare(highway
  URL https://github.com/google/highway/archive/refs/tags/1.2.0.tar.gz
  URL_HASH SHA256=7e0be78b8318e8bdbf6fa545d2ecb4c90f947df03f7aadc42c1967f019e63343
)
foreach(part CONTRIB EXAMPLES TESTS)
  set(HWY_ENABLE_${part} OFF CACHE BOOL "" FORCE)
endforeach()
# Debian's 1.0.3 exports what it installs, also if it installs nothing, which is an error. So its rules
# stay. EXCLUDE_FROM_ALL below keeps them out of our installation.
set(HWY_ENABLE_INSTALL ON CACHE BOOL "" FORCE)
set(HWY_FORCE_STATIC_LIBS ON CACHE BOOL "" FORCE)
message(STATUS "Highway: no version from 1.0 on is installed; downloads 1.2.0. Without a network use "
  "-DFETCHCONTENT_SOURCE_DIR_HIGHWAY=<folder of the unpacked release>")
FetchContent_MakeAvailable(highway)
set_property(DIRECTORY ${highway_SOURCE_DIR} PROPERTY EXCLUDE_FROM_ALL TRUE)

# Highway stores the selected SIMD target in a variable. It must be visible outside
# libpredictive_stereo, so that tests can select the target of the library.
set_target_properties(hwy PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_compile_options(hwy PRIVATE -w -fvisibility=default)
# Suppress warnings of its headers.
get_target_property(includes hwy INTERFACE_INCLUDE_DIRECTORIES)
set_target_properties(hwy PROPERTIES INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${includes}")
add_library(hwy::hwy ALIAS hwy)
