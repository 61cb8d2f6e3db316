#include "params/param_table.h"

#include <gtest/gtest.h>

#include <chrono>

#include "params/yaml_params.h"

namespace predictive_stereo {
namespace {

enum class Colour { kRed, kGreen };

struct Inner {
  int count = 4;
  Colour colour = Colour::kGreen;
  template <class Visitor>
  void visit(Visitor&& v) {
    v("count", count, 1, 9);
    v("colour", colour, Choices<Colour>{{"red", Colour::kRed}, {"green", Colour::kGreen}});
  }
};

struct Outer {
  double gate_px = 0.1;
  bool enabled = false;
  std::string frame = "odom: x";
  Inner inner;
  Inner other;
  template <class Visitor>
  void visit(Visitor&& v) {
    v("gate_px", gate_px, 0.0, 2.5);
    v("inner", inner);
    v("other", other);
    v("enabled", enabled);
    v("frame", frame);
  }
};

/// Message of the std::invalid_argument that `action` throws.
template <class Action>
std::string refusal(Action&& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ParamTable, ALongNameIsComparedAtOnce) {
  const std::string name(30'000'000, 'a');
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(nearestName(name, {std::string(80, 'b'), std::string(90, 'a')}), std::string(90, 'a'));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(3));
}

TEST(ParamTable, SetsNestedValues) {
  Outer params;
  ParamTable table(params);
  table.setAssignment("inner/count=7");
  table.setAssignment("inner/colour=red");
  table.setAssignment("gate_px=1e-3");
  table.setAssignment("enabled=true");
  table.setAssignment("frame=a=b");
  EXPECT_EQ(params.inner.count, 7);
  EXPECT_EQ(params.other.count, 4);
  EXPECT_EQ(params.inner.colour, Colour::kRed);
  EXPECT_EQ(params.gate_px, 1e-3);
  EXPECT_TRUE(params.enabled);
  EXPECT_EQ(params.frame, "a=b");
}

TEST(ParamTable, RefusesAndNames) {
  Outer params;
  ParamTable table(params, "disparity/");
  EXPECT_EQ(refusal([&] { table.set("disparity/inner/cuont", "3"); }),
            "unknown parameter disparity/inner/cuont; did you mean disparity/inner/count?");
  EXPECT_EQ(refusal([&] { table.set("disparity/inner/count", "12"); }),
            "disparity/inner/count = 12: must be within [1, 9]");
  EXPECT_EQ(refusal([&] { table.set("disparity/inner/count", "3.5"); }),
            "disparity/inner/count = 3.5: must be a whole number");
  EXPECT_EQ(refusal([&] { table.set("disparity/inner/colour", "blue"); }),
            "disparity/inner/colour = blue: must be one of red | green");
  EXPECT_EQ(refusal([&] { table.set("disparity/enabled", "maybe"); }),
            "disparity/enabled = maybe: must be true or false");
  for (const char* text : {"nan", "", "1x", " 1", "inf"})
    EXPECT_NE(refusal([&] { table.set("disparity/gate_px", text); }), "accepted") << text;
  EXPECT_NE(refusal([&] { table.setAssignment("disparity/gate_px"); }), "accepted");
  EXPECT_EQ(params.inner.count, 4);
}

TEST(YamlParams, WritesWhatItReads) {
  Outer params;
  params.gate_px = 1.0 / 3;
  params.inner.count = 2;
  params.enabled = true;
  const std::string yaml = toYaml(ParamTable(params));
  Outer read;
  ParamTable table(read);
  setFromYaml(yaml, "text", table);
  EXPECT_EQ(toYaml(table), yaml);
  EXPECT_EQ(read.gate_px, params.gate_px);
  EXPECT_EQ(read.inner.count, 2);
  EXPECT_EQ(read.frame, "odom: x");
  EXPECT_NE(yaml.find("inner:\n  count: 2  # [1, 9]\n"), std::string::npos) << yaml;
}

TEST(YamlParams, LeavesWhatATextDoesNotName) {
  Outer params;
  ParamTable table(params);
  setFromYaml("# comment\ninner: {count: 3, colour: red}\n", "text", table);
  setFromYaml("", "text", table);
  EXPECT_EQ(params.inner.count, 3);
}

TEST(YamlParams, ErrorsNameFileAndLine) {
  Outer params;
  ParamTable table(params);
  EXPECT_EQ(refusal([&] { setFromYaml("gate_px: 1\ninner:\n  conut: 3\n", "a.yaml", table); }),
            "a.yaml:3: unknown parameter inner/conut; did you mean inner/count?");
  EXPECT_EQ(refusal([&] { setFromYaml("gate_px: 3\n", "a.yaml", table); }),
            "a.yaml:1: gate_px = 3: must be within [0, 2.5]");
  EXPECT_NE(refusal([&] { setFromYaml("gate_px: [1, 2]\n", "a.yaml", table); }), "accepted");
  EXPECT_NE(refusal([&] { setFromYaml("just text", "a.yaml", table); }), "accepted");
  EXPECT_NE(refusal([&] { setFromYaml("a: b: c", "a.yaml", table); }).find("not valid yaml"),
            std::string::npos);
  EXPECT_THROW(setFromYamlFile("/no/such/file.yaml", table), std::runtime_error);
}

TEST(ParamTable, tells_types_limits_and_choices) {
  Outer outer;
  ParamTable table(outer);
  const auto entry = [&](const std::string& name) {
    for (const ParamTable::Entry& candidate : table.entries())
      if (candidate.name == name) return candidate;
    throw std::logic_error(name);
  };
  EXPECT_EQ(entry("gate_px").type, ParamTable::Type::kDouble);
  EXPECT_EQ(entry("gate_px").largest, 2.5);
  EXPECT_EQ(entry("inner/count").type, ParamTable::Type::kInt);
  EXPECT_EQ(entry("inner/count").smallest, 1);
  EXPECT_EQ(entry("inner/count").largest, 9);
  EXPECT_EQ(entry("inner/colour").type, ParamTable::Type::kChoice);
  EXPECT_EQ(entry("inner/colour").choices, (std::vector<std::string>{"red", "green"}));
  EXPECT_EQ(entry("enabled").type, ParamTable::Type::kBool);
  EXPECT_EQ(entry("frame").type, ParamTable::Type::kText);
}

TEST(ParamTable, parameters_can_be_taken_off) {
  Outer outer;
  ParamTable table(outer);
  EXPECT_EQ(table.entry("inner/colour").get(), "green");
  table.remove("inner/");
  EXPECT_FALSE(table.has("inner/count"));
  EXPECT_TRUE(table.has("other/count"));
  EXPECT_THROW(table.entry("inner/colour"), std::invalid_argument);
}

}  // namespace
}  // namespace predictive_stereo
