/// Runs the tool on a short street.
#include "tool_fixture.h"

namespace predictive_stereo {
namespace {

class EvaluateOdometry : public ToolTest {};

TEST_F(EvaluateOdometry, WritesFiguresOfSequences) {
  const Result result =
      run(std::string(EVALUATE_ODOMETRY) + " --street straight --street-frames 4 --csv " +
          files_.path("new/a.csv"));
  ASSERT_EQ(result.status, 0) << result.errors;
  const std::string figures = text("new/a.csv");
  EXPECT_EQ(std::count(figures.begin(), figures.end(), '\n'), 2) << figures;
  const std::string header = figures.substr(0, figures.find('\n'));
  const std::string line = figures.substr(header.size() + 1);
  EXPECT_EQ(std::count(line.begin(), line.end(), ','),
            std::count(header.begin(), header.end(), ','))
      << figures;
  EXPECT_NE(line.find("straight,3,"), std::string::npos) << figures;
}

TEST_F(EvaluateOdometry, APathWithoutALengthHasNoErrorOfIt) {
  const Result result =
      run(std::string(EVALUATE_ODOMETRY) + " --street people_standing --street-frames 3 --csv " +
          files_.path("a.csv"));
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.out.find("of the true one"), std::string::npos) << result.out;
  EXPECT_NE(text("a.csv").find("people_standing,2,0,"), std::string::npos) << text("a.csv");
  for (const std::string& out : {result.out, text("a.csv")})
    EXPECT_EQ(out.find("inf"), std::string::npos) << out;
}

TEST_F(EvaluateOdometry, NamesWhatCannotBeWritten) {
  files_.write("file", "");
  const Result result =
      run(std::string(EVALUATE_ODOMETRY) + " --street straight --street-frames 2 --csv " +
          files_.path("file/a.csv"));
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.errors.find("/file: cannot be written: "), std::string::npos) << result.errors;
}

}  // namespace
}  // namespace predictive_stereo
