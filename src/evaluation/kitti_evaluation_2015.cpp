#include "evaluation/kitti_evaluation_2015.h"

#include <algorithm>

namespace predictive_stereo {
namespace {

/// Returns whether the row has any disparity.
bool interpolateRow(const DisparityRange& range, int width, float* row) {
  int last = -1;  // valid pixel
  for (int x = 0; x < width; ++x) {
    if (!range.isValid(row[x])) continue;
    const float fill = last < 0 ? row[x] : std::min(row[last], row[x]);
    std::fill(row + last + 1, row + x, fill);
    last = x;
  }
  if (last >= 0) std::fill(row + last + 1, row + width, row[last]);
  return last >= 0;
}

// Of all pixels, background and vehicles.
std::string triple(const KittiScore& score, double (KittiCounts::*figure)() const) {
  return fixed((score.all.*figure)(), 2) + " / " + fixed((score.background.*figure)(), 2) + " / " +
         fixed((score.vehicles.*figure)(), 2);
}
Row figures(const KittiScore& score) {
  return {triple(score, &KittiCounts::d1_percent), triple(score, &KittiCounts::d1_valid_percent),
          triple(score, &KittiCounts::density_percent)};
}

}  // namespace

void interpolateAsKitti(const DisparityRange& range, cv::Mat1f& disparity_px) {
  int filled = -1;  // the last row with disparities
  for (int y = 0; y < disparity_px.rows; ++y) {
    if (!interpolateRow(range, disparity_px.cols, disparity_px[y])) continue;
    for (int missing = filled + 1; missing < y; ++missing) {
      const bool upper = filled >= 0 && missing - filled <= y - missing;
      disparity_px.row(upper ? filled : y).copyTo(disparity_px.row(missing));
    }
    filled = y;
  }
  if (filled < 0) return;
  for (int missing = filled + 1; missing < disparity_px.rows; ++missing)
    disparity_px.row(filled).copyTo(disparity_px.row(missing));
}

KittiScore& KittiScore::operator+=(const KittiScore& other) {
  for (const auto pixels : {&KittiScore::all, &KittiScore::background, &KittiScore::vehicles}) {
    (this->*pixels).found += (other.*pixels).found;
    (this->*pixels).interpolated += (other.*pixels).interpolated;
  }
  return *this;
}

KittiScore scoreAsKitti(const cv::Mat1f& disparity_px, const DisparityRange& range,
                        const cv::Mat1f& truth_px, const cv::Mat1b& vehicles) {
  cv::Mat1f interpolated_px = disparity_px.clone();
  interpolateAsKitti(range, interpolated_px);
  const auto countsOf = [&](const cv::Mat1b& mask) {
    return KittiCounts{scoreDisparity(disparity_px, range, truth_px, mask),
                       scoreDisparity(interpolated_px, range, truth_px, mask)};
  };
  return {countsOf({}), countsOf(vehicles == 0), countsOf(vehicles)};
}

KittiEvaluation2015::KittiEvaluation2015(const std::vector<NamedMethod>& methods) : shown_(0) {
  for (const NamedMethod& method : methods) {
    if (method.name == kOurs) shown_ = methods_.size();
    methods_.emplace_back().name = method.name;
  }
}

void KittiEvaluation2015::add(const std::string& scene, const SequenceFrame& frame,
                              const MethodInput& input, const std::vector<DisparityMethod>& running,
                              const DisparityRange& range) {
  for (size_t m = 0; m < methods_.size(); ++m) {
    Method& method = methods_[m];
    MethodOutput output;
    running[m](input, output);
    method.ms += output.ms;
    const DisparityOutput& maps = output.maps;
    const KittiScore score = scoreAsKitti(maps.disparity_px, range, frame.truth_px, frame.vehicles);
    method.score += score;
    if (m == shown_) scenes_.emplace_back(scene, score);
    if (!maps.disparity_variance_px2.empty())
      forEachError(maps.disparity_px, range, frame.truth_px, [&](int x, int y, double error_px) {
        const float variance_px2 = maps.disparity_variance_px2(y, x);
        method.variance.add(error_px, variance_px2);
        (frame.vehicles(y, x) ? method.vehicle_variance : method.background_variance)
            .add(error_px, variance_px2);
      });
    const cv::Mat1f doubt = output.doubt ? output.doubt() : maps.disparity_variance_px2;
    const auto addDoubt = [&](int x, int y, double error_px) {
      method.sparsification.add(error_px, doubt(y, x));
    };
    constexpr int kStep = 2;
    if (!doubt.empty()) forEachError(maps.disparity_px, range, frame.truth_px, addDoubt, kStep);
  }
}

Table KittiEvaluation2015::table() const {
  Table table{"KITTI 2015, " + std::to_string(scenes_.size()) +
                  " single pairs, pooled: all / background / vehicles",
              {"method", "ms", "D1 % interpolated", "D1 % of valid pixels", "density %"}};
  for (const Method& method : methods_)
    table.add(method.name, fixed(method.ms / static_cast<double>(scenes_.size()), 1),
              figures(method.score));
  return table;
}

std::vector<std::pair<std::string, KittiScore>> KittiEvaluation2015::worst() const {
  constexpr size_t kWorst = 10;
  const auto wrong = [](const auto& scene) { return scene.second.all.interpolated.wrong(); };
  auto worst = scenes_;
  std::stable_sort(worst.begin(), worst.end(),
                   [&](const auto& a, const auto& b) { return wrong(a) > wrong(b); });
  worst.resize(std::min(worst.size(), kWorst));
  return worst;
}

Table KittiEvaluation2015::worstTable() const {
  Table table{
      methods_[shown_].name + ": scenes with most wrong pixels; all / background / vehicles",
      {"scene", "D1 % interpolated", "D1 % of valid pixels", "density %", "wrong",
       "of them on vehicles"}};
  for (const auto& [scene, score] : worst())
    table.add(scene, figures(score), score.all.interpolated.wrong(),
              score.vehicles.interpolated.wrong());
  return table;
}

Table KittiEvaluation2015::variances() const {
  const Method& shown = methods_[shown_];
  return calibrationTable({{"all", shown.variance},
                           {"background", shown.background_variance},
                           {"vehicles", shown.vehicle_variance}});
}

Table KittiEvaluation2015::certaintyTable() const {
  Table table{"Certainty: area under the sparsification error (AUSE) of the mean absolute error",
              {"method", "mean error px", "AUSE px", "of a random order px", "AUSE / random"}};
  for (const Method& method : methods_) {
    const Sparsification& pixels = method.sparsification;
    if (pixels.empty()) continue;
    const double ause_px = pixels.ause_px(), random_px = pixels.auseOfNothing_px();
    table.add(method.name, fixed(pixels.meanError_px(), 3), fixed(ause_px, 3), fixed(random_px, 3),
              fixed(ratio(ause_px, random_px), 3));
  }
  return table;
}

}  // namespace predictive_stereo
