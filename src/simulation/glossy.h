/// Cars that one sees badly: dark, glossy and metallic paint, windows one sees through.
#pragma once

#include "simulation/models.h"

namespace predictive_stereo::simulation {

/// Gives all cars, vans and trucks glossy paint, mostly dark, and seats behind windows one sees
/// through.
void makeGlossy(Primitives& primitives);

/// Share of light that a glossy surface reflects as a mirror: Fresnel's equations in Schlick's
/// approximation (1994). @param along_normal  of clear coat or glass; @param cosine  of the angle
/// between view and normal.
float fresnel(float along_normal, float cosine);

/// Of a flat face: panels are convex, so their normal turns from edge to edge.
Eigen::Vector3f normalOfPanel(const Primitive& primitive, const Eigen::Vector3f& normal,
                              const Eigen::Vector3f& local_m);
constexpr float kPanelTurn = 0.2f;  ///< by this much [rad] from the middle of a panel to its edge

}  // namespace predictive_stereo::simulation
