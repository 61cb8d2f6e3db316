#include "tools/command_line.h"

#include <gtest/gtest.h>

#include "tools/kitti_fixture.h"

namespace predictive_stereo {
namespace {

CommandLine parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "tool");
  return {static_cast<int>(arguments.size()), arguments.data(),
          "tool [--frames N]\n  --set NAME=VALUE  see other --help\n  --quick  without a value\n"
          "--output FILE --csv FILE"};
}

std::string refusal(const std::vector<const char*>& arguments) {
  try {
    parse(arguments);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CommandLine, ReadsOptionsAnywhere) {
  const CommandLine line =
      parse({"a", "--frames", "7", "--set=x=1", "b", "--quick", "--set", "y=2"});
  EXPECT_EQ(line.positional(), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(line.getInt("frames", 0, 1), 7);
  EXPECT_EQ(line.all("set"), (std::vector<std::string>{"x=1", "y=2"}));
  EXPECT_TRUE(line.has("quick"));
  EXPECT_EQ(line.get("missing", "otherwise"), "otherwise");
  EXPECT_EQ(line.command(), "tool a --frames 7 --set=x=1 b --quick --set y=2");
  EXPECT_TRUE(parse({"-h"}).has("help"));
}

TEST(CommandLine, RefusesWhatItDoesNotKnow) {
  EXPECT_EQ(refusal({"--frame", "7"}), "unknown option --frame; did you mean --frames?");
  EXPECT_EQ(refusal({"--frames"}), "option --frames needs a value");
  EXPECT_NE(refusal({"--quick=1"}), "accepted");
  EXPECT_THROW(parse({"--frames", "0"}).getInt("frames", 0, 1), UsageError);
  EXPECT_THROW(parse({"--frames", "x"}).getInt("frames", 0, 1), UsageError);
}

TEST(CommandLine, KeepsItsInputs) {
  const TemporaryDirectory folder;
  const std::string bag = folder.write("a.bag", "bag"), labels = folder.write("a_frames.csv", "x"),
                    csv = folder.path("a.csv"), again = folder.path("./a.bag"),
                    name = "--set=" + bag;
  const auto isKept = [](const std::vector<const char*>& arguments) {
    return refusal(arguments).find("is an input, which would be lost") != std::string::npos;
  };
  EXPECT_TRUE(isKept({bag.c_str(), "--csv", again.c_str()}));
  EXPECT_TRUE(isKept({name.c_str(), "--output", again.c_str()}));
  EXPECT_TRUE(isKept({labels.c_str(), "--csv", csv.c_str()})) << "the file of its frames";
  EXPECT_EQ(refusal({bag.c_str(), "--quick", "--csv", csv.c_str(), "--output", "b"}), "accepted");
  const std::string dir = folder.path("");
  EXPECT_EQ(refusal({dir.c_str(), "--output", dir.c_str()}), "accepted") << "a folder";
  EXPECT_EQ(refusal({"no_file", "--csv", "no_file"}), "accepted");
  EXPECT_EQ(refusal({"", "--quick", "--csv", "", "--output", ""}), "accepted");
  EXPECT_NE(refusal({"--csv", "a", "--output", "./a"}).find("are the same"), std::string::npos);
}

}  // namespace
}  // namespace predictive_stereo
