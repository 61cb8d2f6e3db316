#pragma once

namespace predictive_stereo {

/// Limits the threads that a parallel loop of this process takes. All nodelets of a manager share
/// them, as they share the cores: of several limits the least holds, until the process ends.
/// @param threads  0: no limit of this caller.
void limitThreads(int threads);

}  // namespace predictive_stereo
