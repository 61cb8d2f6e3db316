#include "evaluation/kitti_evaluation_2015.h"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <stdexcept>

namespace predictive_stereo {
namespace {

double percent(int64_t part, int64_t whole) {
  return whole ? 100 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

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
  for (int y = 0; y < scene.truth_px.rows; ++y)
    for (int x = 0; x < scene.truth_px.cols; ++x) {
      const float truth_px = scene.truth_px(y, x), disparity_px = maps.disparity_px(y, x);
      if (!hasTruth(truth_px) || !range.isValid(disparity_px)) continue;
      auto& calibration =
          scene.vehicles(y, x) ? result.vehicle_variance : result.background_variance;
      calibration.add(static_cast<double>(disparity_px) - truth_px,
                      maps.disparity_variance_px2(y, x));
    }
}

struct Totals {
  KittiScore score, score_noc;
  double mean_ms = 0;
};

Totals totals(const std::vector<KittiSceneResult2015>& scenes, size_t method) {
  Totals sum;
  for (const auto& scene : scenes) {
    const KittiMethodResult2015& result = scene.methods[method];
    sum.score += result.score;
    sum.score_noc += result.score_noc;
    sum.mean_ms += result.ms / static_cast<double>(scenes.size());
  }
  return sum;
}

std::string triple(const KittiScore& score, double (KittiCounts::*figure)() const) {
  return fixed((score.all().*figure)(), 2) + " / " + fixed((score.background.*figure)(), 2) +
         " / " + fixed((score.vehicles.*figure)(), 2);
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

double KittiCounts::d1_percent() const { return percent(interpolated_outliers, pixels); }
double KittiCounts::d1_valid_percent() const { return percent(outliers, valid); }
double KittiCounts::density_percent() const { return percent(valid, pixels); }

KittiCounts& KittiCounts::operator+=(const KittiCounts& other) {
  pixels += other.pixels;
  valid += other.valid;
  outliers += other.outliers;
  interpolated_outliers += other.interpolated_outliers;
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

KittiScore scoreAsKitti(const cv::Mat1f& disparity_px, const cv::Mat1f& interpolated_px,
                        const DisparityRange& range, const cv::Mat1f& truth_px,
                        const cv::Mat1b& vehicles) {
  if (disparity_px.size() != truth_px.size() || interpolated_px.size() != truth_px.size() ||
      vehicles.size() != truth_px.size())
    throw std::invalid_argument("scoreAsKitti: disparities, truth and vehicles must have one size");
  KittiScore score;
  for (int y = 0; y < truth_px.rows; ++y)
    for (int x = 0; x < truth_px.cols; ++x) {
      const float truth = truth_px(y, x);
      if (!hasTruth(truth)) continue;
      KittiCounts& counts = vehicles(y, x) ? score.vehicles : score.background;
      ++counts.pixels;
      if (range.isValid(disparity_px(y, x))) {
        ++counts.valid;
        if (isOutlier(disparity_px(y, x), truth)) ++counts.outliers;
      }
      const float interpolated = interpolated_px(y, x);
      if (!range.isValid(interpolated) || isOutlier(interpolated, truth))
        ++counts.interpolated_outliers;
    }
  return score;
}

std::vector<std::unique_ptr<DisparityMethod>> startMethods(
    const std::vector<NamedMethod>& methods) {
  std::vector<std::unique_ptr<DisparityMethod>> running;
  for (const NamedMethod& method : methods) running.push_back(method.make());
  return running;
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
    cv::Mat1f interpolated_px = disparity_px.clone();
    interpolateAsKitti(range, interpolated_px);
    KittiMethodResult2015 result;
    result.ms = outputs[m].ms;
    result.score =
        scoreAsKitti(disparity_px, interpolated_px, range, scene.truth_px, scene.vehicles);
    if (!scene.truth_noc_px.empty())
      result.score_noc =
          scoreAsKitti(disparity_px, interpolated_px, range, scene.truth_noc_px, scene.vehicles);
    addVariances(scene, range, outputs[m].maps, result);
    results.methods.push_back(result);
  }
  return results;
}

Table kittiTable2015(const std::vector<std::string>& methods,
                     const std::vector<KittiSceneResult2015>& scenes) {
  Table table;
  table.title = "KITTI 2015, " + std::to_string(scenes.size()) +
                " single pairs, pooled: all / background / vehicles";
  table.header = {"method", "ms", "D1 % interpolated", "D1 % of valid pixels", "density %"};
  bool has_noc = false;
  for (const auto& scene : scenes)
    for (const auto& result : scene.methods) has_noc |= result.score_noc.all().pixels > 0;
  if (has_noc) {
    table.header.emplace_back("D1 % not occluded, interpolated");
    table.header.emplace_back("D1 % not occluded, valid");
  }
  for (size_t m = 0; m < methods.size(); ++m) {
    const Totals sum = totals(scenes, m);
    table.rows.push_back({methods[m], fixed(sum.mean_ms, 1),
                          triple(sum.score, &KittiCounts::d1_percent),
                          triple(sum.score, &KittiCounts::d1_valid_percent),
                          triple(sum.score, &KittiCounts::density_percent)});
    if (!has_noc) continue;
    table.rows.back().push_back(triple(sum.score_noc, &KittiCounts::d1_percent));
    table.rows.back().push_back(triple(sum.score_noc, &KittiCounts::d1_valid_percent));
  }
  return table;
}

std::vector<size_t> worstSceneIndices2015(const std::vector<KittiSceneResult2015>& scenes,
                                          size_t method, int count) {
  std::vector<size_t> order(scenes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  const auto wrong = [&](size_t s) {
    return scenes[s].methods[method].score.all().interpolated_outliers;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return wrong(a) > wrong(b); });
  order.resize(std::min(order.size(), static_cast<size_t>(count)));
  return order;
}

Table worstScenes2015(const std::vector<std::string>& methods,
                      const std::vector<KittiSceneResult2015>& scenes, size_t method, int count) {
  Table table;
  table.title = methods[method] + ": scenes with most wrong pixels; all / background / vehicles";
  table.header = {"scene", "D1 % interpolated",  "D1 % of valid pixels", "density %",
                  "wrong", "of them on vehicles"};
  for (const size_t s : worstSceneIndices2015(scenes, method, count)) {
    const KittiScore& score = scenes[s].methods[method].score;
    table.rows.push_back({scenes[s].scene, triple(score, &KittiCounts::d1_percent),
                          triple(score, &KittiCounts::d1_valid_percent),
                          triple(score, &KittiCounts::density_percent),
                          std::to_string(score.all().interpolated_outliers),
                          std::to_string(score.vehicles.interpolated_outliers)});
  }
  return table;
}

Table kittiCalibrationTable2015(const std::vector<KittiSceneResult2015>& scenes, size_t method) {
  VarianceCalibration background, vehicles;
  for (const auto& scene : scenes) {
    background += scene.methods[method].background_variance;
    vehicles += scene.methods[method].vehicle_variance;
  }
  VarianceCalibration all = background;
  all += vehicles;
  Table table;
  table.title =
      "Variance of ours: shares of errors within 1, 2, 3 sigma (normal: 68.3, 95.4, 99.7)";
  table.header = {"pixels", "1 sigma %", "2 sigma %", "3 sigma %", "mean sigma px", "count"};
  const auto add = [&](const char* name, const VarianceCalibration& c) {
    if (c.count() > 0)
      table.rows.push_back({name, fixed(100 * c.shareWithin(1), 1),
                            fixed(100 * c.shareWithin(2), 1), fixed(100 * c.shareWithin(3), 1),
                            fixed(c.meanSigma_px(), 3), std::to_string(c.count())});
  };
  add("all", all);
  add("background", background);
  add("vehicles", vehicles);
  return table;
}

std::string kittiCsv2015(const std::vector<std::string>& methods,
                         const std::vector<KittiSceneResult2015>& scenes) {
  std::ostringstream out;
  out << "scene,method,ms,background_pixels,background_valid,background_outliers,"
         "background_interpolated_outliers,vehicle_pixels,vehicle_valid,vehicle_outliers,"
         "vehicle_interpolated_outliers\n";
  for (const auto& scene : scenes)
    for (size_t m = 0; m < methods.size(); ++m) {
      const KittiMethodResult2015& result = scene.methods[m];
      out << scene.scene << ',' << methods[m] << ',' << result.ms;
      for (const KittiCounts& counts : {result.score.background, result.score.vehicles})
        out << ',' << counts.pixels << ',' << counts.valid << ',' << counts.outliers << ','
            << counts.interpolated_outliers;
      out << '\n';
    }
  return out.str();
}

}  // namespace predictive_stereo
