/// The numbers by which the default scheme decides, but for the user's (MotionDetectionParams).
/// docs/design_notes.md has what other values do. Numbers that bound time or memory, those of a
/// kernel's layout, and halves and thirds are where they are used.
#pragma once

#include <cstddef>

namespace predictive_stereo {

// --- Errors, beside those that the variances of the maps tell -----------------------------------

/// Standard deviation of a disparity, at least.
constexpr float kDisparitySigma_px = 0.5f;
/// Variance of the difference of two frames: of errors that all disparities of a frame share
/// (calibration, row offsets), and of a patch's place.
constexpr float kBothFrames_px2 = 2 * kDisparitySigma_px * kDisparitySigma_px;
/// Largest error of a disparity: two that differ by more are of two surfaces.
constexpr float kDisparityError_px = 1;
/// Disparities of one surface also differ by this share of them.
constexpr float kSameSurface = 0.05f;
/// Standard deviation of the calibration's error, relative to the disparity.
constexpr float kScaleSigma = 0.02f;
/// A difference counts from this number of its standard deviations on.
constexpr float kSigmas = 2;
/// Standard deviation of a tracked point's position.
constexpr double kFlowSigma_px = 0.4;
/// Texture below this is noise [grey levels].
constexpr float kGreyNoise = 3;
/// Variance of the difference of two grey values.
constexpr float kGreyVariance = 8;

// --- Surfaces -----------------------------------------------------------------------------------

/// What is farther apart is not joined: steps in depth, gaps without texture, what stands and the
/// ground below it.
constexpr double kGap_m = 0.3;
/// Downwards, the disparity of a level surface grows by these shares of what is expected at its
/// height, that of an upright one by less.
constexpr float kLeastGrowth = 0.3f, kMostGrowth = 2;
/// Least share of the known cells on the ground, for each metre of the camera's height; below 1 m
/// it is that of 1 m, and it is at most the second. A low camera may see little of the ground; a
/// high one sees hardly anything else.
constexpr double kGroundSharePerMetre = 0.04, kMostGroundShare = 0.5;
/// Samples on an upright plane / on the ground: with more, the ground may be a far wall.
constexpr double kMostOnWall = 0.95;
/// Largest angle between the ground's normal and the camera's y axis, in all and sideways.
constexpr double kMostPitch_deg = 80, kMostRoll_deg = 30;
/// The ground of two frames: largest turn, and largest relative change of the camera's height.
constexpr double kMostTurn_deg = 20, kMostHeightChange = 0.1;

// --- Evidence: motion across the line of sight ---------------------------------------------------

/// Distance of the pixels whose disparity is compared with a point's, or tried for it.
constexpr int kAround_px = 4;
/// Fewest of a square of 3x3: points on one surface, cells with a known residual.
constexpr int kFewestOfNine = 6;
/// Mean squared difference of patches that are the same, relative to its variance: of a point that
/// a static world explains, and of free space that an image refutes.
constexpr float kMostDifference = 2.5f;
/// Mismatch of a group where a static world has it / where it was found.
constexpr float kLeastGain = 1.5f;
/// Difference between flows of one object: this and a share of the larger one.
constexpr double kFlowNoise_px = 1.5, kFlowShare = 0.3;
/// Distance along the line of sight / MotionDetectionParams::link_distance_m.
constexpr double kLinkDepth = 0.6;
/// Largest error of a point that agrees with the motion of its object.
constexpr double kInlierSigmas = 5;
/// Standard deviation of a motion that the points hardly show, along the line of sight.
constexpr double kPriorMotion_m = 3;
/// Errors of neighbouring points are correlated: variance of their motion / of independent points.
constexpr double kCorrelation = 4;
/// Fewest points of an object, or cells, whatever it is measured by.
constexpr std::size_t kFewestPoints = 12;

// --- Evidence: motion along the line of sight ----------------------------------------------------

/// Static points have moved at most by this in the frames that are compared.
constexpr double kMostParallax_px = 16;
/// The relative error of smaller disparities is too large.
constexpr float kLeastDisparity_px = 10;
/// |cells of one sign - cells of the other| / cells.
constexpr float kLeastSign = 0.6f;

// --- Evidence: free space ------------------------------------------------------------------------

/// Past frames that looked through a surface's place, at least.
constexpr int kFewestThrough = 2;
/// The matcher misses surfaces that are thinner than its windows. Less than five cells, so that a
/// surface of five was not too thin when it was a little farther away.
constexpr float kThinnest_px = 18;
/// Share of an obstacle's cells that has moved.
constexpr double kLeastMoved = 0.2;
/// Share of all compared cells, ground included, that are where they were.
constexpr double kLeastFixed = 0.4;

// --- Objects -------------------------------------------------------------------------------------

/// Difference of mismatches above noise: one explanation is better.
constexpr float kDecisive_grey = 1;
/// Cells of an object / those that motion shows: a plain wall behind a person is not the person.
constexpr int kMostGrown = 4;
/// Share of an object's points that are left out at both ends: false matches, edges.
constexpr double kTail = 0.05;
/// Lowest column / tallest columns of an object, and pixels of a line / of its fullest line.
constexpr double kLowestColumn = 0.35, kThinnestLine = 0.3;
/// Visible share of the height of a partly hidden object.
constexpr double kLeastVisible = 0.5;
/// Parts of one object have the same velocity: standard deviation of each part's own motion, as
/// that of limbs, and of both together.
constexpr double kOwnMotion_mps = 1, kMostSigmasOfVelocity = 3;
/// Area of a vehicle's side / of its rear; areas of both parts / of the box around them; share of a
/// part's box that is within an object's box.
constexpr double kLargestSide = 0.25, kLeastCovered = 0.5, kMostOfPart = 0.8;
/// Depths of a known object / of its centre, and the ends of its box that are left out, at both
/// sides, when it is sought.
constexpr float kKnownDepth = 0.15f;
constexpr double kEndsDown = 0.25, kEndsAcross = 0.2;
/// Standard deviation of an object's centre across the line of sight; along it the second, plus the
/// third times depth [m] / disparity [px].
constexpr double kCentreSigma_m = 0.2, kDepthSigma_m = 0.3, kDepthSigma_px = 0.3;
/// The score of one observation counts up to the first; its odds grow with its pixels, relative to
/// the second.
constexpr double kMostCertain = 0.97, kPixelsOfOdds = 1000;

// --- Time and pose -------------------------------------------------------------------------------

/// Between past frames that are kept.
constexpr double kLeastApart_s = 0.08;
/// A longer gap ends the past, and tracks that were not sought.
constexpr double kLongestGap_s = 1;
/// Share of the image that contradicts a right pose, and how much more than usual.
constexpr double kMostContradicting = 0.8, kSuddenlyContradicting = 0.2;
/// So many frames in a row may contradict; then the scene does.
constexpr int kMostOddFrames = 2;

}  // namespace predictive_stereo
