#pragma once

#include <rosbag/bag.h>

#include <memory>
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

  void setCompression(rosbag::compression::CompressionType type) { bag_->setCompression(type); }
  /// As rosbag::Bag::write.
  /// @throws std::runtime_error where the disk is full, or does not take it for another reason.
  template <class... Arguments>
  void write(const Arguments&... arguments) {
    try {
      bag_->write(arguments...);
    } catch (const rosbag::BagIOException& error) {
      fail(error.what());
    }
  }
  /// Closes the bag and gives it its name.
  /// @throws as write().
  void finish();

 private:
  void abandon();
  [[noreturn]] void fail(const std::string& reason) const;

  std::string path_, temporary_;
  std::unique_ptr<rosbag::Bag> bag_;
  bool finished_ = false;
};

}  // namespace predictive_stereo
