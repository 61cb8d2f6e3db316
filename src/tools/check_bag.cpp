/// Reports whether a bag can be used and, if not, what to change.
#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "tools/bag_check.h"
#include "tools/command_line.h"

namespace predictive_stereo {
namespace {

constexpr const char* kMarks[] = {"ok    ", "note  ", "FAULT "};  // of each BagFinding::Level

// Quotes a word for a shell: names of files and topics may contain any character.
std::string quoted(const std::string& word) {
  const auto harmless = [](unsigned char c) {
    return std::isalnum(c) || (c != 0 && std::strchr("_-./:=,+@", c) != nullptr);
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), harmless)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

std::string launchLine(const BagCheck& check) {
  std::string line = check.launch_file;
  for (const std::string& argument : check.arguments) line += " " + quoted(argument);
  return line;
}

}  // namespace

int runProgram(const CommandLine& command_line) {
  if (command_line.positional().size() != 1) throw UsageError("give one bag");
  const StereoTopicChoice choice = topicChoice(command_line);
  const std::string path = command_line.positional()[0];

  if (!std::filesystem::is_regular_file(path)) throw std::runtime_error(path + ": file not found");
  rosbag::Bag bag;
  openBag(path, bag);
  const BagCheck result = checkBag(bag, choice);

  const bool launch_only = command_line.has("launch"), usable = result.isUsable();
  for (const auto& [level, text] : result.findings)
    if (!launch_only || level != BagFinding::Level::kGood)
      (launch_only ? std::cerr : std::cout) << kMarks[static_cast<int>(level)] << text << "\n";
  if (usable && launch_only)
    std::cout << launchLine(result) << "\n";
  else if (usable)
    std::cout << "\nThis bag can be used:\n  roslaunch predictive_stereo " << launchLine(result)
              << " " << quoted("bag:=" + std::filesystem::absolute(path).string())
              << " rviz:=true\n";
  else if (!launch_only)
    std::cout << "\nThis bag cannot be used like this.\n";
  return usable ? 0 : 1;
}

}  // namespace predictive_stereo
