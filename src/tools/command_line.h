#pragma once

#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace predictive_stereo {

/// Wrong use of a tool: the message is followed by a hint to --help.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Options and positional arguments of a tool: "--name value", "--name=value" and "--flag".
class CommandLine {
 public:
  /// @param options  names (without dashes) that take a value; may be given several times.
  /// @param flags  names that take none. "help" is always one.
  /// @throws UsageError for unknown options (the nearest known one is suggested) or missing values.
  CommandLine(int argc, const char* const* argv, const std::set<std::string>& options,
              const std::set<std::string>& flags);

  bool has(const std::string& name) const { return values_.count(name) > 0; }
  /// The last value given, or `otherwise`.
  std::string get(const std::string& name, const std::string& otherwise = "") const;
  std::vector<std::string> all(const std::string& name) const;
  /// @throws UsageError for what is no whole number of at least `smallest`.
  int getInt(const std::string& name, int otherwise, int smallest) const;
  /// @throws UsageError for what is no number.
  double getDouble(const std::string& name, double otherwise) const;
  const std::vector<std::string>& positional() const { return positional_; }
  /// The command as it was given, arguments separated by blanks.
  const std::string& command() const { return command_; }

 private:
  std::map<std::string, std::vector<std::string>> values_;
  std::vector<std::string> positional_;
  std::string command_;
};

/// Runs a tool's body: prints `help` where asked for, turns exceptions into "tool: message" on
/// stderr and exit status 1 (2 for wrong use).
int runTool(int argc, char** argv, const char* help, const std::set<std::string>& options,
            const std::set<std::string>& flags, int (*body)(const CommandLine&));

}  // namespace predictive_stereo
