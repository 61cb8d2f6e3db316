#include "tools/bag_file.h"

#include <unistd.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace predictive_stereo {

BagFile::BagFile(const std::string& path, bool compress)
    : path_(path),
      temporary_(path + ".part" + std::to_string(getpid())),
      bag_(std::make_unique<rosbag::Bag>()) {
  std::error_code ignored;  // of a folder that may not be read
  if (std::filesystem::is_directory(path, ignored))
    throw std::runtime_error(path + ": is a folder; give the name of a file");
  try {
    bag_->open(temporary_, rosbag::bagmode::Write);
    if (compress) bag_->setCompression(rosbag::compression::LZ4);
  } catch (const rosbag::BagException& error) {
    const bool made = std::filesystem::exists(temporary_, ignored);
    abandon();
    if (made) fail(error.what());  // the file exists, but its first bytes could not be written
    throw std::runtime_error(path +
                             ": cannot be written; does the folder exist, and may you write "
                             "to it? (" +
                             error.what() + ")");
  }
}

BagFile::~BagFile() {
  if (!finished_) abandon();
}

void BagFile::abandon() {
  try {
    bag_->close();
  } catch (const std::exception&) {
    // The destructor must not run: it would write again, throw, and so terminate the process.
    static_cast<void>(bag_.release());
  }
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void BagFile::finish() {
  try {
    bag_->close();
  } catch (const rosbag::BagException& error) {
    fail(error.what());
  }
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) fail(error.message());
  finished_ = true;
}

// rosbag does not report a full disk, so the free space is checked.
void BagFile::fail(const std::string& reason) const {
  std::error_code error;
  const auto space = std::filesystem::space(std::filesystem::absolute(path_).parent_path(), error);
  constexpr std::uintmax_t kLittle_bytes = 1 << 20;
  const bool full = !error && space.available < kLittle_bytes;
  throw std::runtime_error(path_ + ": cannot be written: " + (full ? "the disk is full" : reason));
}

}  // namespace predictive_stereo
