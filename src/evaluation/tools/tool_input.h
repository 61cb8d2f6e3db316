/// Common command line of the evaluation tools: sequences and parameters.
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

/// A drive of KITTI's raw recordings on the command line.
struct DriveArgument {
  std::string date_dir, drive;
};

/// Parses the positional arguments DATE_DIR DRIVE [DRIVE ...] [DATE_DIR DRIVE ...]. A folder with
/// calib_cam_to_cam.txt is a DATE_DIR.
/// @throws UsageError for a DATE_DIR without drives, or a drive without a DATE_DIR.
std::vector<DriveArgument> driveArguments(const std::vector<std::string>& positional);

/// Sequences with common results.
struct SequenceGroup {
  std::string name;
  std::vector<std::unique_ptr<Sequence>> sequences;
};

using OpenFile = std::function<std::unique_ptr<Sequence>(const std::string& path)>;

/// Positional arguments DATE_DIR DRIVE [DRIVE ...] [DATE_DIR DRIVE ...] and the options
/// of docs/help/common/sequences.txt.
/// @param open_file  opens positional arguments that are files; empty: files are not allowed.
/// @throws UsageError if there is no sequence, or two have one name.
/// @throws std::runtime_error if a sequence cannot be read.
std::vector<SequenceGroup> openSequences(const CommandLine& command_line,
                                         const OpenFile& open_file = {});

/// The default parameters, changed by the options --config, --set and --scheme. Files and names are
/// those of the nodelets (config/*.yaml), so robot, replay and evaluation can use the same file.
PipelineParams readParams(const CommandLine& command_line);

/// The name with all characters except letters and digits replaced by underscores.
std::string fileName(const std::string& name);

/// Writes the figures to `path`, and those of each frame to NAME_frames.csv beside it.
void writeCsv(const std::filesystem::path& path, const std::string& csv,
              const std::string& frames_csv);

}  // namespace predictive_stereo
