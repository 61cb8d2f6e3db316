#pragma once

#include <stdexcept>

namespace predictive_stereo {

struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// After this call SIGINT and SIGTERM do not terminate the process. Instead, throwIfInterrupted()
/// throws Interrupted, so that destructors remove incomplete files.
void catchInterruptions();
void throwIfInterrupted();

}  // namespace predictive_stereo
