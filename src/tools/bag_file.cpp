#include "tools/bag_file.h"

#include <unistd.h>

#include <filesystem>
#include <stdexcept>

namespace predictive_stereo {

BagFile::BagFile(const std::string& path)
    : path_(path), temporary_(path + ".part" + std::to_string(getpid())) {
  if (std::filesystem::is_directory(path))
    throw std::runtime_error(path + ": is a folder, not the name of a bag");
  try {
    bag_.open(temporary_, rosbag::bagmode::Write);
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": cannot be written; does its folder exist? (" + error.what() +
                             ")");
  }
}

BagFile::~BagFile() {
  if (finished_) return;
  try {
    bag_.close();
  } catch (const std::exception&) {  // the file goes anyway
  }
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void BagFile::finish() {
  bag_.close();
  std::filesystem::rename(temporary_, path_);
  finished_ = true;
}

}  // namespace predictive_stereo
