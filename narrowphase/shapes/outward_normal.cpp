#include <oncollide/narrowphase/shapes/outward_normal.hpp>

#include <cmath>
#include <limits>

namespace oncollide {

namespace {

using Eigen::Vector3d;

/// v normalised; 0 if v is 0.
Vector3d direction(const Vector3d& v)
{
    const double length = v.stableNorm();
    return length > 0 ? Vector3d(v / length) : Vector3d(Vector3d::Zero());
}

/// The normal of the plane with the largest height, that is, the plane that the point is least far below.
class Shallowest {
public:
    void take(double height, const Vector3d& normal)
    {
        if (height > height_) height_ = height, normal_ = normal;
    }
    const Vector3d& normal() const { return normal_; }

private:
    double height_ = -std::numeric_limits<double>::infinity();
    Vector3d normal_ = Vector3d::UnitZ();
};

Vector3d of_box(const Convex& box, const Vector3d& p)
{
    if (box.radius > 0)
        return direction(p - p.cwiseMax(box.low).cwiseMin(box.high)); // the core is a point or a segment
    Shallowest best;
    for (int i = 0; i < 3; ++i) {
        best.take(p[i] - box.high[i], Vector3d::Unit(i));
        best.take(box.low[i] - p[i], -Vector3d::Unit(i));
    }
    return best.normal();
}

Vector3d of_hull(const Convex& hull, const Vector3d& p)
{
    Shallowest best;
    for (const Triangle& face : hull.faces) {
        const Vector3d &a = hull.points[face[0]], &b = hull.points[face[1]], &c = hull.points[face[2]];
        const Vector3d normal = direction((b - a).cross(c - a));
        best.take(normal.dot(p - a), normal);
    }
    return best.normal();
}

} // namespace

Vector3d outward_normal(const Convex& solid, const Vector3d& p)
{
    const double across = std::hypot(p.x(), p.y());
    const Vector3d sideways = across > 0 ? Vector3d(p.x() / across, p.y() / across, 0) : Vector3d(Vector3d::UnitX());
    Shallowest best;
    switch (solid.core) {
    case Convex::Core::box:
        return of_box(solid, p);
    case Convex::Core::points:
        return of_hull(solid, p);
    case Convex::Core::ellipsoid:
        return direction(p.cwiseQuotient(solid.high).cwiseQuotient(solid.high));
    case Convex::Core::cylinder:
        best.take(across - solid.high.x(), sideways);
        best.take(p.z() - solid.high.z(), Vector3d::UnitZ());
        best.take(-p.z() - solid.high.z(), -Vector3d::UnitZ());
        return best.normal();
    case Convex::Core::cone: {
        const Vector3d side = direction(2 * solid.high.z() * sideways + solid.high.x() * Vector3d::UnitZ());
        best.take(side.dot(p - Vector3d(0, 0, solid.high.z())), side);
        best.take(-p.z() - solid.high.z(), -Vector3d::UnitZ());
        return best.normal();
    }
    }
    __builtin_unreachable();
}

} // namespace oncollide
