#pragma once

#include <rosbag/bag.h>

#include <string>

namespace predictive_stereo {

/// A bag in the making: written to a temporary file beside `path`, which takes its place when
/// everything was written. Where finish() is not reached nothing is left.
class BagFile {
 public:
  /// @throws std::runtime_error where the file cannot be made.
  explicit BagFile(const std::string& path);
  ~BagFile();
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  rosbag::Bag& bag() { return bag_; }
  /// Closes the bag and gives it its name.
  void finish();

 private:
  std::string path_, temporary_;
  rosbag::Bag bag_;
  bool finished_ = false;
};

}  // namespace predictive_stereo
