#include "tools/command_line.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <opencv2/core/utility.hpp>
#include <regex>

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

// Whether each option of a help text, "--name VALUE" or "--name", has a value.
std::map<std::string, bool> optionsIn(const std::string& help) {
  static const std::regex form("--([a-z0-9-]+)( [A-Z])?");
  std::map<std::string, bool> options{{"help", false}};
  for (std::sregex_iterator found(help.begin(), help.end(), form), end; found != end; ++found)
    options[(*found)[1]] |= (*found)[2].matched;
  return options;
}

// False for folders, and for what does not exist: nothing is lost then.
bool isSameFile(const std::filesystem::path& one, const std::filesystem::path& other) {
  std::error_code ignored;
  return std::filesystem::equivalent(one, other, ignored) &&
         !std::filesystem::is_directory(one, ignored);
}

const std::string kOutputs[] = {"output", "csv"};

}  // namespace

CommandLine::CommandLine(int argc, const char* const* argv, const std::string& help) {
  const std::map<std::string, bool> known = optionsIn(help);
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
    const auto option = known.find(name);
    if (option == known.end() || (!option->second && equals != std::string::npos)) {
      std::vector<std::string> names;
      for (const auto& each : known) names.push_back(each.first);
      throw UsageError("unknown option " + argument + "; did you mean --" +
                       nearestName(name, names) + "?");
    }
    if (!option->second)
      values_[name].push_back("");
    else if (equals != std::string::npos)
      values_[name].push_back(argument.substr(equals + 1));
    else if (i + 1 < argc)
      values_[name].push_back(argv[++i]);
    else
      throw UsageError("option " + argument + " needs a value");
  }
  for (const std::string& input : positional_) requireKept(input);
  for (const auto& [name, values] : values_)
    if (std::find(std::begin(kOutputs), std::end(kOutputs), name) == std::end(kOutputs))
      for (const std::string& value : values) requireKept(value);
  const std::filesystem::path output = get("output"), csv = get("csv");
  if (!csv.empty() && output.lexically_normal() == csv.lexically_normal())
    throw UsageError("--output and --csv are the same file: give another name");
}

void CommandLine::requireKept(const std::string& input) const {
  for (const std::string& name : kOutputs)
    for (const std::string& output : all(name))
      if (isSameFile(output, input) || (name == "csv" && isSameFile(framesFile(output), input)))
        throw UsageError("--" + name + " = " + output + ": " + input +
                         " is an input, which would be lost: give another name");
}

std::string CommandLine::get(const std::string& name, const std::string& otherwise) const {
  return has(name) ? values_.at(name).back() : otherwise;
}

std::vector<std::string> CommandLine::all(const std::string& name) const {
  return has(name) ? values_.at(name) : std::vector<std::string>();
}

std::filesystem::path framesFile(const std::filesystem::path& csv) {
  return csv.parent_path() / (csv.stem().string() + "_frames.csv");
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

int runTool(int argc, char** argv, const std::string& help, int (*body)(const CommandLine&)) {
  const std::string tool = std::filesystem::path(argv[0]).filename().string();
  try {
    const CommandLine command_line(argc, argv, help);
    if (command_line.has("threads")) cv::setNumThreads(command_line.getInt("threads", 1, 1));
    int status = 0;
    if (command_line.has("help"))
      std::cout << help;
    else
      status = body(command_line);
    std::cout.flush();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw std::runtime_error("standard output cannot be written");
    return status;
  } catch (const UsageError& error) {
    std::cerr << tool << ": " << error.what() << "\nSee " << tool << " --help\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << tool << ": " << error.what() << "\n";
    return 1;
  }
}

}  // namespace predictive_stereo
