#include "evaluation/disparity_report.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace predictive_stereo {
namespace {

/// A static wall: disparity 8 in its left half, 20 in its right half.
class WallSequence : public Sequence {
 public:
  WallSequence() {
    rig_.size = {160, 64};
    rig_.fx_px = rig_.fy_px = 200;
    rig_.cx_left_px = rig_.cx_right_px = 80;
    rig_.cy_px = 32;
    rig_.baseline_m = 0.5;
  }
  const std::string& name() const override { return name_; }
  const StereoRig& rig() const override { return rig_; }
  int frames() const override { return 4; }
  SequenceFrame frame(int index) const override {
    SequenceFrame frame;
    frame.left = cv::Mat1b(rig_.size, uchar{100});
    frame.right = frame.left;
    if (index > 0) {
      frame.truth_px = cv::Mat1f(rig_.size, 8.0f);
      frame.truth_px.colRange(80, 160).setTo(20.0f);
      cv::Mat1b right_half = cv::Mat1b::zeros(rig_.size);
      right_half.colRange(80, 160).setTo(255);
      frame.regions = {{"right half", right_half}};
    }
    return frame;
  }

 private:
  StereoRig rig_;
  std::string name_ = "wall & <door>";
};

/// Returns disparity 8 everywhere; as "ours" with a variance, and invalid in the top quarter.
class ConstantMethod : public DisparityMethod {
 public:
  explicit ConstantMethod(bool own) : own_(own) {}
  void run(const MethodInput& input, MethodOutput& output) override {
    const cv::Size size = input.frame.left.size();
    output.maps.disparity_px = cv::Mat1f(size, 8.5f);
    output.ms = 10 * (input.index + 1);
    if (!own_) return;
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
    output.times = {{"matching", output.ms}};
  }

 private:
  bool own_;
};

SequenceReport evaluateWall(std::vector<Panel>* panels = nullptr) {
  const std::vector<NamedMethod> methods = {
      {kOpencvHh, [](const std::string&) { return std::make_unique<ConstantMethod>(false); }},
      {kOurs, [](const std::string&) { return std::make_unique<ConstantMethod>(true); }}};
  const WallSequence wall;
  SequenceReport report;
  report.name = wall.name();
  report.methods = {kOpencvHh, kOurs};
  const auto panel = [&](const SequenceFrame& frame, int index, size_t m,
                         const MethodOutput& output) {
    if (index == 3 && panels)
      for (const Panel& made :
           panelsOf(frame, "wall", methods[m].name, m == 0, DisparityRange{}, output))
        panels->push_back(made);
  };
  evaluateDisparity(wall, methods, PipelineParams{}, 0, nullptr, panel, report.evaluations);
  return report;
}

TEST(EvaluateDisparity, CountsAllFramesButTheFirst) {
  const SequenceReport report = evaluateWall();
  const DisparityEvaluation &opencv = report.evaluations[0], &ours = report.evaluations[1];
  EXPECT_EQ(ours.images, 3);
  EXPECT_DOUBLE_EQ(ours.mean_ms, 30);
  EXPECT_DOUBLE_EQ(opencv.score.d1_percent, 50);
  EXPECT_DOUBLE_EQ(opencv.regions.at("right half").d1_percent, 100);
  EXPECT_DOUBLE_EQ(ours.score.d1_percent, 50);
  EXPECT_DOUBLE_EQ(ours.score.d1_filled_percent, 62.5);
  EXPECT_DOUBLE_EQ(ours.score.density_percent, 75);
  EXPECT_NEAR(ours.score.rms_px, 0.5, 1e-6);
  EXPECT_NEAR(ours.measured.rms_px, 1.0, 1e-6);
  EXPECT_NEAR(ours.common_measured.rms_px, 1.0, 1e-6);
  EXPECT_DOUBLE_EQ(ours.mean_width_px, 44);
  EXPECT_DOUBLE_EQ(ours.full_search_percent, 25);
  EXPECT_DOUBLE_EQ(ours.variance.shareWithin(1), 0.5);
  EXPECT_EQ(ours.without_variance, 0);
  EXPECT_EQ(opencv.measured.frames, 0);
  ASSERT_EQ(ours.series.size(), 3u);
  EXPECT_EQ(ours.series[0].index, 1);
  ASSERT_EQ(ours.variance_by_ambiguity.bins(5).size(), 1u);
  EXPECT_EQ(ours.variance_by_disparity.bins(5).size(), 2u);
}

TEST(BinnedCalibration, BinsHoldEqualNumbers) {
  BinnedCalibration binned(1.0, 100);
  for (int key = 0; key < 100; ++key) binned.add(key + 0.5, 0.1, 1.0);
  const auto bins = binned.bins(5);
  ASSERT_EQ(bins.size(), 5u);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(bins[i].calibration.count(), 20);
    EXPECT_DOUBLE_EQ(bins[i].first, 20.0 * static_cast<double>(i));
    EXPECT_DOUBLE_EQ(bins[i].last, 20.0 * static_cast<double>(i + 1));
  }
}

