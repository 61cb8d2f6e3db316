#include "tools/command_line.h"

#include <gtest/gtest.h>

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
  EXPECT_NE(refusal({"a.bag", "--csv", "./a.bag"}).find("is an input"), std::string::npos);
  EXPECT_NE(refusal({"--csv", "a", "--set", "a"}).find("is an input"), std::string::npos);
  EXPECT_NE(refusal({"--csv", "a", "--output", "./a"}).find("are the same"), std::string::npos);
  EXPECT_EQ(refusal({"a.bag", "--csv", "a.csv", "--output", "b.bag"}), "accepted");
  EXPECT_THROW(parse({"--frames", "0"}).getInt("frames", 0, 1), UsageError);
  EXPECT_THROW(parse({"--frames", "x"}).getInt("frames", 0, 1), UsageError);
}

}  // namespace
}  // namespace predictive_stereo
