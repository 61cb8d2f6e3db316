/// Starts each program of the package: its help is docs/help/NAME.txt, its body is runProgram().
#include "tools/command_line.h"

int main(int argc, char** argv) {
  return predictive_stereo::runTool(argc, argv, predictive_stereo::kToolHelp,
                                    predictive_stereo::runProgram);
}
