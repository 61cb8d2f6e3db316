#include "evaluation/disparity_report.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

/// A static wall: disparity 8 in its left half, 20 in its right half.
class WallSequence : public Sequence {
 public:
  WallSequence() : Sequence("wall & <door>") {
    rig_.size = {160, 64};
    rig_.fx_px = rig_.fy_px = 200;
    rig_.cx_left_px = rig_.cx_right_px = 80;
    rig_.cy_px = 32;
    rig_.baseline_m = 0.5;
  }
  int frames() const override { return 4; }
  SequenceFrame frame(int index) const override {
    SequenceFrame frame;
    frame.left = cv::Mat1b(rig_.size, uchar{100});
    frame.right = frame.left;
    if (index > 0) {
      frame.truth_px = cv::Mat1f(rig_.size, 8.0f);
      frame.truth_px.colRange(80, 160).setTo(20.0f);
    }
    return frame;
  }
};

/// Gives disparity 8 everywhere; as "ours" with a variance, and invalid in the top quarter.
DisparityMethod constantMethod(bool own) {
  return [=](const MethodInput& input, MethodOutput& output) {
    const cv::Size size = input.frame.left.size();
    output.maps.disparity_px = cv::Mat1f(size, 8.5f);
    output.ms = 10 * (input.index + 1);
    if (!own) return;
    output.maps.disparity_px.rowRange(0, 16).setTo(-1.0f);
    output.maps.measured_disparity_px = output.maps.disparity_px.clone() + 0.5f;
    output.maps.measured_disparity_px.rowRange(0, 16).setTo(-1.0f);
    output.maps.disparity_variance_px2 = cv::Mat1f(size, 1.0f);
    output.maps.search_width_px = cv::Mat1w(size, ushort{16});
    output.maps.search_width_px.colRange(0, 40).setTo(128);
    output.maps.ambiguity = cv::Mat1b(size, uchar{64});
    output.maps.predicted = true;
    output.maps.predicted_disparity_px = cv::Mat1f(size, 9.0f);
    output.maps.predicted_disparity_px.colRange(80, 160).setTo(11.5f);
    output.objects = {DetectedObject()};
    output.objects[0].box_px = {100, 30, 20, 20};
  };
}

// With a page: also writes the maps of the last frame.
SequenceReport evaluateWall(Report* page = nullptr) {
  const std::vector<NamedMethod> methods = {{kOpencvHh, [] { return constantMethod(false); }},
                                            {kOurs, [] { return constantMethod(true); }}};
  const WallSequence wall;
  SequenceReport report;
  report.name = wall.name();
  const auto addMaps = [&](const SequenceFrame& frame, int index, size_t m,
                           const MethodOutput& output) {
    if (index != 3 || !page) return;
    if (m == 0) report.frames.push_back(frameItem(frame, "wall", *page));
    addMethod(methods[m].name, DisparityRange{}, output, report.frames.back(), *page);
  };
  evaluateDisparity(wall, methods, PipelineParams{}, 0, addMaps, report.evaluations);
  return report;
}

TEST(EvaluateDisparity, CountsAllFramesButTheFirst) {
  const SequenceReport report = evaluateWall();
  const DisparityEvaluation &opencv = report.evaluations[0], &ours = report.evaluations[1];
  EXPECT_EQ(ours.images, 3);
  EXPECT_DOUBLE_EQ(ours.mean_ms, 30);
  EXPECT_DOUBLE_EQ(opencv.score.d1_percent, 50);
  EXPECT_DOUBLE_EQ(ours.score.d1_percent, 50);
  EXPECT_DOUBLE_EQ(ours.score.d1_filled_percent, 62.5);
  EXPECT_DOUBLE_EQ(ours.score.density_percent, 75);
  EXPECT_NEAR(ours.score.rms_px, 0.5, 1e-6);
  EXPECT_NEAR(ours.measured.rms_px, 1.0, 1e-6);
  EXPECT_DOUBLE_EQ(ours.mean_width_px, 44);
  EXPECT_DOUBLE_EQ(ours.variance.shareWithin(1), 0.5);
  EXPECT_EQ(opencv.measured.frames, 0);
  ASSERT_EQ(ours.series.size(), 3u);
  EXPECT_EQ(ours.series[0].index, 1);
}

