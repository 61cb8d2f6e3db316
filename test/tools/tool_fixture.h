#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tools/kitti_fixture.h"

namespace predictive_stereo {

/// Runs tools like a user, in a folder that is removed afterwards.
class ToolTest : public testing::Test {
 protected:
  struct Result {
    int status;
    std::string out, errors;
  };

  Result run(const std::string& command) const {
    const int status = std::system(
        (command + " > " + files_.path("stdout") + " 2> " + files_.path("stderr")).c_str());
    return {WEXITSTATUS(status), text("stdout"), text("stderr")};
  }
  std::string text(const std::string& name) const {
    std::ifstream file(files_.path(name));
    std::ostringstream content;
    content << file.rdbuf();
    return content.str();
  }

  TemporaryDirectory files_;
};

}  // namespace predictive_stereo
