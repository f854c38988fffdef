#include "bench/narrow/shape_pairs.hpp"

#include <cmath>

#include <oncollide/base/numbers/random.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A sequence of random numbers for one object.
class Lot {
public:
    Lot(std::uint64_t seed, std::uint64_t number) : seed_(seed), number_(number) {}
    double next() { return u01(seed_, number_, drawn_++); }
    double between(double least, double most) { return least + (most - least) * next(); }
    double spread(double least, double most) { return least * std::pow(most / least, next()); }
    Vector3d direction()
    {
        while (true) {
            const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
            const Vector3d p(x, y, z);
            if (p.norm() > 0.1 && p.norm() <= 1) return p.normalized();
        }
    }
    Isometry3d pose()
    {
        Eigen::Vector4d q;
        for (int k = 0; k < 4; ++k) q[k] = between(-0.5, 0.5);
        Isometry3d pose(Eigen::Quaterniond(q.normalized()));
        for (int k = 0; k < 3; ++k) pose.translation()[k] = between(-2, 2);
        return pose;
    }

private:
    std::uint64_t seed_, number_, drawn_ = 0;
};

Shape draw_shape(std::size_t kind, Lot& lot)
{
    const auto size = [&] { return lot.spread(0.1, 1); };
    const double x = size(), y = size(), z = size();
    switch (kind) {
    case 0:
        return Sphere{x};
    case 1:
        return Box{{x, y, z}};
    case 2:
        return Capsule{x, y};
    case 3:
        return Cylinder{x, y};
    case 4: {
        ConvexHull hull;
        for (int k = 8 + int(24 * lot.next()); k > 0; --k)
            hull.points.push_back(lot.direction().cwiseProduct(Vector3d(x, y, z)));
        return hull;
    }
    case 5:
        return Ellipsoid{{x, y, z}};
    case 6:
        return Cone{x, y};
    default:
        return HalfSpace{};
    }
}

/// The body's support point along the unit vector u.
Vector3d farthest(const RacedShape& shape, const Isometry3d& pose, const Vector3d& u)
{
    if (shape.model->kind() == Kind::half_space) return pose.translation(); // u is its normal
    const Convex& c = shape.model->convex();
    return pose * c.support(pose.linear().transpose() * u) + c.radius * u;
}

} // namespace

ClosePairs::ClosePairs(std::uint64_t seed, double least_gap) : seed_(seed), least_gap_(least_gap)
{
    for (std::size_t kind = 0; kind < shape_kinds.size(); ++kind)
        for (std::size_t k = 0; k < of_a_kind; ++k) {
            Lot lot(seed + 1, kind * of_a_kind + k);
            const auto geometry =
                std::make_shared<const Geometry>(Geometry{std::string(shape_kinds[kind]), draw_shape(kind, lot), {}});
            shapes_.push_back({std::make_unique<Model>(geometry), make_fcl_geometry(geometry->data, FclNodes::obb)});
        }
}

ClosePair ClosePairs::draw(std::uint64_t number) const
{
    Lot lot(seed_, number);
    const auto kind = [&] { return int(lot.next() * double(shape_kinds.size())); };
    int kind_a = kind(), kind_b = kind();
    constexpr int half_space = 7;
    while (kind_a == half_space && kind_b == half_space) kind_b = kind();
    if (kind_a > kind_b) std::swap(kind_a, kind_b);
    const auto one = [&](int k) { return &shapes_[std::size_t(k) * of_a_kind + std::size_t(lot.next() * of_a_kind)]; };
    ClosePair pair{one(kind_a), one(kind_b), kind_a, kind_b, lot.pose(), lot.pose()};
    const Vector3d u = kind_b == half_space ? Vector3d(-pair.pose_b.linear().col(2)) : lot.direction();
    const double gap = lot.spread(least_gap_, 0.1) * (lot.next() < 0.5 ? -1 : 1);
    // B begins at `gap` beyond A's support point along u.
    pair.pose_b.translation() += farthest(*pair.a, pair.pose_a, u) + gap * u - farthest(*pair.b, pair.pose_b, -u);
    return pair;
}

} // namespace oncollide::tools
