#pragma once

#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

namespace predictive_stereo {

/// Creates an output of the input's size.
/// @param name  of the function, for the message.
/// @throws std::invalid_argument if the two share memory.
inline void createApart(const std::string& name, const cv::Mat1f& input, cv::Mat1f& output) {
  output.create(input.size());
  if (!input.empty() && output.datastart < input.dataend && input.datastart < output.dataend)
    throw std::invalid_argument(name +
                                ": input and output share memory; give another cv::Mat as output");
}

}  // namespace predictive_stereo
