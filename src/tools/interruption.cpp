#include "tools/interruption.h"

#include <csignal>

namespace predictive_stereo {
namespace {

volatile std::sig_atomic_t interrupted = 0;

extern "C" void onSignal(int) { interrupted = 1; }

}  // namespace

void catchInterruptions() {
  std::signal(SIGINT, onSignal);
  std::signal(SIGTERM, onSignal);
}

void throwIfInterrupted() {
  if (interrupted) throw Interrupted();
}

}  // namespace predictive_stereo
