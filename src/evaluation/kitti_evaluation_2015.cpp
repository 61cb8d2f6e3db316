#include "evaluation/kitti_evaluation_2015.h"

#include <algorithm>
#include <numeric>
#include <utility>

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

void addVariances(const KittiScene2015& scene, const DisparityRange& range,
                  const DisparityOutput& maps, KittiMethodResult2015& result) {
  if (maps.disparity_variance_px2.empty()) return;
  forEachError(maps.disparity_px, range, scene.truth_px, [&](int x, int y, double error_px) {
    auto& calibration = scene.vehicles(y, x) ? result.vehicle_variance : result.background_variance;
    calibration.add(error_px, maps.disparity_variance_px2(y, x));
  });
}

// Of all pixels, background and vehicles.
std::string triple(const KittiScore& score, double (KittiCounts::*figure)() const) {
  return fixed((score.all().*figure)(), 2) + " / " + fixed((score.background.*figure)(), 2) +
         " / " + fixed((score.vehicles.*figure)(), 2);
}
Row triples(const KittiScore& score) {
  return {triple(score, &KittiCounts::d1_percent), triple(score, &KittiCounts::d1_valid_percent)};
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

KittiCounts& KittiCounts::operator+=(const KittiCounts& other) {
  found += other.found;
  interpolated += other.interpolated;
  return *this;
}

KittiCounts KittiScore::all() const {
  KittiCounts sum = background;
  return sum += vehicles;
}

KittiScore& KittiScore::operator+=(const KittiScore& other) {
  background += other.background;
  vehicles += other.vehicles;
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
  return {countsOf(vehicles == 0), countsOf(vehicles)};
}

MethodInput inputOf(const KittiScene2015& scene, int index) {
  MethodInput input{
      index, {scene.left, scene.right, scene.rig, index * std::chrono::milliseconds(100)}, {}};
  input.camera.pose.state = PoseState::kKnown;  // the path starts here
  return input;
}

KittiSceneResult2015 evaluateKittiScene2015(
    const KittiScene2015& scene, const MethodInput& input,
    const std::vector<std::unique_ptr<DisparityMethod>>& running, const DisparityRange& range,
    std::vector<MethodOutput>& outputs) {
  outputs.resize(running.size());
  KittiSceneResult2015 results{scene.name, {}};
  for (size_t m = 0; m < running.size(); ++m) {
    running[m]->run(input, outputs[m]);
    const cv::Mat1f& disparity_px = outputs[m].maps.disparity_px;
    KittiMethodResult2015 result;
    result.ms = outputs[m].ms;
    result.score = scoreAsKitti(disparity_px, range, scene.truth_px, scene.vehicles);
    if (!scene.truth_noc_px.empty())
      result.score_noc = scoreAsKitti(disparity_px, range, scene.truth_noc_px, scene.vehicles);
    addVariances(scene, range, outputs[m].maps, result);
    const cv::Mat1f doubt = running[m]->doubt(input, outputs[m]);
    if (!doubt.empty())
      forEachError(
          disparity_px, range, scene.truth_px,
          [&](int x, int y, double error_px) { result.sparsification.add(error_px, doubt(y, x)); },
          2);
    results.methods.push_back(std::move(result));
  }
  return results;
}

template <class Value>
Value KittiEvaluation2015::total(size_t method, Value KittiMethodResult2015::*member) const {
  Value sum{};
  for (const auto& scene : scenes) sum += scene.methods[method].*member;
  return sum;
}

size_t KittiEvaluation2015::shown() const {
  const auto ours = std::find(methods.begin(), methods.end(), kOurs);
  return ours == methods.end() ? 0 : static_cast<size_t>(ours - methods.begin());
}

Table KittiEvaluation2015::table() const {
  Table table{"KITTI 2015, " + std::to_string(scenes.size()) +
                  " single pairs, pooled: all / background / vehicles",
              {"method", "ms", "D1 % interpolated", "D1 % of valid pixels", "density %"},
              {}};
  bool has_noc = false;
  for (const auto& scene : scenes)
    for (const auto& result : scene.methods)
      has_noc |= result.score_noc.all().found.truth_pixels > 0;
  if (has_noc)
    table.header = row(table.header, "D1 % not occluded, interpolated", "D1 % not occluded, valid");
  for (size_t m = 0; m < methods.size(); ++m) {
    double mean_ms = 0;
    for (const auto& scene : scenes) mean_ms += scene.methods[m].ms / double(scenes.size());
    const KittiScore score = total(m, &KittiMethodResult2015::score);
    table.add(methods[m], fixed(mean_ms, 1), triples(score),
              triple(score, &KittiCounts::density_percent),
              has_noc ? triples(total(m, &KittiMethodResult2015::score_noc)) : Row());
  }
  return table;
}

std::vector<size_t> KittiEvaluation2015::worst() const {
  constexpr size_t kWorst = 10;
  std::vector<size_t> order(scenes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto wrong = [&](size_t s) {
    return scenes[s].methods[shown()].score.all().interpolated.wrong();
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return wrong(a) > wrong(b); });
  order.resize(std::min(order.size(), kWorst));
  return order;
}

Table KittiEvaluation2015::worstTable() const {
  Table table{methods[shown()] + ": scenes with most wrong pixels; all / background / vehicles",
              {"scene", "D1 % interpolated", "D1 % of valid pixels", "density %", "wrong",
               "of them on vehicles"},
              {}};
  for (const size_t s : worst()) {
    const KittiScore& score = scenes[s].methods[shown()].score;
    table.add(scenes[s].scene, triples(score), triple(score, &KittiCounts::density_percent),
              score.all().interpolated.wrong(), score.vehicles.interpolated.wrong());
  }
  return table;
}

Table KittiEvaluation2015::calibrationTable() const {
  VarianceCalibration background = total(shown(), &KittiMethodResult2015::background_variance),
                      vehicles = total(shown(), &KittiMethodResult2015::vehicle_variance),
                      all = background;
  all += vehicles;
  Table table{"Variance of ours: shares of errors within 1, 2, 3 sigma (normal: 68.3, 95.4, 99.7)",
              {"pixels", "1 sigma %", "2 sigma %", "3 sigma %", "mean sigma px", "count"},
              {}};
  for (const auto& [name, c] : {std::pair("all", &all), std::pair("background", &background),
                                std::pair("vehicles", &vehicles)})
    if (c->count() > 0) table.add(name, percentWithin(*c), fixed(c->meanSigma_px(), 3), c->count());
  return table;
}

Table KittiEvaluation2015::certaintyTable() const {
  Table table{"Certainty: area under the sparsification error (AUSE) of the mean absolute error",
              {"method", "mean error px", "AUSE px", "of a random order px", "AUSE / random"},
              {}};
  for (size_t m = 0; m < methods.size(); ++m) {
    const Sparsification all = total(m, &KittiMethodResult2015::sparsification);
    if (all.empty()) continue;
    const double ause_px = all.ause_px(), random_px = all.auseOfNothing_px();
    table.add(methods[m], fixed(all.meanError_px(), 3), fixed(ause_px, 3), fixed(random_px, 3),
              fixed(ratio(ause_px, random_px), 3));
  }
  return table;
}

std::string KittiEvaluation2015::csv() const {
  Table csv = Table::ofCsv(
      "scene,method,ms,background_pixels,background_valid,background_outliers,"
      "background_interpolated_outliers,vehicle_pixels,vehicle_valid,vehicle_outliers,"
      "vehicle_interpolated_outliers");
  const auto counted = [](const KittiCounts& counts) {
    return row(counts.found.truth_pixels, counts.found.valid_pixels, counts.found.outliers,
               counts.interpolated.wrong());
  };
  for (const auto& scene : scenes)
    for (size_t m = 0; m < methods.size(); ++m) {
      const auto& result = scene.methods[m];
      csv.add(scene.scene, methods[m], result.ms, counted(result.score.background),
              counted(result.score.vehicles));
    }
  return csv.csv();
}

}  // namespace predictive_stereo
