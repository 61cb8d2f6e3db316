/// The loops of Suspicion over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Side of the squares over which texture is summed, and their reach from the centre.
constexpr int kTextureSide = 5, kTextureReach = kTextureSide / 2;

/// 25 |grey - mean grey over the square| for each point of the middle one of five rows. 0 for the
/// first and last kTextureReach points, which have no such square.
void greyDeviationRow(const uint8_t* const rows[kTextureSide], int width, uint16_t* deviation);

/// mismatch / (texture + noise), where texture is the mean of `deviations` / 25 over the square. 0
/// if the mismatch is negative (unknown), and at the first and last kTextureReach points.
void suspicionRow(const uint16_t* const deviations[kTextureSide], const float* mismatch, int width,
                  float noise, float* suspicion);

/// Finds cells of kCell x kCell points with a maximum of at least `least`.
/// @param rows  kCell rows, from the first cell's first point on.
/// @param found  indices of these cells.
/// @param worst  kCell * row + column of the maximum in each of them; of the first one of equals.
/// @returns the number of these cells.
constexpr int kCell = 4;
int suspiciousCells(const float* const rows[kCell], int cells, float least, int32_t* found,
                    int32_t* worst);

}  // namespace predictive_stereo
