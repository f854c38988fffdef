#include <oncollide/scenes/model/shape.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/convex_hull.hpp>
#include <oncollide/scenes/model/hull_slack.hpp>
#include <oncollide/scenes/model/surface_grid.hpp>

namespace oncollide {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double least = 1e-60, largest = 1e15;

template <class... Cases>
struct Match : Cases... {
    using Cases::operator()...;
};
template <class... Cases>
Match(Cases...) -> Match<Cases...>; // Clang 14 does not deduce aggregates

void check_dimension(const std::string& name, const char* what, double value, bool zero_too = false)
{
    if (!(value > 0 || (zero_too && value == 0)) || !(value <= largest))
        refuse(name, fmt::format("{} is {}; it must be {} and at most {:g}", what, value,
                                 zero_too ? "0 or above" : "above 0", largest));
    if (value != 0 && value < least)
        refuse(name,
               fmt::format("{} is {}; below {} m products lose their digits: scale the scene up", what, value, least));
}

/// A polytope around a sphere: unit octasphere and the factor that moves every facet out of the unit sphere.
struct BallCover {
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    double factor; ///< distance of the farthest vertex of the cover of a unit sphere
};

/// Each facet's plane is at least `nearest` from the centre, so the surface scaled by 1 / nearest encloses the unit
/// sphere. 1,568 triangles, factor 1.005. Its equator is its outline in the direction of z.
const BallCover& ball_cover()
{
    static const BallCover cover = [] {
        BallCover made;
        octasphere(14, made.points, made.triangles);
        double nearest = 1;
        for (const Triangle& t : made.triangles) {
            const Eigen::Vector3d &a = made.points[t[0]], &b = made.points[t[1]], &c = made.points[t[2]];
            nearest = std::min(nearest, (b - a).cross(c - a).normalized().dot(a));
        }
        made.factor = 1 / nearest * (1 + 1e-12); // the facets are well shaped: rounding stays below 1e-13
        return made;
    }();
    return cover;
}

BoundingMesh enclose_sphere(double radius)
{
    const BallCover& cover = ball_cover();
    std::vector<Eigen::Vector3d> points = cover.points;
    for (Eigen::Vector3d& p : points) p *= radius * cover.factor;
    return {make_mesh("sphere", std::move(points), cover.triangles), radius * (cover.factor * (1 + 4 * epsilon) - 1)};
}

/// The Minkowski sum of a sphere's cover and the axis: two halves moved apart, joined along the equator. It encloses
/// the capsule with the same error as the sphere's cover.
BoundingMesh enclose_capsule(const Capsule& capsule)
{
    if (capsule.length == 0) return enclose_sphere(capsule.radius);
    const BallCover& cover = ball_cover();
    const double half = 0.5 * capsule.length;
    const double rounding = 4 * epsilon * (half + 2 * capsule.radius); // error bound of moving the halves
    const double radius = (capsule.radius + rounding) * cover.factor;

    std::vector<Eigen::Vector3d> points;
    // Index of an equator vertex's lower copy; for other vertices, of the vertex itself.
    std::vector<std::uint32_t> lower(cover.points.size());
    for (std::size_t i = 0; i < cover.points.size(); ++i) {
        Eigen::Vector3d p = radius * cover.points[i];
        const double z = p.z();
        p.z() = z < 0 ? z - half : z + half;
        points.push_back(p);
        lower[i] = static_cast<std::uint32_t>(i);
    }
    for (std::size_t i = 0; i < cover.points.size(); ++i)
        if (cover.points[i].z() == 0) {
            lower[i] = static_cast<std::uint32_t>(points.size());
            points.push_back({points[i].x(), points[i].y(), -half});
        }
    std::vector<Triangle> triangles;
    for (const Triangle& t : cover.triangles) {
        const double z = cover.points[t[0]].z() + cover.points[t[1]].z() + cover.points[t[2]].z();
        triangles.push_back(z > 0 ? t : Triangle{lower[t[0]], lower[t[1]], lower[t[2]]});
        for (int k = 0; k < 3 && z > 0; ++k) {
            const std::uint32_t from = t[k], to = t[(k + 1) % 3];
            if (lower[from] == from || lower[to] == to) continue; // not an edge of the equator
            triangles.push_back({to, from, lower[from]}), triangles.push_back({to, lower[from], lower[to]});
        }
    }
    return {make_mesh("capsule", std::move(points), std::move(triangles)),
            radius * (1 + 4 * epsilon) - capsule.radius + rounding};
}

/// A prism whose sides touch the cylinder.
BoundingMesh enclose_cylinder(const Cylinder& cylinder)
{
    constexpr int sides = 32; // 1 / cos(pi / 32) = 1.0048
    const double radius = cylinder.radius / circle(0.5 / sides).cosine * (1 + 1e-12), half = 0.5 * cylinder.length;
    return {make_prism("cylinder", radius, half, sides), radius * (1 + 4 * epsilon) - cylinder.radius};
}

/// The cover of a unit sphere, scaled along the axes by the radii.
BoundingMesh enclose_ellipsoid(const Ellipsoid& ellipsoid)
{
    const BallCover& cover = ball_cover();
    std::vector<Eigen::Vector3d> points = cover.points;
    for (Eigen::Vector3d& p : points) p = p.cwiseProduct(ellipsoid.semi_axes) * cover.factor;
    return {make_mesh("ellipsoid", std::move(points), cover.triangles),
            ellipsoid.semi_axes.maxCoeff() * (cover.factor * (1 + 4 * epsilon) - 1)};
}

/// A pyramid over a polygon whose sides touch the base.
BoundingMesh enclose_cone(const Cone& cone)
{
    constexpr int sides = 32;
    const double radius = cone.radius / circle(0.5 / sides).cosine * (1 + 1e-12), half = 0.5 * cone.length;
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    for (int k = 0; k < sides; ++k) {
        const auto turn = circle(double(k) / sides);
        points.emplace_back(radius * turn.cosine, radius * turn.sine, -half);
    }
    points.emplace_back(0, 0, half);
    for (std::uint32_t k = 0; k < sides; ++k) {
        triangles.push_back({k, (k + 1) % sides, sides});
        if (k > 1) triangles.push_back({0, k, k - 1});
    }
    return {make_mesh("cone", std::move(points), std::move(triangles)), radius * (1 + 4 * epsilon) - cone.radius};
}

/// The least distance of an inner point from the facets of a closed surface, and the largest of points beyond them.
struct Fit {
    double depth, overhang;
};

Fit fit_of(std::span<const Eigen::Vector3d> surface, std::span<const Triangle> triangles, const Eigen::Vector3d& inner,
           std::span<const Eigen::Vector3d> inside)
{
    double size = 0;
    for (const Eigen::Vector3d& p : surface) size = std::max(size, (p - inner).cwiseAbs().sum());
    Fit fit{.depth = std::numeric_limits<double>::infinity(), .overhang = 0};
    for (const Triangle& t : triangles) {
        const Eigen::Vector3d u = surface[t[1]] - surface[t[0]], v = surface[t[2]] - surface[t[0]], n = u.cross(v);
        const double length = n.norm();
        // The error of a sliver's normal is about the rounding of the cross product divided by its length.
        const double rounding = 16 * epsilon * size * (1 + u.norm() * v.norm() / length);
        const Eigen::Vector3d normal = n / length;
        const double plane = normal.dot(surface[t[0]] - inner);
        fit.depth = std::min(fit.depth, plane - rounding);
        double height = -std::numeric_limits<double>::infinity();
        for (const Eigen::Vector3d& p : inside) height = std::max(height, normal.dot(p - inner));
        const double over = height - plane + rounding;
        if (!(over <= fit.overhang)) fit.overhang = over; // keeps NaN, which is refused later
    }
    return fit;
}

/// The hull, expanded from an inner point. If a point is at most e above the planes of all facets, and these are at
/// least d from the inner point, then it is inside the surface scaled by 1 + e / d: its ray meets the surface at height
/// h >= d. If a facet is too thin for that (many points in one plane), each point is first moved outward by a small
/// individual amount: the hull then has no nearly flat parts, and the original points are below its facets.
BoundingMesh enclose_hull(const std::string& name, const std::vector<Eigen::Vector3d>& points)
{
    const Hull hull = convex_hull(points);
    if (hull.triangles.empty())
        refuse(name, fmt::format("the {} points of the convex hull lie in a plane; it needs four that do not",
                                 points.size()));
    const Eigen::Vector3d inner = mean_of(points, hull.vertices);
    std::vector<Eigen::Vector3d> corners;
    double rounding = 0; // rounding of a vertex's coordinates
    for (const std::uint32_t v : hull.vertices) {
        corners.push_back(points[v]);
        rounding = std::max(rounding, 2 * epsilon * points[v].cwiseAbs().maxCoeff());
    }

    for (const double stretch : {0.0, 1e-12, 1e-10, 1e-8, 1e-6}) {
        std::vector<Eigen::Vector3d> surface = corners;
        for (std::size_t i = 0; i < surface.size(); ++i) {
            const double share = 1 + static_cast<double>(i * 0x9E3779B97F4A7C15u >> 11) * 0x1p-53; // 1 to 2,
                                                                                                   // pseudorandom
            surface[i] += stretch * share * (surface[i] - inner);
        }
        const Hull outer = convex_hull(surface);
        if (outer.triangles.empty()) continue;
        const Fit fit = fit_of(surface, outer.triangles, inner, corners);
        const double overhang = fit.overhang + hull.slack;
        if (!(fit.depth > 0 && 2 * overhang / fit.depth < std::max(1e-12, stretch))) continue;
        // If rounding moves the corners of a surface, it moves no point of the surface farther than that, and two
        // scaled copies of the surface are apart by the difference of their factors times the depth. Doubled to cover
        // the rounding of this computation.
        const double push = 2 * (overhang + rounding) / fit.depth;

        std::vector<Eigen::Vector3d> pushed;
        std::vector<std::uint32_t> place(surface.size());
        double error = 0;
        for (const std::uint32_t v : outer.vertices) {
            place[v] = static_cast<std::uint32_t>(pushed.size());
            pushed.push_back(surface[v] + push * (surface[v] - inner));
            error = std::max(error, (pushed.back() - corners[v]).norm());
        }
        std::vector<Triangle> triangles = outer.triangles;
        for (Triangle& t : triangles) t = {place[t[0]], place[t[1]], place[t[2]]};
        return {make_mesh(name, std::move(pushed), std::move(triangles)), error * (1 + 8 * epsilon)};
    }
    refuse(name, fmt::format("the {} points of the convex hull lie in a plane up to rounding", points.size()));
}

} // namespace

