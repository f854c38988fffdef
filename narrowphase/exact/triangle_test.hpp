#pragma once
#include <algorithm>
#include <array>

#include <Eigen/Core>

namespace oncollide {

/// The corners of a triangle, metres, finite. If they are on one line or at one point, the triangle is that segment or
/// point.
using TrianglePoints = std::array<Eigen::Vector3d, 3>;

/// The largest and the smallest projection of the triangle onto a direction.
inline double most_along(const Eigen::Vector3d& line, const TrianglePoints& t)
{
    return std::max(std::max(line.dot(t[0]), line.dot(t[1])), line.dot(t[2]));
}
inline double least_along(const Eigen::Vector3d& line, const TrianglePoints& t)
{
    return std::min(std::min(line.dot(t[0]), line.dot(t[1])), line.dot(t[2]));
}

/// The exact relation of two triangles, both taken as closed sets.
///
/// crossing: they meet and no arbitrarily small translation of either separates them, that is, 0 is in the interior of
/// their Minkowski difference. For two triangles with area: their relative interiors meet and their planes differ. A
/// segment that pierces the inside of a triangle crosses it; two segments, or a point and anything, never cross.
/// touching: they meet, but do not cross: a corner or an edge on the other, or overlap in one plane.
enum class TriangleContact { separate, touching, crossing };

/// Exact for the coordinates as stored, so independent of the order of the triangles and of their corners. Does not
/// test boxes first. Cost: about 25 ns, 11 if a plane separates them; 40 to 200 with a shared corner or a corner on a
/// face, 1,000 in one plane. Source: Guigue and Devillers, "Fast and robust triangle-triangle overlap test using
/// orientation predicates", JGT 2003, with exact signs.
TriangleContact triangle_contact(const TrianglePoints& a, const TrianglePoints& b);

/// True if they have a point in common: touching counts.
bool triangles_meet(const TrianglePoints& a, const TrianglePoints& b);

/// The intersection of two triangles that meet.
struct CommonSegment {
    /// The ends are equal if the intersection is a point. If the triangles overlap in one plane, the two points of the
    /// overlap that are farthest apart. Each coordinate errs by at most 2^-48 times the largest coordinate.
    std::array<Eigen::Vector3d, 2> ends;
    TriangleContact kind; ///< as returned by triangle_contact
};

/// The triangles must meet. Cost: 0.3 to 4 microseconds.
CommonSegment common_segment(const TrianglePoints& a, const TrianglePoints& b);

} // namespace oncollide
