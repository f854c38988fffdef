// The overlap of two triangles in one plane.
#pragma once
#include <vector>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>
#include <oncollide/narrowphase/pairs/manifolds/points/clip_polygon.hpp>

namespace oncollide {

/// Corners of the common polygon, counter-clockwise around the normal of a.
inline std::vector<Eigen::Vector3d> common_polygon(const TrianglePoints& a, const TrianglePoints& b,
                                                   const Eigen::Vector3d& normal)
{
    std::vector<Eigen::Vector3d> polygon(a.begin(), a.end()), scratch;
    const double turn = normal.dot((b[1] - b[0]).cross(b[2] - b[0])) < 0 ? -1 : 1;
    for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d edge = b[(k + 1) % 3] - b[k];
        clip_behind(polygon, -turn * normal.cross(edge), b[k], scratch);
    }
    return polygon;
}

inline bool in_one_plane(const TrianglePoints& a, const TrianglePoints& b)
{
    for (const Eigen::Vector3d& p : b)
        if (orient3d(a[0], a[1], a[2], p) != 0) return false;
    return true;
}

} // namespace oncollide
