/// Filters that remove and fill single disparities of a map.
#pragma once

#include <opencv2/core.hpp>

#include "predictive_stereo/disparity_range.h"

namespace predictive_stereo {

/// Keeps a pixel if at least `min_support` of the 25 pixels of its 5x5 neighbourhood (the pixel
/// itself included; fewer at the image's border) are within 1 px of its disparity. All other pixels
/// become range.invalid(). Not in place.
/// @param min_support  0..25; at most 1: all valid pixels are kept.
/// @param filtered_px  output of the input's size.
/// @throws std::invalid_argument if input and output share memory.
void filterBySupport(const DisparityRange& range, int min_support, const cv::Mat1f& disparity_px,
                     cv::Mat1f& filtered_px);

/// Leaves out what this frame's match does not know well: a pixel becomes range.invalid() if it has
/// a measured disparity of an ambiguity above `most`. Not in place.
/// @param ambiguity  see Match.
/// @param most  0..1; 1: all pixels are kept.
/// @param certain_px  output of the inputs' size.
/// @throws std::invalid_argument if input and output share memory.
void leaveOutAmbiguous(const DisparityRange& range, const cv::Mat1f& measured_px,
                       const cv::Mat1b& ambiguity, double most, const cv::Mat1f& disparity_px,
                       cv::Mat1f& certain_px);

/// Fills holes: runs of at most `max_length` invalid pixels in a row, then in a column of what the
/// rows gave; 0: none. Not in place.
///
/// A hole is interpolated if both sides belong to one surface: if they agree within `tolerance_px`,
/// or one is where the mean of the slopes beside the hole leads to from the other. In a row whose
/// right side is nearer, a hole at most 4 px wider than the difference of the two disparities is an
/// occlusion, if this side is at least half as wide as the difference: the foreground hides the
/// hole from the right camera. It gets the disparity of its left side, the background.
/// @param filled_px  output of the input's size.
/// @throws std::invalid_argument if input and output share memory.
void fillHoles(const DisparityRange& range, int max_length, float tolerance_px,
               const cv::Mat1f& disparity_px, cv::Mat1f& filled_px);

/// The 3x3 median (section 2.3): a valid pixel gets the median of itself and its valid neighbours
/// (the lower one of an even number). An invalid pixel gets the median of its valid neighbours if
/// there are at least `fewest`, as the paper fills "possibly invalidated disparities"; otherwise it
/// is range.invalid(). Not in place.
/// @param fewest  5: most of the pixels; 3: also along the straight border of a hole.
/// @param filtered_px  output of the input's size.
/// @throws std::invalid_argument if input and output share memory.
void median3x3(const DisparityRange& range, int fewest, const cv::Mat1f& disparity_px,
               cv::Mat1f& filtered_px);

}  // namespace predictive_stereo
