/// Semi-global matching with census costs: the paper's section 2.1-2.3, full and reduced.
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
  kCentreSymmetric9x7,  ///< 31 comparisons of opposite pixels
};
enum class PathSet { kStraight4, kDiagonal4, kAll8 };

struct MatcherParams {
  DisparityRange range;
  CensusForm census = CensusForm::kCentreSymmetric9x5;
  PathSet paths = PathSet::kStraight4;
  int p1 = 10;                       ///< penalty of a disparity change by 1 (eq. 1)
  int p2 = 70;                       ///< penalty of a larger change, > p1 (eq. 1)
  int p2_edge = 24;                  ///< instead of p2 across a lasting step of grey, if lower
  int edge_step = 12;                ///< grey levels of such a step; 0: p2 is the same everywhere
  int left_right_tolerance_px = 2;   ///< larger left-right differences are invalid; -1: no check
  bool exact_ranges = false;         ///< search ranges are not widened; scalar code, very slow
  std::string simd_target = "auto";  ///< see chooseSimdTarget (simd_target.h)

  template <class Visitor>
  void visit(Visitor&& v) {
    v("range", range);
    v("census", census,
      Choices<CensusForm>{{"5x5", CensusForm::k5x5},
                          {"centre_symmetric_9x5", CensusForm::kCentreSymmetric9x5},
                          {"centre_symmetric_9x7", CensusForm::kCentreSymmetric9x7}});
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

/// Per pixel, the disparities to search: first, ..., last [px], both included.
/// last < first: this pixel is not searched and gets no disparity.
struct SearchRanges {
  cv::Mat1s first;
  cv::Mat1s last;
};

/// Result of matching, for each pixel of the left image.
struct Match {
  cv::Mat1f disparity_px;  ///< sub-pixel; range.invalid() where nothing was found
  /// 255 * lowest aggregated cost / lowest one that is not next to it: 0 is certain, 255 is a tie.
  /// The best observable of error that a matcher has. 255 where there is no second.
  cv::Mat1b ambiguity;
  /// Disparities that were searched: `count` after a full search, 0: not searched.
  cv::Mat1w search_width;
};

/// Matches pairs; keeps its buffers between calls, so that equal sizes allocate nothing.
class StereoMatcher {
 public:
  /// @throws std::invalid_argument for parameters outside their limits, a count that is no multiple
  ///   of 16, p2 <= p1, or a simd_target that this CPU cannot run.
  explicit StereoMatcher(const MatcherParams& params);
  ~StereoMatcher();
  StereoMatcher(StereoMatcher&&) noexcept;
  StereoMatcher& operator=(StereoMatcher&&) noexcept;

  const MatcherParams& params() const;

  /// The SIMD target in use, by name: for logs and diagnostics.
  const std::string& simdTarget() const;

  /// Searches every disparity of the range for every pixel.
  /// @param left, right  rectified 8-bit grey images of one size, also views into larger images.
  /// @throws std::invalid_argument for empty images or different sizes.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, Match& match);

  /// Searches only `ranges`. Where these cover the whole range the result is that of the full
  /// search, bit for bit. Ranges are cut to `range`, and widened to the windows the kernels use;
  /// where params().exact_ranges they are not widened.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges& ranges,
             Match& match);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace predictive_stereo
