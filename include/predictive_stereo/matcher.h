/// Semi-global matching with census costs, over the full or a reduced search space: the paper's
/// sections 2.1-2.3.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "predictive_stereo/disparity_range.h"
#include "predictive_stereo/params.h"

namespace predictive_stereo {

enum class CensusForm {
  k5x5,                 ///< 24 comparisons with the centre (the paper)
  kCentreSymmetric9x5,  ///< 22 comparisons of opposite pixels (the default)
  kMixed9x5,            ///< 12 of opposite pixels within 5x5, 12 of far pixels with the centre
};
enum class PathSet { kStraight4, kDiagonal4, kAll8 };

struct MatcherParams {
  DisparityRange range;
  CensusForm census = CensusForm::kCentreSymmetric9x5;
  PathSet paths = PathSet::kStraight4;
  int p1 = 10;                       ///< penalty of a disparity change by 1 (eq. 1)
  int p2 = 70;                       ///< penalty of a larger change, > p1 (eq. 1)
  int p2_edge = 24;                  ///< replaces p2 at grey edges (not at thin lines), if lower
  int edge_step = 12;                ///< grey levels of such an edge; 0: p2 is the same everywhere
  int left_right_tolerance_px = 2;   ///< larger left-right differences are invalid; -1: no check
  bool exact_ranges = false;         ///< search ranges are not widened; scalar code, very slow
  std::string simd_target = "auto";  ///< see chooseSimdTarget (simd_target.h)

  template <class Visitor>
  void visit(Visitor&& v) {
    v("range", range);
    v("census", census,
      Choices<CensusForm>{{"5x5", CensusForm::k5x5},
                          {"centre_symmetric_9x5", CensusForm::kCentreSymmetric9x5},
                          {"mixed_9x5", CensusForm::kMixed9x5}});
    v("paths", paths,
      Choices<PathSet>{{"straight_4", PathSet::kStraight4},
                       {"diagonal_4", PathSet::kDiagonal4},
                       {"all_8", PathSet::kAll8}});
    v("p1", p1, 1, 200);
    v("p2", p2, 2, 220);
    v("p2_edge", p2_edge, 1, 220);
    v("edge_step", edge_step, 0, 255);
    v("left_right_tolerance_px", left_right_tolerance_px, -1, 256);
    v("exact_ranges", exact_ranges);
    v("simd_target", simd_target);
  }
};

/// @throws std::invalid_argument if a parameter is outside its limits, range.count is not a
///   multiple of 16, or p2 <= p1.
void validateMatcher(const MatcherParams& params);

/// Per pixel of the left image, the disparities to search: first, ..., last [px], both included.
/// last < first: this pixel is not searched and gets no disparity.
struct SearchRanges {
  cv::Mat1s first;
  cv::Mat1s last;
};

/// Result of matching, for each pixel of the left image.
struct Match {
  cv::Mat1f disparity_px;  ///< sub-pixel; range.invalid() where nothing was found
  /// 255 * lowest aggregated cost / second lowest one, which must not be at a neighbouring
  /// disparity: 0 is certain, 255 is a tie. Of all that a matcher observes, this predicts its
  /// errors best. 255 where there is no disparity or no second one, and where left and right
  /// differ by more than 1 px (unless the left-right check is off).
  cv::Mat1b ambiguity;
  /// Number of disparities that were searched: `count` after a full search, 0: not searched.
  cv::Mat1w search_width;
};

/// Matches stereo pairs. Keeps its buffers between calls: pairs of equal size allocate nothing.
///
/// Disparities are x_left - x_right - principal_offset_px, where principal_offset_px is
/// StereoRig::principalOffset(). Its whole pixels choose the columns of the right image, its
/// fraction is subtracted from the result: no image is moved, and the range is that of disparities.
/// With a fraction the nearest pixel of the range is not searched completely. If the offset leaves
/// no pixel a partner in the right image, or is not finite, nothing is searched and all disparities
/// are unknown.
class StereoMatcher {
 public:
  /// @throws std::invalid_argument as validateMatcher does, or if this CPU cannot run simd_target.
  explicit StereoMatcher(const MatcherParams& params);
  ~StereoMatcher();
  StereoMatcher(StereoMatcher&&) noexcept;
  StereoMatcher& operator=(StereoMatcher&&) noexcept;

  const MatcherParams& params() const;

  /// Name of the SIMD target in use, for logs and diagnostics; see simd_target.h.
  const std::string& simdTarget() const;

  /// Full search: every disparity of the range for every pixel (sections 2.1-2.3).
  /// @param left, right  rectified 8-bit grey images of one size, also views into larger images.
  /// @param match  output of the images' size; buffers of that size are reused.
  /// @throws std::invalid_argument if the images are empty or differ in size.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, Match& match,
             double principal_offset_px = 0);

  /// Reduced search: only `ranges` (section 2.2). They are cut to `range`, and widened to the
  /// windows that the kernels use, unless params().exact_ranges. Ranges that all cover the whole
  /// range give the result of the full search, bit for bit.
  /// @param ranges  maps of the images' size.
  /// @throws std::invalid_argument if the images are empty, or images or ranges differ in size.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges& ranges,
             Match& match, double principal_offset_px = 0);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace predictive_stereo
