#include <oncollide/samples/varied_shapes.hpp>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide {

using Eigen::Quaterniond;
using Eigen::Vector3d;

double ShapeDice::between(double least, double most)
{
    return least + (most - least) * u01(seed_, number_, drawn_++);
}

Vector3d ShapeDice::direction()
{
    while (true) {
        const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        const Vector3d p(x, y, z);
        if (p.norm() > 0.1 && p.norm() <= 1) return p.normalized();
    }
}

Quaterniond ShapeDice::rotation()
{
    Eigen::Vector4d q;
    for (int k = 0; k < 4; ++k) q[k] = between(-1, 1);
    return Quaterniond(q.normalized());
}

Quaterniond ShapeDice::tilt(double angle)
{
    const double by = between(-angle, angle);
    return Quaterniond(Eigen::AngleAxisd(by, direction()));
}

const char* name_of(ShapeKind kind)
{
    constexpr const char* names[] = {"sphere", "box", "capsule", "hull", "cylinder", "cone", "ellipsoid"};
    return names[static_cast<int>(kind)];
}

Shape draw_shape(ShapeKind kind, ShapeDice& dice, int points)
{
    const double x = dice.between(0.08, 0.2), y = dice.between(0.08, 0.2), z = dice.between(0.08, 0.2);
    const double length = dice.between(0.1, 0.35);
    switch (kind) {
    case ShapeKind::sphere:
        return Sphere{x};
    case ShapeKind::box:
        return Box{{x, y, z}};
    case ShapeKind::capsule:
        return Capsule{0.6 * x, length};
    case ShapeKind::cylinder:
        return Cylinder{0.8 * x, length};
    case ShapeKind::cone:
        return Cone{x, length};
    case ShapeKind::ellipsoid:
        return Ellipsoid{{x, y, z}};
    case ShapeKind::hull:
        break;
    }
    ConvexHull hull;
    if (points == 0) points = 8 + static_cast<int>(dice.below(53));
    for (int k = 0; k < points; ++k) hull.points.push_back(dice.direction().cwiseProduct(Vector3d(x, y, z)));
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& p : hull.points) middle += p / points;
    for (Vector3d& p : hull.points) p -= middle; // the origin is inside
    return hull;
}

} // namespace oncollide
