#include <oncollide/narrowphase/pairs/manifolds/points/support_points.hpp>

#include <cmath>

#include <oncollide/narrowphase/pairs/manifolds/points/manifold_limits.hpp>

namespace oncollide {

using Eigen::Vector3d;

std::vector<Vector3d> support_points(const Convex& c, const Vector3d& d)
{
    const Vector3d out = c.radius * d.normalized();
    const double across = std::hypot(d.x(), d.y());
    const Vector3d side =
        across > manifold_limits::least_across ? Vector3d(d.x() / across, d.y() / across, 0) : Vector3d::UnitX();
    const auto disc = [&](double radius, double z, std::vector<Vector3d>& to) {
        const Vector3d next(-side.y(), side.x(), 0);
        for (const Vector3d& at : {side, next, Vector3d(-side), Vector3d(-next)})
            to.emplace_back(radius * at.x(), radius * at.y(), z);
    };
    std::vector<Vector3d> points;
    switch (c.core) {
    case Convex::Core::box: // a sphere or a capsule
        points.push_back(c.support(d) + out);
        if (c.low != c.high) points.push_back(c.low + c.high - c.support(d) + out);
        break;
    case Convex::Core::cylinder: {
        const double z = d.z() < 0 ? -c.high.z() : c.high.z();
        disc(c.high.x(), z, points);
        points.emplace_back(c.high.x() * side.x(), c.high.x() * side.y(), -z);
        break;
    }
    case Convex::Core::cone:
        disc(c.high.x(), -c.high.z(), points);
        points.emplace_back(0, 0, c.high.z());
        break;
    case Convex::Core::points:
    case Convex::Core::ellipsoid:
        points.push_back(c.support(d));
    }
    return points;
}

} // namespace oncollide
