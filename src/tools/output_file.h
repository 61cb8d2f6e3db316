#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace predictive_stereo {

/// Makes the folder, unless it exists.
/// @throws std::runtime_error with `path` and the reason, if it cannot be made.
void makeFolder(const std::filesystem::path& path);

/// Makes the folder of a file, unless `path` has none.
void makeFolderOf(const std::filesystem::path& path);

/// A text as a cell of CSV (RFC 4180): quoted if it has a comma, a quotation mark or a new line.
std::string csvCell(const std::string& text);

/// Writes a text file atomically: to a temporary file beside `path`, which is renamed when the
/// whole text is on the disk. Makes missing folders.
/// @throws std::runtime_error with `path` and the reason, if it cannot be written.
void writeText(const std::filesystem::path& path, const std::string& text);
/// The same for an image, in the format of the file's extension.
void writePicture(const std::filesystem::path& path, const cv::Mat& picture);

}  // namespace predictive_stereo
