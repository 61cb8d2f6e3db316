#include "predictive_stereo/matcher.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "imaging/size_check.h"
#include "matching/census.h"
#include "matching/full_search.h"
#include "matching/jump_floors.h"
#include "matching/principal_offset.h"
#include "matching/reduced_search.h"
#include "matching/reference_sgm.h"
#include "matching/search_windows.h"
#include "predictive_stereo/simd_target.h"
#include "simd/simd_dispatch.h"

namespace predictive_stereo {
namespace {

void requireEqualSizes(const cv::Mat1b& left, const cv::Mat1b& right) {
  if (left.empty()) throw std::invalid_argument("the left image is empty: nothing to match");
  requireSize("the right image", right.size(), left.size(), "but the left one is");
}

}  // namespace

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

  // The windows use the memory of this match: what was returned before must not change.
  void prepare(cv::Size size, Match& match) {
    match.disparity_px.create(size);
    match.ambiguity.create(size);
    match.search_width.create(size);
    windows.width = match.search_width;
  }

  void matchNothing(cv::Size size, Match& match) {
    prepare(size, match);
    match.disparity_px.setTo(params.range.invalid());
    match.ambiguity.setTo(255);
    match.search_width.setTo(0);
  }

  void matchFully(const cv::Mat1b& left, const cv::Mat1b& right, const PrincipalOffset& offset,
                  Match& match) {
    prepare(left.size(), match);
    if (target_bit == kScalarTarget) {
      planFullSearch(params.range, left.size(), windows);
      matchReference(left, right, params, offset, windows, match);
    } else {
      census.transform(left, left_words);
      census.transform(right, right_words);
      floors.build(left, params);
      full_search.match(left_words, right_words, offset, floors, volume, match);
    }
    for (int y = 0; y < left.rows; ++y)  // cv::Mat::setTo would allocate
      std::fill_n(match.search_width[y], left.cols, static_cast<uint16_t>(params.range.count));
  }

  void matchReduced(const cv::Mat1b& left, const cv::Mat1b& right, const PrincipalOffset& offset,
                    const SearchRanges& ranges, Match& match) {
    prepare(left.size(), match);
    const bool between = offset.fraction_px > 0;
    if (params.exact_ranges)
      planExactWindows(ranges, params.range, between, left.size(), windows);
    else
      planSearchWindows(ranges, params.range, between, left.size(), target_bit, windows);
    if (isFullSearch(windows, params.range)) return matchFully(left, right, offset, match);
    if (params.exact_ranges || target_bit == kScalarTarget) {
      matchReference(left, right, params, offset, windows, match);
    } else {
      census.transform(left, left_words);
      census.transform(right, right_words);
      floors.build(left, params);
      reduced_search.match(left_words, right_words, offset, floors, windows, volume, match);
    }
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
  requireEqualSizes(left, right);
  if (!leavesPartners(params().range, principal_offset_px, left.cols))
    return workspace_->matchNothing(left.size(), match);
  workspace_->matchFully(left, right, PrincipalOffset(principal_offset_px), match);
}

void StereoMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges& ranges,
                          Match& match, double principal_offset_px) {
  requireEqualSizes(left, right);
  if (!leavesPartners(params().range, principal_offset_px, left.cols))
    return workspace_->matchNothing(left.size(), match);
  workspace_->matchReduced(left, right, PrincipalOffset(principal_offset_px), ranges, match);
}

}  // namespace predictive_stereo
