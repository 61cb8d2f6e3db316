// Every installed yaml file can be loaded. The file with all parameters has the default values.
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "nodelets/nodelet_params.h"
#include "nodelets/pipeline_processor.h"
#include "params/param_texts.h"
#include "params/yaml_params.h"

namespace predictive_stereo {
namespace {

const std::filesystem::path kFolder = CONFIG_FOLDER;

std::vector<std::filesystem::path> files() {
  std::vector<std::filesystem::path> result;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder))
    if (entry.path().extension() == ".yaml") result.push_back(entry.path());
  return result;
}

void collectNames(const YAML::Node& node, const std::string& prefix, std::set<std::string>& names) {
  for (const auto& entry : node) {
    const std::string name = prefix + entry.first.as<std::string>();
    if (entry.second.IsMap())
      collectNames(entry.second, name + "/", names);
    else
      names.insert(name);
  }
}

TEST(ConfigFiles, AreThere) { EXPECT_GE(files().size(), 4u); }

TEST(ConfigFiles, SetKnownParametersToAllowedValuesThatWorkTogether) {
  for (const auto& path : files()) {
    AllNodeletParams params;
    ParamTable table(params);
    EXPECT_NO_THROW(setFromYamlFile(path.string(), table)) << path;
    EXPECT_NO_THROW(PipelineProcessor{params}) << path;
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
  std::set<std::string> names;
  collectNames(YAML::LoadFile(path), "", names);
  AllNodeletParams defaults, loaded;
  const ParamTable default_table(defaults);
  ParamTable loaded_table(loaded);
  setFromYamlFile(path, loaded_table);
  for (size_t i = 0; i < default_table.entries().size(); ++i) {
    const ParamTable::Entry& entry = default_table.entries()[i];
    EXPECT_TRUE(names.count(entry.name)) << path << ": add " << entry.name << ": " << entry.get();
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
  EXPECT_EQ(paramTexts().at("moving_objects/range/min_disparity"),
            paramTexts().at("disparity/matcher/range/min_disparity"));
}

}  // namespace
}  // namespace predictive_stereo
