/// The windows of one row of search ranges.
#pragma once

#include <cstdint>

#include "matching/search_windows.h"

namespace predictive_stereo {

/// Plans a row's runs but for their positions, and the width of each pixel.
/// @param first, last  the row's ranges, `columns` of them.
using PlanRowFunction = void (*)(const short* first, const short* last, int columns,
                                 const DisparityRange& range, WindowRun* runs,
                                 uint16_t* pixel_width);

/// One run after the other, in plain words: what the kernels must equal.
void planRowReference(const short* first, const short* last, int columns,
                      const DisparityRange& range, WindowRun* runs, uint16_t* pixel_width);

/// The reference for the scalar target.
PlanRowFunction planRow(int64_t simd_target);

}  // namespace predictive_stereo
