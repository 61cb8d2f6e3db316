#pragma once

#include <stdexcept>

namespace predictive_stereo {

struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// From here on SIGINT and SIGTERM do not end the process at once: throwIfInterrupted() throws
/// Interrupted after one of them, so that destructors remove what is half-written.
void catchInterruptions();
void throwIfInterrupted();

}  // namespace predictive_stereo
