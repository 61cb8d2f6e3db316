#pragma once

#include <csignal>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "params/yaml_params.h"

namespace predictive_stereo {

/// Wrong use of a tool: the message is followed by a hint to --help.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Options and positional arguments of a tool: "--name value", "--name=value" and "--flag".
class CommandLine {
 public:
  /// @param help  the tool's help text: the options are those that it names. One has a value if a
  ///   word with a capital follows, "--name VALUE"; it may be repeated. "--help" is always one.
  /// @throws UsageError for unknown options (it suggests the nearest known one), missing values,
  ///   and if --output or --csv would overwrite a file that another argument names.
  CommandLine(int argc, const char* const* argv, const std::string& help);

  bool has(const std::string& name) const { return values_.count(name) > 0; }
  /// The last value of the option; `otherwise` without the option.
  std::string get(const std::string& name, const std::string& otherwise = "") const;
  std::vector<std::string> all(const std::string& name) const;
  /// @throws UsageError for a value that is not a whole number, or is less than `smallest`.
  int getInt(const std::string& name, int otherwise, int smallest) const;
  /// @throws UsageError for a value that is not a number.
  double getDouble(const std::string& name, double otherwise) const;
  const std::vector<std::string>& positional() const { return positional_; }
  /// @throws UsageError if --output or --csv would overwrite this file.
  void requireKept(const std::string& input) const;
  /// The command line, with arguments separated by blanks.
  const std::string& command() const { return command_; }

 private:
  std::map<std::string, std::vector<std::string>> values_;
  std::vector<std::string> positional_;
  std::string command_;
};

/// The file beside that of --csv which tools with figures of each frame write.
std::filesystem::path framesFile(const std::filesystem::path& csv);

/// Sets parameters by the options --config (a yaml file) and then --set (NAME=VALUE).
template <class Params>
void setFromOptions(const CommandLine& line, Params& params) {
  ParamTable table(params);
  if (line.has("config")) setFromYamlFile(line.get("config"), table);
  for (const std::string& assignment : line.all("set")) table.setAssignment(assignment);
}

/// The help of this program, docs/help/NAME.txt; see predictive_stereo_tool in cmake/targets.cmake.
extern const char kToolHelp[];

/// The body of this program, which its source file defines.
/// @returns the exit status.
int runProgram(const CommandLine& line);

/// Runs the body of a tool, with as many threads as the option --threads says.
/// @param help  printed for --help; see CommandLine. Exceptions are printed to stderr as
///   "tool: message".
/// @returns the exit status: the body's; 1 after an exception, or if standard output cannot be
///   written; 2 after a UsageError.
int runTool(int argc, char** argv, const std::string& help, int (*body)(const CommandLine&));

inline volatile std::sig_atomic_t interrupted = 0;

/// After this call SIGINT, SIGTERM and SIGHUP do not terminate the process. Instead,
/// throwIfInterrupted() throws, so that destructors remove incomplete files.
inline void catchInterruptions() {
  const auto interrupt = [](int) { interrupted = 1; };
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  if (std::signal(SIGHUP, interrupt) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
}

inline void throwIfInterrupted() {
  if (interrupted) throw std::runtime_error("interrupted");
}

}  // namespace predictive_stereo
