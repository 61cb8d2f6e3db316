#include "matching/jump_floors.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace predictive_stereo {

void JumpFloors::build(const cv::Mat1b& left, const MatcherParams& params) {
  // Pixels on each side, beyond the edge's own two, where the step must last.
  constexpr int kReach = 2;
  constexpr int kBeside = kReach + 1, kMargin = 16;
  const int lowered = params.edge_step > 0 ? std::max(params.p2 - params.p2_edge, 0) : 0;
  cv::copyMakeBorder(left, padded_, kBeside, kBeside, kBeside, kBeside,
                     cv::BORDER_REPLICATE | cv::BORDER_ISOLATED);
  const cv::Rect area(kBeside, kBeside, left.cols + 1, left.rows + 1);
  const auto build = [&](cv::Point step, cv::Mat1b& all) {
    const auto at = [&](int steps) { return padded_(area + steps * step); };
    all.create(area.height, area.width + kMargin);
    cv::Mat floors = all.colRange(0, area.width);
    cv::absdiff(at(-1), at(0), floors);
    cv::absdiff(at(-1 - kReach), at(kReach), far_steps_);
    cv::min(floors, far_steps_, floors);
    cv::threshold(floors, floors, params.edge_step - 1, lowered, cv::THRESH_BINARY);
  };
  build({1, 0}, across_);
  build({0, 1}, down_);
}

}  // namespace predictive_stereo
