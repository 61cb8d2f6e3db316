/// The windows of one row of search ranges.
#pragma once

#include <cstdint>

#include "matching/search_windows.h"

namespace predictive_stereo {

/// Plans the runs of a row, except for their positions, and the width of each pixel.
/// @param first, last  the row's ranges, `columns` of them.
using PlanRowFunction = void (*)(const short* first, const short* last, int columns,
                                 const DisparityRange& range, WindowRun* runs,
                                 uint16_t* pixel_width);

/// The reference in plain C++ that the kernels must equal: one run after the other.
void planRowReference(const short* first, const short* last, int columns,
                      const DisparityRange& range, WindowRun* runs, uint16_t* pixel_width);

/// The kernel of a target; for the scalar target, the reference.
PlanRowFunction planRow(int64_t simd_target);

}  // namespace predictive_stereo