TEST(DisparityReport, TablesHoldTheFigures) {
  const SequenceReport report = evaluateWall();
  const Table paper = paperTable({report});
  EXPECT_EQ(paper.rows[0], (std::vector<std::string>{"wall & <door>", "30.0", "30.0", "-", "50.00",
                                                     "50.00", "-", "-", "3"}));
  const Table accuracy = accuracyTable(report);
  EXPECT_EQ(accuracy.rows[1],
            (std::vector<std::string>{"ours", "30.0", "50.00", "62.50", "75.00", "0.500", "0.500",
                                      "1.00", "1.25", "-", "-"}));
  EXPECT_EQ(regionTable(report).rows.size(), 2u);
  EXPECT_EQ(loopTable(report).rows.size(), 1u);
  EXPECT_EQ(calibrationTable(report.evaluations[1]).rows.size(), 4u);
  EXPECT_EQ(stageTable(report).header, (std::vector<std::string>{"method", "matching", "sum"}));
}

TEST(DisparityReport, PaperTableTellsOfWidenedRangesWhereExactOnesWereAskedFor) {
  SequenceReport report = evaluateWall();
  report.methods = {kOursWidened, kOurs};
  const Table table = paperTable({report});
  EXPECT_EQ(table.header.size(), 13u);
  EXPECT_EQ(table.rows[0],
            (std::vector<std::string>{"wall & <door>", "-", "30.0", "-", "-", "50.00", "-", "-",
                                      "3", "30.0", "-", "50.00", "-"}));
}

TEST(DisparityReport, StagesOfMethodsThatHaveOthers) {
  SequenceReport report = evaluateWall();
  report.evaluations[0].stage_ms = {{"prediction", 2.0}, {"matching", 3.0}};
  const Table table = stageTable(report);
  EXPECT_EQ(table.header, (std::vector<std::string>{"method", "prediction", "matching", "sum"}));
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"opencv_hh", "2.00", "3.00", "30.00"}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"ours", "-", "30.00", "30.00"}));
}

TEST(DisparityReport, CsvLinesHaveAsManyFieldsAsTheHeader) {
  const SequenceReport report = evaluateWall();
  for (const std::string& text : {csv({report}), framesCsv({report})}) {
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    const auto commas = std::count(line.begin(), line.end(), ',');
    int count = 0;
    for (; std::getline(lines, line); ++count)
      EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    EXPECT_GE(count, 4);
  }
}

TEST(DisparityReport, PageIsSelfContained) {
  std::vector<Panel> panels;
  SequenceReport report = evaluateWall(&panels);
  // Left; disparity and errors of both; sigma, width and difference to the prediction of ours.
  ASSERT_EQ(panels.size(), 8u);
  EXPECT_EQ(panels[2].image(10, 10), cv::Vec3b(0, 200, 42));    // 0.5 px off
  EXPECT_EQ(panels[2].image(10, 100), cv::Vec3b(0, 0, 255));    // an outlier
  EXPECT_EQ(panels[4].image(10, 100), cv::Vec3b(255, 0, 255));  // invalid
  const cv::Mat3b& difference = panels[7].image;
  EXPECT_EQ(difference(10, 100), cv::Vec3b(0, 0, 0));        // not measured
  EXPECT_EQ(difference(40, 40), cv::Vec3b(128, 0, 0));       // as predicted
  EXPECT_NE(difference(60, 140), difference(40, 40));        // 2.5 px apart
  EXPECT_EQ(difference(30, 110), cv::Vec3b(255, 255, 255));  // an object's box
  report.panels = panels;
  const std::string page = htmlPage({report}, "evaluate <this>");
  EXPECT_NE(page.find("wall &amp; &lt;door&gt;"), std::string::npos);
  EXPECT_EQ(page.find("wall & <door>"), std::string::npos);
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,iVBORw0KGgo"), std::string::npos);
  EXPECT_EQ(page.find("src='http"), std::string::npos);
  EXPECT_NE(page.find("evaluate &lt;this&gt;"), std::string::npos);
}

TEST(Plot, PictureShowsItsSeries) {
  Plot plot;
  PlotSeries series;
  series.points = {{0, 0}, {10, 5}};
  plot.series = {series};
  const cv::Mat3b drawn = picture(plot);
  EXPECT_EQ(drawn.size(), plot.size);
  int blue = 0;  // the first colour of the palette
  for (const cv::Vec3b& pixel : drawn) blue += pixel == cv::Vec3b(178, 114, 0);
  EXPECT_GT(blue, 300);
  EXPECT_NE(svg(plot).find("<polyline"), std::string::npos);
  plot.series[0].points.clear();  // an empty series is not an error
  EXPECT_NO_THROW(picture(plot));
}

}  // namespace
}  // namespace predictive_stereo
