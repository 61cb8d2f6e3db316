#include "predictive_stereo/matcher.h"

#include <sstream>
#include <stdexcept>

#include "matching/reference_sgm.h"
#include "matching/search_windows.h"

namespace predictive_stereo {
namespace {

void validateMatcher(const MatcherParams& params) {
  validate(params);
  std::ostringstream text;
  if (params.range.count % 16 != 0)
    text << "range/count = " << params.range.count << ": must be a multiple of 16";
  else if (params.p2 <= params.p1)
    text << "p2 = " << params.p2 << ": must be larger than p1 = " << params.p1;
  if (!text.str().empty()) throw std::invalid_argument(text.str());
}

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
  MatcherParams params;
  SearchWindows windows;

  void run(const cv::Mat1b& left, const cv::Mat1b& right, Match& match) {
    matchReference(left, right, params, windows, match);
    windows.width.copyTo(match.search_width);
  }
};

StereoMatcher::StereoMatcher(const MatcherParams& params) {
  validateMatcher(params);
  workspace_ = std::make_unique<Workspace>();
  workspace_->params = params;
}
StereoMatcher::~StereoMatcher() = default;
StereoMatcher::StereoMatcher(StereoMatcher&&) noexcept = default;
StereoMatcher& StereoMatcher::operator=(StereoMatcher&&) noexcept = default;

const MatcherParams& StereoMatcher::params() const { return workspace_->params; }

void StereoMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, Match& match) {
  requireEqualSizes(left, right);
  planFullSearch(workspace_->params.range, left.size(), workspace_->windows);
  workspace_->run(left, right, match);
}

void StereoMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, const SearchRanges& ranges,
                          Match& match) {
  requireEqualSizes(left, right);
  planSearchWindows(ranges, workspace_->params.range, left.size(), workspace_->windows);
  workspace_->run(left, right, match);
}

}  // namespace predictive_stereo
