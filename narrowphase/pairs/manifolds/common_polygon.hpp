// The overlap of two triangles in one plane.
#pragma once
#include <vector>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// Corners of the common polygon, counter-clockwise around the normal of a.
inline std::vector<Eigen::Vector3d> common_polygon(const TrianglePoints& a, const TrianglePoints& b,
                                                   const Eigen::Vector3d& normal)
{
    std::vector<Eigen::Vector3d> polygon(a.begin(), a.end()), next;
    const double turn = normal.dot((b[1] - b[0]).cross(b[2] - b[0])) < 0 ? -1 : 1;
    for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d &p = b[k], edge = b[(k + 1) % 3] - p, inward = turn * normal.cross(edge);
        next.clear();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Eigen::Vector3d &u = polygon[i], &v = polygon[(i + 1) % polygon.size()];
            const double at_u = inward.dot(u - p), at_v = inward.dot(v - p);
            if (at_u >= 0) next.push_back(u);
            if ((at_u < 0 && at_v > 0) || (at_u > 0 && at_v < 0)) next.push_back(u + at_u / (at_u - at_v) * (v - u));
        }
        polygon.swap(next);
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
