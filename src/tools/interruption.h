#pragma once

#include <csignal>
#include <stdexcept>

namespace predictive_stereo {

struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

inline volatile std::sig_atomic_t interrupted = 0;

/// After this call SIGINT and SIGTERM do not terminate the process. Instead, throwIfInterrupted()
/// throws Interrupted, so that destructors remove incomplete files.
inline void catchInterruptions() {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
}

inline void throwIfInterrupted() {
  if (interrupted) throw Interrupted();
}

}  // namespace predictive_stereo
