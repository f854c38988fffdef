// Triangles in one plane, and triangles without area: the cases that orientations alone cannot decide.
#pragma once
#include <oncollide/narrowphase/exact/triangle_test.hpp>

namespace oncollide {

/// A triangle as the point, segment or triangle that its corners span.
struct Simplex {
    int count; ///< corners: 1 to 3; two are the ends of a segment, the lexicographically smaller first
    TrianglePoints corner;
};
Simplex simplex_of(const TrianglePoints& triangle);

/// Drops the coordinate `axis`.
inline Eigen::Vector2d projected(const Eigen::Vector3d& p, int axis)
{
    return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

/// An axis along which the plane of two coplanar simplices can be projected one to one; -1 if all their corners are on
/// one line.
int projection_axis(const Simplex& a, const Simplex& b);

/// True if p, a point of the common plane, is in the simplex. `axis` comes from projection_axis().
bool holds(const Simplex& simplex, const Eigen::Vector3d& p, int axis);

/// How the segment pq meets the triangle, which has area. crossing: strictly through the inside of both.
/// @param of_p, of_q  sides of the triangle's plane on which the ends are, as orient3d returns them; they differ
TriangleContact pierce(const TrianglePoints& triangle, const Eigen::Vector3d& p, const Eigen::Vector3d& q, int of_p,
                       int of_q);

/// triangle_contact for two triangles of which one has its corners in the plane of the other, or has no area.
TriangleContact flat_contact(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
