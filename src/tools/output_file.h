#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace predictive_stereo {

/// Makes the folder, where it is not there yet.
/// @throws std::runtime_error that names `path` and says why it cannot be made.
void makeFolder(const std::filesystem::path& path);

/// Writes the text to a temporary file beside `path`, which takes its place when all of it is on
/// the disk: there is the whole text, or the file of before. Folders are made.
/// @throws std::runtime_error that names `path` and says why it cannot be written.
void writeText(const std::filesystem::path& path, const std::string& text);
/// The same with a picture, in the format of the name's extension.
void writePicture(const std::filesystem::path& path, const cv::Mat& picture);

}  // namespace predictive_stereo
