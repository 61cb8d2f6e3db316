#include "tools/output_file.h"

#include <unistd.h>

#include <boost/algorithm/string/replace.hpp>
#include <cerrno>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& reason) {
  throw std::runtime_error(path.string() + ": cannot be written: " + reason);
}

void writeBytes(const fs::path& path, const char* data, size_t size) {
  const fs::path temporary = path.string() + ".part" + std::to_string(getpid());
  makeFolderOf(path);
  errno = 0;
  std::ofstream file(temporary, std::ios::binary);
  file.write(data, static_cast<std::streamsize>(size));
  file.close();
  std::error_code error(file ? 0 : errno ? errno : EIO, std::generic_category());
  if (!error) fs::rename(temporary, path, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(temporary, ignored);
  fail(path, error.message());
}

}  // namespace

void makeFolder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) fail(path, error.message());
}

void makeFolderOf(const fs::path& path) {
  if (path.has_parent_path()) makeFolder(path.parent_path());
}

std::string csvCell(const std::string& text) {
  return text.find_first_of(",\"\n") == std::string::npos
             ? text
             : "\"" + boost::algorithm::replace_all_copy(text, "\"", "\"\"") + "\"";
}

void writeText(const fs::path& path, const std::string& text) {
  writeBytes(path, text.data(), text.size());
}

void writePicture(const fs::path& path, const cv::Mat& picture) {
  std::vector<uchar> bytes;
  if (!cv::imencode(path.extension().string(), picture, bytes))
    throw std::runtime_error(path.string() + ": the picture cannot be encoded");
  writeBytes(path, reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

}  // namespace predictive_stereo
