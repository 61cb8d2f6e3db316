#pragma once

namespace predictive_stereo {

/// Limits the threads of parallel loops in this process. All nodelets of a manager share them. The
/// smallest of several limits is used, until the process ends.
/// @param threads  0: no limit.
void limitThreads(int threads);

}  // namespace predictive_stereo
