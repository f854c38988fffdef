// Triangles of one mesh, which share corners: how they meet elsewhere.
#pragma once
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// True if some common point of the two triangles is on none of the corners and edges that they share. Corners at equal
/// positions are shared, as is an edge between two shared corners. True for two copies of a triangle with area. A
/// triangle without area is a segment or a point, all of which another triangle may share. Exact. Cost: 0.05 to 1
/// microseconds.
bool meet_beyond_shared(const TrianglePoints& a, const TrianglePoints& b);

/// True if it is certain that triangles which share the corner p, with other corners a1, a2 and b1, b2, share nothing
/// else. Tries one plane through p, which bisects the angle between the sums of the edges; for fans of n triangles
/// around one point, that decides nearly all n^2 pairs. Cost: 20 ns.
bool certainly_share_corner_only(const Eigen::Vector3d& p, const Eigen::Vector3d& a1, const Eigen::Vector3d& a2,
                                 const Eigen::Vector3d& b1, const Eigen::Vector3d& b2);

/// True if it is certain that triangles which share the edge from p to q, with third corners r and s, share nothing
/// else. Uncertain only within rounding of a fold onto each other. Cost: 5 to 10 ns.
bool certainly_share_edge_only(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r,
                               const Eigen::Vector3d& s);

} // namespace oncollide
