#pragma once

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "evaluation/kitti_fixture.h"

namespace predictive_stereo {

/// Runs tools as a user does, in a folder that vanishes.
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

/// All messages of one type by topic, in order.
template <class Message>
std::map<std::string, std::vector<typename Message::ConstPtr>> messagesIn(const std::string& path) {
  std::map<std::string, std::vector<typename Message::ConstPtr>> result;
  rosbag::Bag bag(path);
  for (const rosbag::MessageInstance& instance : rosbag::View(bag))
    if (const auto message = instance.instantiate<Message>())
      result[instance.getTopic()].push_back(message);
  return result;
}

}  // namespace predictive_stereo
