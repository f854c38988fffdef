#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <oncollide/base/aabb.hpp>
#include <oncollide/scenes/model/shape.hpp>

namespace oncollide {

/// A bounded convex solid for the tests in convex_pair.hpp: all points within `radius` of a core, which its support
/// function defines. Metres, in the solid's own frame. A small value; it may refer to points that others own.
struct Convex {
    enum class Core : std::uint8_t {
        box,      ///< from `low` to `high`; a point if the two are equal, a segment if they differ only along z
        points,   ///< the hull of `points`, with the surface `faces`
        cylinder, ///< along z: radius high.x, half-length high.z
        cone,     ///< along z: radius high.x at z = -high.z, apex at high.z
        ellipsoid ///< semi-axes `high`
    };
    Core core = Core::box;
    bool flat_sided = true; ///< true: the core is a polytope, and its support points are exact
    Eigen::Vector3d low, high;
    const Eigen::Vector3d* points = nullptr;
    std::uint32_t count = 0;
    std::span<const Triangle> faces;

    double radius = 0;      ///< radius of the sphere that is swept over the core
    double extent = 0;      ///< the core is within this distance of the origin, rounded up
    Eigen::Vector3d centre; ///< a point inside
    double inner = 0;       ///< the core holds a sphere of this radius around `centre`, rounded down; 0 for flat cores

    /// A support point of the core along d; each coordinate errs by a few roundings.
    Eigen::Vector3d support(const Eigen::Vector3d& d) const;
    /// True if the solid certainly holds a sphere around p; always false for hulls. @param ball  the sphere's radius,
    /// at least 2^-47 of the solid's size, which is far above rounding
    bool holds(const Eigen::Vector3d& p, double ball) const;
    /// A lower bound on the distance of p, a point of the solid, from its surface; negative if p may be outside.
    double depth(const Eigen::Vector3d& p) const;
    /// The largest projection of the solid onto d, within rounding.
    double most_along(const Eigen::Vector3d& d) const { return d.dot(support(d)) + radius * d.norm(); }
};

/// The shape must not be a hull, and must have passed check_shape.
Convex convex_of(const Shape& shape);
/// A convex hull, given by its surface, all of whose vertices are corners; refers to its vertices and faces.
Convex convex_of_hull(const Mesh& surface);
/// A cell or any other axis-aligned box.
Convex convex_of(const Aabb& box);
/// A triangle; refers to its corners.
Convex convex_of(const std::array<Eigen::Vector3d, 3>& triangle);

inline Eigen::Vector3d Convex::support(const Eigen::Vector3d& d) const
{
    switch (core) {
    case Core::box:
        // Selects by address: a branch on a sign would be mispredicted every other time.
        return {(d.x() < 0 ? &low : &high)->x(), (d.y() < 0 ? &low : &high)->y(), (d.z() < 0 ? &low : &high)->z()};
    case Core::points: {
        std::uint32_t best = 0;
        double most = points[0].dot(d);
        for (std::uint32_t i = 1; i < count; ++i) { // without a branch, which would often be mispredicted
            const double along = points[i].dot(d);
            best = along > most ? i : best;
            most = along > most ? along : most;
        }
        return points[best];
    }
    case Core::cylinder: {
        const double across = std::sqrt(d.x() * d.x() + d.y() * d.y()), z = d.z() < 0 ? -high.z() : high.z();
        if (!(across > 0)) return {high.x(), 0, z};
        const double scale = high.x() / across;
        return {scale * d.x(), scale * d.y(), z};
    }
    case Core::cone: {
        const double across = std::sqrt(d.x() * d.x() + d.y() * d.y());
        if (2 * high.z() * d.z() >= high.x() * across) return {0, 0, high.z()};
        if (!(across > 0)) return {high.x(), 0, -high.z()};
        const double scale = high.x() / across;
        return {scale * d.x(), scale * d.y(), -high.z()};
    }
    case Core::ellipsoid: {
        const Eigen::Vector3d scaled = high.cwiseProduct(d);
        const double length = scaled.norm();
        if (!(length > 0)) return {high.x(), 0, 0};
        return high.cwiseProduct(scaled / length);
    }
    }
    __builtin_unreachable();
}

} // namespace oncollide
