#include "predictive_stereo/matcher.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "imaging/size_check.h"
#include "matching/census.h"
#include "matching/jump_floors.h"
#include "matching/principal_offset.h"
#include "matching/reference_sgm.h"
#include "matching/search.h"
#include "matching/search_windows.h"
#include "predictive_stereo/simd_target.h"
#include "simd/simd_dispatch.h"

namespace predictive_stereo {

void validateMatcher(const MatcherParams& params) {
  validate(params);
  std::ostringstream text;
  if (params.range.count % 16 != 0)
    text << "range/count = " << params.range.count << ": must be a multiple of 16";
  else if (params.p2 <= params.p1)
    text << "p2 = " << params.p2 << ": must be larger than p1 = " << params.p1;
  if (!text.str().empty()) throw std::invalid_argument(text.str());
}

struct StereoMatcher::Workspace {
  explicit Workspace(const MatcherParams& matcher_params)
      : params(matcher_params),
        simd_target(chooseSimdTarget(matcher_params.simd_target)),
        target_bit(simdTargetBit(simd_target)),
        census(params.census, target_bit),
        full_search(params, target_bit),
        reduced_search(params, target_bit) {}

  // @param ranges  nullptr: full search.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges* ranges,
             double principal_offset_px, Match& match) {
    if (left.empty()) throw std::invalid_argument("the left image is empty: nothing to match");
    requireSize("the right image", right.size(), left.size(), "but the left one is");
    prepare(left.size(), match);
    if (!leavesPartners(params.range, principal_offset_px, left.cols)) return matchNothing(match);
    const PrincipalOffset offset(principal_offset_px);
    const bool is_full = !ranges || coverEverything(*ranges, offset, left.size());
    if (target_bit == kScalarTarget || (params.exact_ranges && !is_full)) {
      if (is_full) planFullSearch(params.range, left.size(), windows);
      matchReference(left, right, params, offset, windows, match);
    } else {
      census.transform(left, left_words);
      census.transform(right, right_words);
      floors.build(left, params);
      if (is_full)
        full_search.match(left_words, right_words, offset, floors, volume, match);
      else
        reduced_search.match(left_words, right_words, offset, floors, windows, volume, match);
    }
    if (!is_full) return;
    for (int y = 0; y < left.rows; ++y)  // cv::Mat::setTo would allocate
      std::fill_n(match.search_width[y], left.cols, static_cast<uint16_t>(params.range.count));
  }

  // The windows use the memory of this match: what was returned before must not change.
  void prepare(cv::Size size, Match& match) {
    match.disparity_px.create(size);
    match.ambiguity.create(size);
    match.search_width.create(size);
    windows.width = match.search_width;
  }

  void matchNothing(Match& match) const {
    match.disparity_px.setTo(params.range.invalid());
    match.ambiguity.setTo(255);
    match.search_width.setTo(0);
  }

  // Plans the windows of these ranges. Returns whether all of them are the whole range: the full
  // search is faster then.
  bool coverEverything(const SearchRanges& ranges, const PrincipalOffset& offset, cv::Size size) {
    const bool between = offset.fraction_px > 0;
    if (params.exact_ranges)
      planExactWindows(ranges, params.range, between, size, windows);
    else
      planSearchWindows(ranges, params.range, between, size, target_bit, windows);
    return isFullSearch(windows, params.range);
  }

  const MatcherParams params;
  const std::string simd_target;
  const int64_t target_bit;
  CensusKernel census;
  AlignedBuffer volume;
  FullSearch full_search;
  ReducedSearch reduced_search;
  JumpFloors floors;
  SearchWindows windows;
  cv::Mat1i left_words, right_words;
};

StereoMatcher::StereoMatcher(const MatcherParams& params) {
  validateMatcher(params);
  workspace_ = std::make_unique<Workspace>(params);
}
StereoMatcher::~StereoMatcher() = default;
StereoMatcher::StereoMatcher(StereoMatcher&&) noexcept = default;
StereoMatcher& StereoMatcher::operator=(StereoMatcher&&) noexcept = default;

const MatcherParams& StereoMatcher::params() const { return workspace_->params; }

const std::string& StereoMatcher::simdTarget() const { return workspace_->simd_target; }

void StereoMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, Match& match,
                          double principal_offset_px) {
  workspace_->match(left, right, nullptr, principal_offset_px, match);
}

void StereoMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges& ranges,
                          Match& match, double principal_offset_px) {
  workspace_->match(left, right, &ranges, principal_offset_px, match);
}

}  // namespace predictive_stereo
