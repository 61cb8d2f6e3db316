/// Runs the tool on small streets, and with wrong inputs.
#include <filesystem>
#include <fstream>

#include "tool_fixture.h"

namespace predictive_stereo {
namespace {

constexpr char kHeader[] =
    "frame,track,class,x1,y1,x2,y2,distance_m,truncated,occluded,motion,hard\n";

class EvaluateDetection : public ToolTest {
 protected:
  Result evaluate(const std::string& arguments) const {
    return run(std::string(EVALUATE_DETECTION) + " " + arguments);
  }
  void expectRefused(const std::string& arguments, const std::string& message) const {
    const Result result = evaluate(arguments);
    EXPECT_NE(result.status, 0) << arguments;
    EXPECT_NE(result.errors.find(message), std::string::npos) << arguments << "\n" << result.errors;
    EXPECT_EQ(result.out, "") << arguments;
  }
  // Five frames of a car ahead.
  std::string bag() const {
    const std::string path = files_.path("small.bag");
    if (!std::filesystem::exists(path)) {
      const std::string options = " --scene leader --frames 5 --size 496x160";
      EXPECT_EQ(run(std::string(STREET_TO_BAG) + " " + path + options).status, 0);
    }
    return path;
  }
};

// The lines of the first table after its title, which has a name and a time.
std::string table(const std::string& out) {
  const size_t begin = out.find('\n');
  return out.substr(begin, out.find("\n\n") - begin);
}

TEST_F(EvaluateDetection, ScoresABagOfTheStreetAgainstItsTruth) {
  const Result result =
      evaluate(bag() + " --csv " + files_.path("new/a.csv") + " --report " + files_.path("page"));
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(result.out.find("small (detection"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("5 frames"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("small: slowest detectable speeds"), std::string::npos) << result.out;

  const std::string csv = text("new/a.csv");
  EXPECT_EQ(csv.find("sequence,group,frames,demanded,found,false_boxes,recall"), 0u);
  // The car ahead, from the third frame on.
  EXPECT_NE(csv.find("\nsmall,all,5,3,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\nsmall,away,5,3,"), std::string::npos) << csv;
  const std::string frames = text("new/a_frames.csv");
  EXPECT_NE(frames.find("\nsmall,2,label,"), std::string::npos) << frames;

  const std::string page = text("page/report.yaml");
  EXPECT_NE(page.find("\"table\": \"small (detection"), std::string::npos) << page;
  EXPECT_NE(page.find("--report"), std::string::npos) << "the command that made it";
  for (int i = 0; i < 5; ++i)
    EXPECT_TRUE(std::filesystem::exists(
        files_.path("page/frames/small_00000" + std::to_string(i) + ".png")));
}

TEST_F(EvaluateDetection, LabelsTakeThePlaceOfTheTruth) {
  const std::string labels = files_.write("labels.csv", std::string(kHeader) +
                                                            "1,1,car,10,10,60,60,20,0,0,away,0\n"
                                                            "2,1,car,10,10,60,60,20,0,0,away,0\n"
                                                            "3,1,car,10,10,60,60,20,0,0,away,0\n"
                                                            "4,1,car,10,10,60,60,20,0,0,away,1\n");
  const Result result = evaluate(bag() + " --labels " + labels + " --csv " + files_.path("a.csv"));
  ASSERT_EQ(result.status, 0) << result.errors;
  EXPECT_NE(text("a.csv").find("\nsmall,all,5,1,0,"), std::string::npos) << text("a.csv");
}

TEST_F(EvaluateDetection, ScoresWhatReplayHasWritten) {
  const std::string replayed = files_.path("replayed.bag");
  ASSERT_EQ(run(std::string(REPLAY) + " --bag " + bag() + " --output " + replayed +
                " --topics moving_objects")
                .status,
            0);
  const Result recorded = evaluate(bag() + " --objects " + replayed);
  ASSERT_EQ(recorded.status, 0) << recorded.errors;
  EXPECT_EQ(table(recorded.out), table(evaluate(bag()).out));
  const KittiFixture kitti;
  expectRefused(kitti.path() + " " + KittiFixture::kDrive + " --objects " + replayed +
                    " --labels " + files_.write("none.csv", kHeader),
                "has no message with a stamp of");
}

TEST_F(EvaluateDetection, ABagAndItsStreetAreTheSame) {
  const std::string path = files_.path("street.bag");
  ASSERT_EQ(run(std::string(STREET_TO_BAG) + " " + path + " --scene street --frames 4").status, 0);
  const Result from_bag = evaluate(path + " --csv " + files_.path("bag.csv"));
  const Result from_street =
      evaluate("--street street --street-frames 4 --csv " + files_.path("street.csv"));
  ASSERT_EQ(from_bag.status, 0) << from_bag.errors;
  ASSERT_EQ(from_street.status, 0) << from_street.errors;
  EXPECT_EQ(table(from_bag.out), table(from_street.out));
}

TEST_F(EvaluateDetection, NamesWhatIsWrongAndTheCure) {
  const KittiFixture kitti;
  const std::string drive = kitti.path() + " " + KittiFixture::kDrive;
  expectRefused("", "nothing to evaluate");
  expectRefused("no/such.bag", "no/such.bag: cannot be read as a bag");
  expectRefused(files_.write("not_a.bag", "hello"), "cannot be read as a bag");
  expectRefused(drive, "give --labels");
  expectRefused(kitti.path() + "/" + KittiFixture::kDrive, "give the folder of its day before it");
  expectRefused(drive + " --labels " + files_.path("none.csv"), "none.csv: cannot be read");
  expectRefused(drive + " --labels " + files_.write("a.csv", "x,y\n"), "first line must be");
  expectRefused(
      drive + " --labels " +
          files_.write("b.csv", std::string(kHeader) + "1,1,car,60,10,10,60,20,0,0,away,0\n"),
      "line 2");
  expectRefused(bag() + " " + drive + " --labels " + files_.write("c.csv", kHeader),
                "must be a folder");
  const std::string own = files_.write(std::string(KittiFixture::kDrive) + ".csv", kHeader);
  expectRefused(drive + " --labels " + files_.path("") + " --csv " + own, "is an input");
  expectRefused(bag() + " --objects " + bag(), "0 topics .../moving_objects");
  const std::string twin = files_.write("twin/small.bag", "");
  std::filesystem::copy_file(bag(), twin, std::filesystem::copy_options::overwrite_existing);
  expectRefused(bag() + " " + twin, "two inputs are named small: rename one of the files");
  expectRefused(bag() + " --scheme best", "default | paper");
  expectRefused(bag() + " --left /a", "give --left and --right together");
  expectRefused(bag() + " --camera /nobody", "/nobody/left/image_rect");
  expectRefused("--street moon", "there is no such scene");
  expectRefused(bag() + " --lables x", "did you mean --labels?");
  EXPECT_EQ(evaluate("--help").status, 0);
  EXPECT_EQ(text("stdout").find("Usage: evaluate_detection BAG"), 0u);
}

}  // namespace
}  // namespace predictive_stereo
