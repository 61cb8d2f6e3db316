#include "predictive_stereo/matcher.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "matching/census_kernel.h"
#include "matching/full_search.h"
#include "matching/jump_floors.h"
#include "matching/matcher_limits.h"
#include "matching/reduced_search.h"
#include "matching/reference_sgm.h"
#include "matching/search_windows.h"
#include "matching/simd_dispatch.h"
#include "predictive_stereo/simd_target.h"

namespace predictive_stereo {
namespace {

void requireEqualSizes(const cv::Mat1b& left, const cv::Mat1b& right) {
  std::ostringstream text;
  if (left.empty())
    text << "the left image is empty: nothing to match";
  else if (left.size() != right.size())
    text << "the right image is " << right.cols << "x" << right.rows << ", the left one "
         << left.cols << "x" << left.rows << ": both must have one size";
  if (!text.str().empty()) throw std::invalid_argument(text.str());
}

}  // namespace

struct StereoMatcher::Workspace {
  explicit Workspace(const MatcherParams& matcher_params)
      : params(matcher_params),
        simd_target(chooseSimdTarget(matcher_params.simd_target)),
        target_bit(simdTargetBit(simd_target)),
        census(params.census, target_bit),
        full_search(params, target_bit),
        reduced_search(params, target_bit) {}

  void prepare(cv::Size size, Match& match) const {
    match.disparity_px.create(size);
    match.ambiguity.create(size);
    match.search_width.create(size);
  }

  void matchFully(const cv::Mat1b& left, const cv::Mat1b& right, Match& match) {
    prepare(left.size(), match);
    if (target_bit == kScalarTarget) {
      planFullSearch(params.range, left.size(), windows);
      matchReference(left, right, params, windows, match);
    } else {
      census.transform(left, left_words);
      census.transform(right, right_words);
      floors.build(left, params);
      full_search.match(left_words, right_words, floors, volume, match);
    }
    for (int y = 0; y < left.rows; ++y)  // cv::Mat::setTo would allocate
      std::fill_n(match.search_width[y], left.cols, static_cast<uint16_t>(params.range.count));
  }

  void matchReduced(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges& ranges,
                    Match& match) {
    prepare(left.size(), match);
    windows.width = match.search_width;
    if (params.exact_ranges)
      planExactWindows(ranges, params.range, left.size(), windows);
    else
      planSearchWindows(ranges, params.range, left.size(), target_bit, windows);
    if (isFullSearch(windows, params.range)) return matchFully(left, right, match);
    if (params.exact_ranges || target_bit == kScalarTarget) {
      matchReference(left, right, params, windows, match);
    } else {
      census.transform(left, left_words);
      census.transform(right, right_words);
      floors.build(left, params);
      reduced_search.match(left_words, right_words, floors, windows, volume, match);
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

void StereoMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, Match& match) {
  requireEqualSizes(left, right);
  workspace_->matchFully(left, right, match);
}

void StereoMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges& ranges,
                          Match& match) {
  requireEqualSizes(left, right);
  workspace_->matchReduced(left, right, ranges, match);
}

}  // namespace predictive_stereo
