#include "evaluation/tools/tool_input.h"

#include <regex>
#include <set>

#include "nodelets/nodelet_params.h"
#include "params/yaml_params.h"
#include "tools/output_file.h"

namespace predictive_stereo {
namespace {

namespace fs = std::filesystem;

SequenceGroup groupOfOne(std::unique_ptr<Sequence> sequence) {
  SequenceGroup group;
  group.name = sequence->name();
  group.sequences.push_back(std::move(sequence));
  return group;
}

// Labels, images and rows of reports are found by the name.
void requireDifferentNames(const std::vector<SequenceGroup>& groups) {
  std::set<std::string> names;
  for (const SequenceGroup& group : groups)
    for (const auto& sequence : group.sequences)
      if (!names.insert(sequence->name()).second)
        throw UsageError("two inputs are named " + sequence->name() +
                         ": rename one of the files, or leave one out");
}

}  // namespace

std::vector<DriveArgument> driveArguments(const std::vector<std::string>& positional) {
  std::vector<DriveArgument> drives;
  std::string date_dir;
  bool date_used = true;
  for (const std::string& argument : positional) {
    const fs::path path =
        fs::path(argument).has_filename() ? fs::path(argument) : fs::path(argument).parent_path();
    if (date_dir.empty() && fs::is_regular_file(path / ".." / "calib_cam_to_cam.txt"))
      throw UsageError(argument + " is a drive: give the folder of its day before it, as " +
                       path.parent_path().string() + " " + path.filename().string());
    if (date_dir.empty() || fs::is_regular_file(fs::path(argument) / "calib_cam_to_cam.txt")) {
      if (!date_used) break;
      date_dir = argument;
      date_used = false;
    } else {
      drives.push_back({date_dir, argument});
      date_used = true;
    }
  }
  if (!date_used) throw UsageError("give a drive after the folder of the day, " + date_dir);
  return drives;
}

std::vector<SequenceGroup> openSequences(const CommandLine& command_line,
                                         const OpenFile& open_file) {
  std::vector<SequenceGroup> groups;
  std::vector<std::string> folders;
  for (const std::string& argument : command_line.positional()) {
    if (open_file && (fs::is_regular_file(argument) || fs::path(argument).extension() == ".bag"))
      groups.push_back(groupOfOne(open_file(argument)));
    else
      folders.push_back(argument);
  }
  for (const DriveArgument& drive : driveArguments(folders))
    groups.push_back(groupOfOne(kittiDriveSequence(drive.date_dir, drive.drive)));
  if (command_line.has("kitti2012")) {
    const std::string training_dir = command_line.get("kitti2012");
    SequenceGroup group;
    for (const std::string& scene : listKittiScenes(KittiStereo::k2012, training_dir))
      group.sequences.push_back(kittiScene(KittiStereo::k2012, training_dir, scene));
    group.name = "KITTI 2012 (" + std::to_string(group.sequences.size()) + ")";
    groups.push_back(std::move(group));
  }
  for (const std::string& scene : command_line.all("street")) {
    StreetParams params;
    params.scene = scene;
    params.frames = command_line.getInt("street-frames", 40, 2);
    groups.push_back(groupOfOne(streetSequence(params)));
  }
  if (groups.empty() && !command_line.has("kitti2015"))
    throw UsageError("nothing to evaluate: name a drive (DATE_DIR DRIVE) or --street SCENE");
  requireDifferentNames(groups);
  return groups;
}

PipelineParams readParams(const CommandLine& command_line) {
  AllNodeletParams params;
  setFromOptions(command_line, params);
  if (command_line.has("scheme"))
    ParamTable(params).setAssignment("moving_objects/scheme=" + command_line.get("scheme"));
  PipelineParams pipeline;
  pipeline.max_gap = params.disparity.max_gap;
  pipeline.ego_motion = params.ego_motion.ego_motion;
  pipeline.disparity = params.disparity.disparity;
  pipeline.detection = params.moving_objects.detection;
  return pipeline;
}

std::string fileName(const std::string& name) {
  return std::regex_replace(name, std::regex("[^A-Za-z0-9]"), "_");
}

void writeCsv(const fs::path& path, const std::string& csv, const std::string& frames_csv) {
  writeText(path, csv);
  writeText(framesFile(path), frames_csv);
}

}  // namespace predictive_stereo
