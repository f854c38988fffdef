#include <oncollide/narrowphase/pairs/manifolds/shapes/placed_convex.hpp>

#include <algorithm>
#include <limits>

#include <Eigen/Geometry>

namespace oncollide {

using Eigen::Vector3d;

bool PlacedConvex::holds(const Vector3d& p) const
{
    const Vector3d at = into_shape(p - into.translation);
    return ((at - box_.centre()).cwiseAbs().array() <= box_.half().array()).all() &&
           solid.depth(at) >= 2 * slack * size();
}

/// True if the box around the shape is behind a plane, farther from it than a cutoff.
bool PlacedConvex::box_is_behind(const Vector3d& out, const Vector3d& at, double cutoff) const
{
    return out.dot(box_middle_ - at) + box_.half().dot(into_shape(out).cwiseAbs()) < -cutoff;
}

bool PlacedConvex::box_is_apart(const TrianglePoints& c, double cutoff) const
{
    const Vector3d p = into_shape(c[0] - box_middle_), q = into_shape(c[1] - box_middle_),
                   r = into_shape(c[2] - box_middle_);
    const Vector3d far = (1 + 0x1p-16) * box_.half().array() + cutoff; // poses may be 2^-20 from rigid
    return (p.cwiseMin(q).cwiseMin(r).array() > far.array()).any() ||
           (p.cwiseMax(q).cwiseMax(r).array() < -far.array()).any();
}

/// True if the shape holds the point above its lowest point by a height. It does if the point is in the cone from there
/// around the sphere in its middle.
bool PlacedConvex::reaches_up(const Vector3d& low, double height, const Vector3d& up) const
{
    const Vector3d way = middle - low;
    const double inner = solid.inner * (1 - 0x1p-18), tangent2 = way.squaredNorm() - inner * inner, along = up.dot(way);
    if (along > 0 && tangent2 > 0 && along * along > tangent2 && 2 * height * height < tangent2) return true;
    return holds(low + height * up);
}

LeastTranslation PlacedConvex::part(const TrianglePoints& c, const Vector3d& face, double cutoff, double& depth) const
{
    LeastTranslation least{};
    least.beyond = true;
    const Vector3d way = middle - nearest_on(c, middle).at;
    const double far = ball_ + cutoff;
    if (way.squaredNorm() > far * far) return least;
    if (box_is_behind(-face, c[0], cutoff) || box_is_behind(face, c[0], cutoff)) return least;
    const Convex flat = convex_of(c);
    const ConvexDifference cores(flat, solid, into, slack);
    const double rounding =
        4 * cores.rounding() + 2 * slack * (cores.size() + cores.radius() + into.translation.norm());
    // The way from the triangle to the shape's middle parts most that are apart.
    if (const double length = way.norm(); length > 0) {
        const Vector3d n = way / length;
        const double top = std::max({n.dot(c[0]), n.dot(c[1]), n.dot(c[2])});
        if (n.dot(lowest(n)) - top > cutoff + rounding) return least;
    }
    const Vector3d low = lowest(face);
    depth = face.dot(c[0] - low);
    if (depth < -cutoff) return least;
    const Vector3d foot = low + depth * face;
    double room = std::numeric_limits<double>::infinity(); // of the foot to the triangle's border
    for (int k = 0; k < 3; ++k) {
        const Vector3d side = (c[(k + 1) % 3] - c[k]).cross(face).normalized();
        if (box_is_behind(-side, c[k], cutoff)) return least;
        room = std::min(room, side.dot(c[k] - foot));
    }
    // No direction is shorter than the face's normal if the shape's lowest point is over the triangle, farther from the
    // border than deep, and the shape is as high above the triangle there.
    if (room > std::max(depth, 0.0) + 4 * rounding && !face.isZero(0) &&
        (depth <= 0 || reaches_up(low, 2 * depth + 4 * rounding, face))) {
        least.beyond = false, least.has_points = true;
        least.normal = face, least.normal_error = 0x1p-46 + 8 * slack;
        least.lower = depth - rounding, least.upper = depth + rounding;
        least.on_a = foot, least.on_b = low + solid.radius * face;
        return least;
    }
    // Most others are apart, which the distance of a hull shows sooner than its depth.
    const bool hull = solid.core == Convex::Core::points;
    if (hull && convex_distance(cores, {.cutoff = cutoff + rounding, .below = cutoff}).lower > cutoff + rounding)
        return least;
    return least_translation(cores, cutoff);
}

} // namespace oncollide
