#pragma once
#include <Eigen/Core>

#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

// Signs of two bodies A and B, of which B is moved by (e, e^2, e^3) for an infinitely small e > 0. Surfaces then meet
// in segments that each have two ends, and every closed surface is crossed consistently, in spite of contacts. Source:
// Edelsbrunner and Mücke, "Simulation of simplicity", TOG 1990, with one displacement for a whole body.

/// The side of a triangle's plane that a point of the other body is on: 1 where its normal points, else -1; 0 if the
/// triangle has no area.
/// @param exact  orient3d() of the triangle and the point
/// @param of_b   the triangle is B's, and the point A's
int moved_side(const TrianglePoints& triangle, int exact, bool of_b);

/// True if B moves towards the side to which the triangle's normal points.
bool moves_along(const TrianglePoints& triangle);

/// The sign of orient3d(p, q, c, d) for an edge pq of A and an edge cd of B; 0 if they are parallel and in one plane.
int moved_turn(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& c, const Eigen::Vector3d& d);

} // namespace oncollide
