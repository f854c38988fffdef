#include <oncollide/narrowphase/shapes/convex.hpp>

#include <algorithm>

#include <Eigen/Geometry>

#include <oncollide/base/numbers/infinity.hpp>

namespace oncollide {

namespace {

constexpr double inward = 1 - 0x1p-40, outward = 1 + 0x1p-40; ///< factors that round inner and outer radii

Convex box_core(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double radius = 0)
{
    Convex c;
    c.low = low, c.high = high, c.radius = radius;
    c.extent = low.cwiseAbs().cwiseMax(high.cwiseAbs()).norm() * outward;
    c.centre = 0.5 * (low + high);
    c.inner = (c.centre - low).cwiseMin(high - c.centre).minCoeff() * inward;
    return c;
}

Convex round_core(Convex::Core core, const Eigen::Vector3d& size, double extent, const Eigen::Vector3d& centre,
                  double inner)
{
    Convex c;
    c.core = core, c.flat_sided = false;
    c.low = -size, c.high = size;
    c.extent = extent * outward, c.centre = centre, c.inner = inner * inward;
    return c;
}

/// Sets the sphere around the mean of the surface's corners that no facet's plane cuts, rounding included: the normal
/// of a sliver errs by about the product's rounding over its length.
void set_inner_sphere(Convex& hull, const Mesh& surface)
{
    hull.centre.setZero();
    for (const Triangle& t : surface.triangles)
        for (std::uint32_t v : t) hull.centre += surface.vertices[v] / (3.0 * double(surface.triangles.size()));
    double least = infinity;
    for (const Triangle& t : surface.triangles) {
        const Eigen::Vector3d& p = surface.vertices[t[0]];
        const Eigen::Vector3d u = surface.vertices[t[1]] - p, v = surface.vertices[t[2]] - p, n = u.cross(v);
        const double length = n.norm();
        const double rounding = 0x1p-48 * hull.extent * (1 + u.norm() * v.norm() / length);
        least = std::min(least, n.dot(p - hull.centre) / length - rounding);
        if (!(least > 0)) return; // also if NaN
    }
    hull.inner = least * inward;
}

struct OfShape {
    Convex operator()(const Sphere& s) const
    {
        return box_core(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), s.radius);
    }
    Convex operator()(const Box& b) const { return box_core(-b.half, b.half); }
    Convex operator()(const Capsule& c) const
    {
        const Eigen::Vector3d end(0, 0, 0.5 * c.length);
        return box_core(-end, end, c.radius);
    }
    Convex operator()(const Cylinder& c) const
    {
        const double half = 0.5 * c.length;
        return round_core(Convex::Core::cylinder, {c.radius, c.radius, half}, std::hypot(c.radius, half),
                          Eigen::Vector3d::Zero(), std::min(c.radius, half));
    }
    Convex operator()(const Ellipsoid& e) const
    {
        return round_core(Convex::Core::ellipsoid, e.semi_axes, e.semi_axes.maxCoeff(), Eigen::Vector3d::Zero(),
                          e.semi_axes.minCoeff());
    }
    Convex operator()(const Cone& c) const
    {
        const double half = 0.5 * c.length, slope = std::hypot(c.radius, c.length);
        const double inner = c.radius / (c.radius + slope) * c.length;
        return round_core(Convex::Core::cone, {c.radius, c.radius, half}, std::hypot(c.radius, half),
                          {0, 0, inner - half}, inner);
    }
    Convex operator()(const ConvexHull&) const { return {}; } // not called
    Convex operator()(const HalfSpace&) const { return {}; }  // not called
};

} // namespace

bool Convex::holds(const Eigen::Vector3d& p, double ball) const
{
    const double across2 = p.x() * p.x() + p.y() * p.y();
    switch (core) {
    case Core::box: {
        if (radius == 0) return (p - low).minCoeff() > ball && (high - p).minCoeff() > ball;
        const double within = radius - ball;
        return within > 0 && (p - p.cwiseMax(low).cwiseMin(high)).squaredNorm() < within * within;
    }
    case Core::points:
        return false; // the test would cost as much as it saves
    case Core::cylinder: {
        const double within = high.x() - ball;
        return within > 0 && std::abs(p.z()) < high.z() - ball && across2 < within * within;
    }
    case Core::cone: {
        const double length = 2 * high.z(), within = high.x() * (high.z() - p.z()) - ball * (high.x() + length);
        return within > 0 && p.z() + high.z() > ball && length * length * across2 < within * within;
    }
    case Core::ellipsoid: {
        const double within = 1 - ball / inner;
        return within > 0 && p.cwiseQuotient(high).squaredNorm() < within * within;
    }
    }
    __builtin_unreachable();
}

double Convex::depth(const Eigen::Vector3d& p) const
{
    const double rounding = 0x1p-46 * (extent + radius + p.norm());
    const auto across = [&] { return std::hypot(p.x(), p.y()); };
    switch (core) {
    case Core::box: {
        const double inside = std::min((p - low).minCoeff(), (high - p).minCoeff());
        const double outside = (p - p.cwiseMax(low).cwiseMin(high)).norm();
        return radius + (outside > 0 ? -outside : inside) - rounding;
    }
    case Core::points: {
        double least = infinity;
        for (const Triangle& t : faces) {
            const Eigen::Vector3d &q = points[t[0]], u = points[t[1]] - q, v = points[t[2]] - q, n = u.cross(v);
            const double length = n.norm();
            // The normal of a sliver errs by about the product's rounding over its length.
            const double off = rounding * (1 + u.norm() * v.norm() / length);
            if (length > 0) least = std::min(least, n.dot(q - p) / length - off);
        }
        return least < infinity ? least : -infinity;
    }
    case Core::cylinder:
        return std::min(high.x() - across(), high.z() - std::abs(p.z())) - rounding;
    case Core::cone: {
        const double length = 2 * high.z(), slope = std::hypot(high.x(), length);
        const double side = (high.x() * (high.z() - p.z()) - length * across()) / slope;
        return std::min(side, p.z() + high.z()) - rounding;
    }
    case Core::ellipsoid:
        return (1 - p.cwiseQuotient(high).norm()) * high.minCoeff() - rounding;
    }
    __builtin_unreachable();
}

Convex convex_of(const Shape& shape)
{
    return std::visit(OfShape{}, shape);
}

Convex convex_of_hull(const Mesh& surface)
{
    Convex c;
    c.core = Convex::Core::points;
    c.points = surface.vertices.data(), c.count = static_cast<std::uint32_t>(surface.vertices.size());
    c.faces = surface.triangles;
    for (const Eigen::Vector3d& p : surface.vertices) c.extent = std::max(c.extent, p.norm() * outward);
    set_inner_sphere(c, surface);
    return c;
}

Convex convex_of(const Aabb& box)
{
    return box_core(box.min, box.max);
}

Convex convex_of(const std::array<Eigen::Vector3d, 3>& triangle)
{
    Convex c;
    c.core = Convex::Core::points;
    static constexpr Triangle face{0, 1, 2};
    c.points = triangle.data(), c.count = 3, c.faces = {&face, 1};
    for (const Eigen::Vector3d& p : triangle) c.extent = std::max(c.extent, p.norm() * outward);
    c.centre = (triangle[0] + triangle[1] + triangle[2]) / 3;
    return c;
}

} // namespace oncollide
