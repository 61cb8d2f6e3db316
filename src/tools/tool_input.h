/// What the evaluating tools have in common: sequences and parameters by command line.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "evaluation/sequence.h"
#include "predictive_stereo/pipeline.h"
#include "tools/command_line.h"

namespace predictive_stereo {

/// A drive of KITTI's raw recordings, as named on the command line.
struct DriveArgument {
  std::string date_dir, drive;
};

/// Positional arguments DATE_DIR DRIVE [DRIVE ...] [DATE_DIR DRIVE ...]: a folder with
/// calib_cam_to_cam.txt begins another day.
/// @throws UsageError for a day without drives, or a drive without its day.
std::vector<DriveArgument> driveArguments(const std::vector<std::string>& positional);

/// Sequences that are counted as one.
struct SequenceGroup {
  std::string name;
  std::vector<std::unique_ptr<Sequence>> sequences;
};

using OpenFile = std::function<std::unique_ptr<Sequence>(const std::string& path)>;

/// Positional arguments DATE_DIR DRIVE [DRIVE ...] [DATE_DIR DRIVE ...] and the options
/// --kitti2012, --street, --street-frames, --shift-right.
/// @param open_file  opens positional arguments that are files; none: files are no sequences.
/// @throws UsageError where nothing is named; std::runtime_error where it cannot be read.
std::vector<SequenceGroup> openSequences(const CommandLine& command_line,
                                         const OpenFile& open_file = {});

/// The defaults, changed by the options --config, --set and --scheme. Files and names are those of
/// the nodelets (config/*.yaml), so that one file serves robot, replay and measurement.
PipelineParams readParams(const CommandLine& command_line);
/// All of them as yaml, with their limits.
std::string listParams(const CommandLine& command_line);

/// Option --threads.
void useThreads(const CommandLine& command_line);

/// A name as part of a file's name: letters, digits and underscores stay.
std::string fileName(const std::string& name);

/// The file beside `csv` for the figures of each frame: NAME_frames.csv.
std::filesystem::path framesFile(const std::filesystem::path& csv);

}  // namespace predictive_stereo