void check_shape(const std::string& name, const Shape& shape)
{
    const auto check_points = [&](const ConvexHull& hull) {
        if (hull.points.size() < 4)
            refuse(name, fmt::format("the convex hull has {} points; it needs at least 4", hull.points.size()));
        for (std::size_t i = 0; i < hull.points.size(); ++i)
            if (!(hull.points[i].cwiseAbs().maxCoeff() <= largest) || !hull.points[i].allFinite())
                refuse(name, fmt::format("point {} of the convex hull is not finite or beyond {:g}", i, largest));
        enclose_hull(name, hull.points);
    };
    std::visit(Match{[&](const Sphere& s) { check_dimension(name, "the radius", s.radius); },
                     [&](const Box& b) {
                         for (int axis = 0; axis < 3; ++axis)
                             check_dimension(name, fmt::format("half-extent {}", "xyz"[axis]).c_str(), b.half[axis]);
                     },
                     [&](const Capsule& c) {
                         check_dimension(name, "the radius", c.radius);
                         check_dimension(name, "the length", c.length, true);
                     },
                     [&](const Cylinder& c) {
                         check_dimension(name, "the radius", c.radius);
                         check_dimension(name, "the length", c.length);
                     },
                     check_points,
                     [&](const Ellipsoid& e) {
                         for (int axis = 0; axis < 3; ++axis)
                             check_dimension(name, fmt::format("semi-axis {}", "xyz"[axis]).c_str(), e.semi_axes[axis]);
                     },
                     [&](const Cone& c) {
                         check_dimension(name, "the radius", c.radius);
                         check_dimension(name, "the length", c.length);
                     },
                     [](const HalfSpace&) {}},
               shape);
}

