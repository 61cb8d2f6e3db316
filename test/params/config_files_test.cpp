// Every installed yaml file can be loaded. The file with all parameters has the default values,
// those of the paper's method have the paper's.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "nodelets/nodelet_params.h"
#include "params/yaml_params.h"
#include "tools/pipeline_processor.h"

namespace predictive_stereo {
namespace {

const std::filesystem::path kFolder = CONFIG_FOLDER;

std::vector<std::filesystem::path> files() {
  std::vector<std::filesystem::path> result;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder))
    if (entry.path().extension() == ".yaml") result.push_back(entry.path());
  return result;
}

// What a file says of each parameter.
using Values = std::map<std::string, std::string>;

void collect(const YAML::Node& node, const std::string& prefix, Values& values) {
  for (const auto& entry : node) {
    const std::string name = prefix + entry.first.as<std::string>();
    if (entry.second.IsMap())
      collect(entry.second, name + "/", values);
    else
      values[name] = entry.second.as<std::string>();
  }
}

TEST(ConfigFiles, AreThere) { EXPECT_GE(files().size(), 4u); }

TEST(ConfigFiles, SetKnownParametersToAllowedValuesThatWorkTogether) {
  for (const auto& path : files()) {
    AllNodeletParams params;
    ParamTable table(params);
    EXPECT_NO_THROW(setFromYamlFile(path.string(), table)) << path;
    tf2::BufferCore tf;
    EXPECT_NO_THROW(PipelineProcessor(params, tf)) << path;
  }
}

// noise_kitti.yaml documents the origin of the default noise and variance, so it equals the
// defaults.
TEST(ConfigFiles, ChangeSomethingWhereTheyAreNotTheDefaults) {
  for (const auto& path : files()) {
    AllNodeletParams changed, defaults;
    ParamTable changed_table(changed);
    setFromYamlFile(path.string(), changed_table);
    const bool same =
        path.filename() == "predictive_stereo.yaml" || path.filename() == "noise_kitti.yaml";
    EXPECT_EQ(toYaml(changed_table) == toYaml(ParamTable(defaults)), same) << path;
  }
}

TEST(ConfigFiles, TheAnnotatedOneHoldsEveryParameterAtItsDefault) {
  const std::string path = (kFolder / "predictive_stereo.yaml").string();
  Values written;
  collect(YAML::LoadFile(path), "", written);
  AllNodeletParams defaults, loaded;
  const ParamTable default_table(defaults);
  ParamTable loaded_table(loaded);
  setFromYamlFile(path, loaded_table);
  for (size_t i = 0; i < default_table.entries().size(); ++i) {
    const ParamTable::Entry& entry = default_table.entries()[i];
    EXPECT_TRUE(written.count(entry.name)) << path << ": add " << entry.name << ": " << entry.get();
    EXPECT_EQ(loaded_table.entries()[i].get(), entry.get()) << path << ": " << entry.name;
  }
}

TEST(ConfigFiles, TheAnnotatedOneTellsTheLimitsOfEveryNumber) {
  AllNodeletParams defaults;
  const ParamTable table(defaults);
  for (const ParamTable::Entry& entry : table.entries()) {
    ASSERT_TRUE(paramTexts().count(entry.name)) << entry.name;
    const std::string& text = paramTexts().at(entry.name);
    const bool is_choice = entry.type == ParamTable::Type::kChoice;
    if (!is_choice && entry.smallest == entry.largest) continue;
    EXPECT_NE(text.find(entry.limits), std::string::npos)
        << entry.name << " has the limits " << entry.limits << ", its comment is: " << text;
  }
}

TEST(ConfigFiles, CommentsBelongToTheirParameters) {
  EXPECT_EQ(paramTexts().at("disparity/matcher/p1"),
            "penalty of a disparity change by 1 (eq. 1) [1, 200]");
  // Of several lines above the parameter.
  EXPECT_EQ(paramTexts().at("ego_motion/guess_frame").find("Without use_imu"), 0u);
}

// q and r are results of estimate_noise --all-errors on drive 0002, without and with row alignment.
Values paper(const std::string& align, const std::string& q_px2, const std::string& r_px2) {
  return {
      {"disparity/matcher/range/min_disparity", "0"},
      {"disparity/matcher/range/count", "128"},
      {"disparity/matcher/census", "5x5"},
      {"disparity/matcher/paths", "straight_4"},
      {"disparity/matcher/p1", "6"},
      {"disparity/matcher/p2", "65"},
      {"disparity/matcher/edge_step", "0"},
      {"disparity/matcher/left_right_tolerance_px", "1"},
      {"disparity/matcher/exact_ranges", "true"},
      {"disparity/row_alignment/enabled", align},
      {"disparity/prediction/process_noise_px2", q_px2},
      {"disparity/prediction/use_motion_covariance", "false"},
      {"disparity/prediction/edge_jump_px", "3"},
      {"disparity/prediction/edge_margin_px", "2"},
      {"disparity/prediction/reject_near_edges", "true"},
      {"disparity/search/scheme", "paper"},
      {"disparity/search/margin_px", "0"},
      {"disparity/correction/measurement_noise_px2", r_px2},
      {"disparity/correction/gate_sigma", "0"},
      {"disparity/correction/max_missed_frames", "0"},
      {"disparity/variance/max_sigma_px", "0"},
      {"disparity/min_support", "0"},
      {"disparity/min_region_px", "0"},
      {"disparity/max_ambiguity", "1"},
      {"disparity/max_hole_px", "0"},
      {"disparity/use_moving_mask", "false"},
      {"disparity/correct_columns", "false"},
      {"ego_motion/row_alignment/enabled", align},
      {"ego_motion/use_moving_mask", "false"},
      {"moving_objects/scheme", "paper"},
      {"moving_objects/paper/smallest_window_width_px", "20"},
      {"moving_objects/paper/smallest_window_height_px", "20"},
      {"moving_objects/paper/largest_window_width_px", "75"},
      {"moving_objects/paper/largest_window_height_px", "50"},
      {"moving_objects/paper/window_sizes", "4"},
      {"moving_objects/paper/step_px", "5"},
      {"moving_objects/paper/skipped_top", "0.3333333333333333"},
      {"moving_objects/paper/min_mean_difference_px", "1.5"},
      {"moving_objects/paper/max_difference_px", "256"},
      {"moving_objects/paper/min_merge_iou", "0.01"},
      {"moving_objects/paper/min_width_px", "25"},
      {"moving_objects/paper/min_height_px", "25"},
  };
}

// The values of a file are as expected and reach the parameters; all others are defaults.
void expectFile(const std::string& name, const Values& expected) {
  const std::string path = (kFolder / name).string();
  Values written;
  collect(YAML::LoadFile(path), "", written);
  EXPECT_EQ(written, expected) << name;

  AllNodeletParams params, defaults;
  ParamTable table(params), default_table(defaults);
  setFromYamlFile(path, table);
  for (size_t i = 0; i < table.entries().size(); ++i) {
    const ParamTable::Entry& entry = table.entries()[i];
    const auto wanted = expected.find(entry.name);
    EXPECT_EQ(entry.get(),
              wanted == expected.end() ? default_table.entries()[i].get() : wanted->second)
        << name << ": " << entry.name;
  }
}

TEST(PaperConfig, IsThePapersMethod) { expectFile("paper.yaml", paper("false", "0.449", "19.3")); }

TEST(PaperConfig, AlignedDiffersByRowAlignmentAndItsNoise) {
  expectFile("paper_aligned.yaml", paper("true", "0.449", "3.23"));
}

}  // namespace
}  // namespace predictive_stereo
