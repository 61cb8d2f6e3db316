#pragma once

#include <rosbag/bag.h>

#include <memory>
#include <string>

namespace predictive_stereo {

/// Writes a bag to a temporary file beside `path`. finish() renames it to `path`; without finish()
/// the file is removed.
class BagFile {
 public:
  /// @param compress  by lz4.
  /// @throws std::runtime_error if the file cannot be made.
  explicit BagFile(const std::string& path, bool compress = false);
  ~BagFile();
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;

  /// See rosbag::Bag::write.
  /// @throws std::runtime_error if the disk is full, or if writing fails for another reason.
  template <class... Arguments>
  void write(const Arguments&... arguments) {
    try {
      bag_->write(arguments...);
    } catch (const rosbag::BagException& error) {
      fail(error.what());
    }
  }
  /// Closes the bag and renames it to `path`.
  /// @throws std::runtime_error  as write().
  void finish();

 private:
  void abandon();
  [[noreturn]] void fail(const std::string& reason) const;

  std::string path_, temporary_;
  std::unique_ptr<rosbag::Bag> bag_;
  bool finished_ = false;
};

}  // namespace predictive_stereo