Aabb bounds_of(const Shape& shape)
{
    const auto around = [](const Eigen::Vector3d& half) { return Aabb{-half, half}; };
    return std::visit(Match{[&](const Sphere& s) { return around(Eigen::Vector3d::Constant(s.radius)); },
                            [&](const Box& b) { return around(b.half); },
                            [&](const Capsule& c) {
                                return around({c.radius, c.radius, c.radius + 0.5 * c.length});
                            },
                            [&](const Cylinder& c) {
                                return around({c.radius, c.radius, 0.5 * c.length});
                            },
                            [&](const ConvexHull& hull) {
                                Aabb bounds;
                                for (const Eigen::Vector3d& p : hull.points) bounds.add(p);
                                return bounds;
                            },
                            [&](const Ellipsoid& e) { return around(e.semi_axes); },
                            [&](const Cone& c) {
                                return around({c.radius, c.radius, 0.5 * c.length});
                            },
                            [](const HalfSpace&) {
                                constexpr double end = half_space_end;
                                return Aabb{{-end, -end, -end}, {end, end, 0}};
                            }},
                      shape);
}

BoundingMesh bounding_mesh_of(const Shape& shape)
{
    return std::visit(Match{[](const Sphere& s) { return enclose_sphere(s.radius); },
                            [](const Box& b) {
                                return BoundingMesh{box_mesh(b.half), 0.0};
                            },
                            [](const Capsule& c) { return enclose_capsule(c); },
                            [](const Cylinder& c) { return enclose_cylinder(c); },
                            [](const ConvexHull& hull) { return enclose_hull("convex hull", hull.points); },
                            [](const Ellipsoid& e) { return enclose_ellipsoid(e); },
                            [](const Cone& c) { return enclose_cone(c); },
                            [](const HalfSpace&) -> BoundingMesh {
                                throw Error(ErrorKind::internal, "a half-space has no bounding mesh");
                            }},
                      shape);
}

} // namespace oncollide
