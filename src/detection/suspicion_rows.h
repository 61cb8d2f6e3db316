/// The loops of Suspicion over one row of the lattice, compiled for every SIMD target and
/// dispatched at run time. Every target gives the same results, bit by bit.
#pragma once

#include <cstdint>

namespace predictive_stereo {

/// Side of the squares over which texture is summed, and how far these reach.
constexpr int kTextureSide = 5, kTextureReach = kTextureSide / 2;

/// 25 |grey - mean grey| over the square around each point of the middle one of five rows. The
/// first and last kTextureReach points have no such square: they get 0.
void greyDeviationRow(const uint8_t* const rows[kTextureSide], int width, uint16_t* deviation);

/// mismatch / (texture + noise), texture being the mean of `deviations` / 25 over the square; 0
/// where the mismatch is negative (unknown) and at the first and last kTextureReach points.
void suspicionRow(const uint16_t* const deviations[kTextureSide], const float* mismatch, int width,
                  float noise, float* suspicion);

/// Cells of kCell x kCell points in which something reaches `least`.
/// @param rows  kCell rows, from the first cell's first point on.
/// @param found  their indices.
/// @param worst  kCell * row + column of the largest point in each, of the first one of several.
/// @return how many.
constexpr int kCell = 4;
int suspiciousCells(const float* const rows[kCell], int cells, float least, int32_t* found,
                    int32_t* worst);

}  // namespace predictive_stereo
