/// Cars that are difficult for stereo: dark, glossy and metallic paint, transparent windows.
#pragma once

#include "evaluation/simulation/models.h"

namespace predictive_stereo::simulation {

/// Gives all cars, vans and trucks glossy paint, mostly dark, and seats behind transparent windows.
void makeGlossy(Primitives& primitives);

/// Share of light that a glossy surface reflects specularly: Fresnel's equations in Schlick's
/// approximation (1994).
/// @param along_normal  this share for a view along the normal, of clear coat or glass.
/// @param cosine  of the angle between view and normal.
float fresnel(float along_normal, float cosine);

/// Shading normal of a flat face. Body panels are convex, so it turns from edge to edge.
Eigen::Vector3f normalOfPanel(const Primitive& primitive, const Eigen::Vector3f& normal,
                              const Eigen::Vector3f& local_m);
constexpr float kPanelTurn = 0.2f;  ///< its angle [rad] between the middle of a panel and an edge

}  // namespace predictive_stereo::simulation
