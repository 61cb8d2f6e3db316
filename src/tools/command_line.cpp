#include "tools/command_line.h"

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "params/param_table.h"

namespace predictive_stereo {
namespace {

template <class Number>
Number parsed(const CommandLine& line, const std::string& name, Number value) {
  try {
    if (line.has(name)) parseParam("--" + name, line.get(name), value);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  return value;
}

}  // namespace

CommandLine::CommandLine(int argc, const char* const* argv, const std::set<std::string>& options,
                         const std::set<std::string>& flags) {
  for (int i = 0; i < argc; ++i) command_ += (i ? " " : "") + std::string(argv[i]);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.size() < 2 || argument[0] != '-') {
      positional_.push_back(argument);
      continue;
    }
    const size_t equals = argument.find('=');
    std::string name = argument.substr(0, equals);
    name.erase(0, std::min(name.find_first_not_of('-'), name.size()));
    if (name == "h") name = "help";
    if (options.count(name)) {
      if (equals != std::string::npos)
        values_[name].push_back(argument.substr(equals + 1));
      else if (i + 1 < argc)
        values_[name].push_back(argv[++i]);
      else
        throw UsageError("option " + argument + " needs a value");
    } else if ((flags.count(name) || name == "help") && equals == std::string::npos) {
      values_[name].push_back("");
    } else {
      std::vector<std::string> known(options.begin(), options.end());
      known.insert(known.end(), flags.begin(), flags.end());
      throw UsageError("unknown option " + argument +
                       (known.empty() ? "" : "; did you mean --" + nearestName(name, known) + "?"));
    }
  }
}

std::string CommandLine::get(const std::string& name, const std::string& otherwise) const {
  return has(name) ? values_.at(name).back() : otherwise;
}

std::vector<std::string> CommandLine::all(const std::string& name) const {
  return has(name) ? values_.at(name) : std::vector<std::string>();
}

int CommandLine::getInt(const std::string& name, int otherwise, int smallest) const {
  const int value = parsed(*this, name, otherwise);
  if (has(name) && value < smallest)
    throw UsageError("--" + name + " = " + get(name) + ": must be at least " +
                     std::to_string(smallest));
  return value;
}

double CommandLine::getDouble(const std::string& name, double otherwise) const {
  return parsed(*this, name, otherwise);
}

int runTool(int argc, char** argv, const char* help, const std::set<std::string>& options,
            const std::set<std::string>& flags, int (*body)(const CommandLine&)) {
  const std::string tool = std::filesystem::path(argv[0]).filename().string();
  try {
    const CommandLine command_line(argc, argv, options, flags);
    if (command_line.has("help")) {
      std::cout << help;
      return 0;
    }
    return body(command_line);
  } catch (const UsageError& error) {
    std::cerr << tool << ": " << error.what() << "\nSee " << tool << " --help\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << tool << ": " << error.what() << "\n";
    return 1;
  }
}

}  // namespace predictive_stereo