TEST(DisparityReport, TablesHoldTheFigures) {
  const SequenceReport report = evaluateWall();
  const Table accuracy = accuracyTable(report);
  EXPECT_EQ(accuracy.rows[1],
            (std::vector<std::string>{"ours", "30.0", "50.00", "62.50", "75.00", "0.500"}));
  EXPECT_EQ(tables(report).back().rows[0][0], "all") << "variances";
}

TEST(DisparityReport, CsvLinesHaveAsManyFieldsAsTheHeader) {
  const SequenceReport report = evaluateWall();
  for (const std::string& text : {csv({report}), framesCsv({report}), sharesCsv({report})}) {
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    const auto commas = std::count(line.begin(), line.end(), ',');
    int count = 0;
    for (; std::getline(lines, line); ++count)
      EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    EXPECT_GE(count, 2);
  }
}

TEST(DisparityReport, ItsPageHasTablesPlotsAndMaps) {
  const TemporaryDirectory dir;
  Report page(dir.path("page"), "Walls", "evaluate <this>");
  const SequenceReport report = evaluateWall(&page);
  add({report}, page);
  page.finish();
  const YAML::Node written = YAML::LoadFile(dir.path("page/report.yaml"));
  EXPECT_EQ(written["title"].as<std::string>(), "Walls");
  EXPECT_EQ(written["provenance"].as<std::string>(), "evaluate <this>");
  std::map<std::string, int> kinds;
  YAML::Node frame;
  for (const YAML::Node& item : written["items"]) {
    ++kinds[item.begin()->first.as<std::string>()];
    if (item["frame"]) frame = item;
    if (!item["table"]) continue;
    EXPECT_GT(item["rows"].size(), 0u) << item["table"];
    for (const YAML::Node& row : item["rows"]) EXPECT_EQ(row.size(), item["header"].size());
  }
  EXPECT_EQ(kinds["table"], static_cast<int>(tables(report).size()));
  EXPECT_EQ(kinds["outliers"] + kinds["variance"], 2);
  EXPECT_TRUE(std::filesystem::exists(dir.path("page/frames.csv")));
  EXPECT_TRUE(std::filesystem::exists(dir.path("page/variance.csv")));

  const auto map = [&](const YAML::Node& file) -> cv::Mat1w {
    return cv::imread(dir.path("page/" + file.as<std::string>()), cv::IMREAD_UNCHANGED);
  };
  EXPECT_EQ(map(frame["truth"])(10, 100), 20 * 256);
  ASSERT_EQ(frame["methods"].size(), 2u);
  EXPECT_FALSE(frame["methods"][0]["sigma"]);
  const YAML::Node ours = frame["methods"][1];
  EXPECT_EQ(map(ours["disparity"])(10, 100), 0) << "invalid";
  EXPECT_EQ(map(ours["disparity"])(40, 40), 8.5 * 256);
  EXPECT_EQ(map(ours["sigma"])(40, 40), 256);
  EXPECT_EQ(map(ours["width"])(10, 10), 128 * 256);
  EXPECT_EQ(map(ours["measured"])(40, 40), 9 * 256);
  EXPECT_EQ(map(ours["predicted"])(10, 100), 11.5 * 256);
  EXPECT_EQ(ours["boxes"][0].as<std::vector<int>>(), (std::vector<int>{100, 30, 20, 20}));
}

TEST(Report, MapsKeepZeroApartFromUnknown) {
  const TemporaryDirectory dir;
  Report page(dir.path(""), "", "");
  const cv::Mat1f values = (cv::Mat1f(1, 3) << 0, 0, 300);
  const cv::Mat1b known = (cv::Mat1b(1, 3) << 255, 0, 255);
  const cv::Mat1w map = cv::imread(dir.path(page.writeMap(values, known)), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(map(0, 0), 1);
  EXPECT_EQ(map(0, 1), 0);
  EXPECT_EQ(map(0, 2), 65535) << "the largest that fits";
  page.add(Table());  // without rows: left out
  page.finish();
  EXPECT_EQ(YAML::LoadFile(dir.path("report.yaml"))["items"].size(), 0u);
}

TEST(Table, QuotesAndFillsCellsOfCsv) {
  Table table = Table::ofCsv("name,a,b");
  table.add("wall, \"old\"", row(0.5, 2));
  table.add("door", 1.0 / 3);
  EXPECT_EQ(table.csv(), "name,a,b\n\"wall, \"\"old\"\"\",0.5,2\ndoor,0.333333,\n");
}

}  // namespace
}  // namespace predictive_stereo
