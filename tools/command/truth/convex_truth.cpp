#include "truth/convex_truth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/LU>

namespace oncollide::tools {
namespace {

using Vec = ExtendedVector;
using Real = long double;

/// The point nearest to the origin in the hull of at most four points, and the points that span its face.
struct NearestPoint {
    Vec point;
    std::vector<Vec> simplex;
};

/// Tries the relative interiors of all faces of the simplex.
NearestPoint nearest_to_origin(const std::vector<Vec>& points)
{
    NearestPoint best{Vec::Zero(), {}};
    Real least = std::numeric_limits<Real>::infinity();
    for (unsigned face = 1; face < 1u << points.size(); ++face) {
        std::vector<Vec> corners;
        for (std::size_t i = 0; i < points.size(); ++i)
            if (face >> i & 1) corners.push_back(points[i]);
        const auto n = static_cast<Eigen::Index>(corners.size()) - 1;
        Eigen::Matrix<Real, 3, Eigen::Dynamic> edges(3, n);
        for (Eigen::Index i = 0; i < n; ++i) edges.col(i) = corners[std::size_t(i) + 1] - corners[0];
        Eigen::Matrix<Real, Eigen::Dynamic, 1> weights(n);
        if (n > 0) {
            const Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> squares = edges.transpose() * edges;
            const Eigen::FullPivLU<Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>> lu(squares);
            if (!lu.isInvertible()) continue;
            weights = lu.solve(-edges.transpose() * corners[0]);
            if (weights.minCoeff() < 0 || weights.sum() > 1) continue;
        }
        const Vec point = corners[0] + edges * weights;
        if (point.norm() < least) least = point.norm(), best = {point, corners};
    }
    return best;
}

ConvexSet hull_of(std::vector<Vec> points)
{
    return [points = std::move(points)](const Vec& direction) {
        return *std::ranges::max_element(points, {}, [&](const Vec& p) { return p.dot(direction); });
    };
}

/// The point of a circle around z that is extreme along a direction.
Vec on_rim(Real radius, Real z, const Vec& direction)
{
    const Real across = std::hypot(direction.x(), direction.y());
    if (!(across > 0)) return {0, 0, z};
    return {radius * direction.x() / across, radius * direction.y() / across, z};
}

struct SetOfShape {
    Eigen::Isometry3d pose;

    /// @param local  the support function in the shape's frame
    ConvexSet placed(auto local) const
    {
        const Eigen::Matrix<Real, 3, 3> turn = pose.linear().cast<Real>();
        const Vec at = pose.translation().cast<Real>();
        return [=](const Vec& direction) -> Vec { return turn * local(Vec(turn.transpose() * direction)) + at; };
    }
    ConvexSet corners(std::span<const Eigen::Vector3d> points) const
    {
        std::vector<Vec> moved;
        for (const Eigen::Vector3d& p : points)
            moved.push_back(pose.linear().cast<Real>() * p.cast<Real>() + pose.translation().cast<Real>());
        return hull_of(std::move(moved));
    }
    ConvexSet operator()(const Box& b) const { return corners(corners_of({-b.half, b.half})); }
    ConvexSet operator()(const ConvexHull& h) const { return corners(h.points); }
    ConvexSet operator()(const Sphere& s) const { return (*this)(Capsule{s.radius, 0}); }
    ConvexSet operator()(const Capsule& c) const
    {
        const Eigen::Vector3d half(0, 0, 0.5 * c.length);
        return [axis = corners(std::array<Eigen::Vector3d, 2>{-half, half}), radius = Real(c.radius)](
                   const Vec& direction) -> Vec { return axis(direction) + radius * direction.normalized(); };
    }
    ConvexSet operator()(const Cylinder& c) const
    {
        return placed([radius = Real(c.radius), half = Real(c.length) / 2](const Vec& direction) {
            return on_rim(radius, direction.z() < 0 ? -half : half, direction);
        });
    }
    ConvexSet operator()(const Ellipsoid& e) const
    {
        return placed([axes = Vec(e.semi_axes.cast<Real>())](const Vec& direction) -> Vec {
            return axes.cwiseProduct(axes.cwiseProduct(direction).normalized());
        });
    }
    ConvexSet operator()(const Cone& c) const
    {
        return placed([radius = Real(c.radius), half = Real(c.length) / 2](const Vec& direction) {
            const Vec apex(0, 0, half), rim = on_rim(radius, -half, direction);
            return apex.dot(direction) > rim.dot(direction) ? apex : rim;
        });
    }
    /// A bounded piece of it, large compared with any random scene.
    ConvexSet operator()(const HalfSpace&) const { return corners(corners_of({{-256, -256, -256}, {256, 256, 0}})); }
};

} // namespace

std::array<Eigen::Vector3d, 8> corners_of(const Aabb& box)
{
    std::array<Eigen::Vector3d, 8> corners;
    for (unsigned k = 0; k < 8; ++k)
        for (int i = 0; i < 3; ++i) corners[k][i] = (k >> i & 1 ? box.max : box.min)[i];
    return corners;
}

TrueDistance convex_distance(const ConvexSet& a, const ConvexSet& b)
{
    const auto support = [&](const Vec& direction) -> Vec { return a(-direction) - b(direction); };
    NearestPoint nearest{support(Vec(1, 0, 0)), {}};
    nearest.simplex = {nearest.point};
    TrueDistance distance{0, nearest.point.norm()};
    for (int step = 0; step < 500 && distance.upper > 0; ++step) {
        const Vec next = support(nearest.point.normalized());
        distance.lower = std::max(distance.lower, next.dot(nearest.point.normalized()));
        if (distance.upper - distance.lower < 1e-17L * next.norm()) break;
        if (std::ranges::find(nearest.simplex, next) != nearest.simplex.end()) break;
        std::vector<Vec> simplex = nearest.simplex;
        simplex.push_back(next);
        NearestPoint better = nearest_to_origin(simplex);
        if (!(better.point.norm() < distance.upper)) break;
        nearest = std::move(better);
        distance.upper = nearest.point.norm();
        if (nearest.simplex.size() == 4) return {0, 0};
    }
    return distance;
}

std::vector<ConvexSet> convex_sets(const GeometryData& geometry, const Eigen::Isometry3d& pose, const Aabb* near)
{
    const SetOfShape of{pose};
    std::vector<ConvexSet> sets;
    const auto add = [&](const Aabb& box, std::span<const Eigen::Vector3d> points) {
        if (!near || near->overlaps(box)) sets.push_back(of.corners(points));
    };
    const auto add_triangles = [&](const Mesh& mesh) {
        for (const Triangle& t : mesh.triangles) {
            const std::array points{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
            Aabb box;
            for (const Eigen::Vector3d& p : points) box.add(p);
            add(box, points);
        }
    };
    if (const auto* mesh = std::get_if<Mesh>(&geometry)) {
        add_triangles(*mesh);
    } else if (const auto* terrain = std::get_if<Terrain>(&geometry)) {
        add_triangles(mesh_of(*terrain));
    } else if (const auto* shape = std::get_if<Shape>(&geometry)) {
        sets.push_back(std::visit(of, *shape));
    } else {
        std::get<OccupancyMap>(geometry).each_box([&](const Aabb& cell) { add(cell, corners_of(cell)); });
    }
    return sets;
}

TrueDistance half_space_distance(const Eigen::Isometry3d& half_space, const std::vector<ConvexSet>& sets)
{
    const Vec normal = half_space.linear().col(2).cast<Real>(), at = half_space.translation().cast<Real>();
    Real least = std::numeric_limits<Real>::infinity();
    for (const ConvexSet& set : sets) least = std::min(least, normal.dot(set(-normal) - at) / normal.norm());
    least = std::max<Real>(least, 0);
    return {least, least};
}

TrueDistance half_spaces_distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b)
{
    const Vec up = a.linear().col(2).cast<Real>(), down = b.linear().col(2).cast<Real>();
    if (up != -down) return {0, 0};
    const Real gap = up.dot(b.translation().cast<Real>() - a.translation().cast<Real>());
    return {std::max<Real>(gap, 0), std::max<Real>(gap, 0)};
}

namespace {

struct Boxed {
    const ConvexSet* set;
    Vec low, high;
};

std::vector<Boxed> boxed(const std::vector<ConvexSet>& sets)
{
    std::vector<Boxed> all;
    for (const ConvexSet& set : sets) {
        Boxed& b = all.emplace_back(Boxed{&set, Vec::Zero(), Vec::Zero()});
        for (int i = 0; i < 3; ++i) b.low[i] = set(-Vec::Unit(i))[i], b.high[i] = set(Vec::Unit(i))[i];
    }
    return all;
}

Real gap(const Boxed& a, const Boxed& b)
{
    return (a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(Vec::Zero()).norm();
}

/// Keeps only the sets within `farthest` of the union of `others`.
void keep_near(std::vector<Boxed>& sets, const std::vector<Boxed>& others, Real farthest)
{
    Boxed all = others.front();
    for (const Boxed& b : others) all.low = all.low.cwiseMin(b.low), all.high = all.high.cwiseMax(b.high);
    std::erase_if(sets, [&](const Boxed& b) { return gap(b, all) > farthest; });
}

} // namespace

TrueDistance true_distance(const std::vector<ConvexSet>& a, const std::vector<ConvexSet>& b)
{
    std::vector<Boxed> boxed_a = boxed(a), boxed_b = boxed(b);
    // An upper bound: the distance of a part of B to the part of A with the nearest AABB.
    const Boxed& one = boxed_b.front();
    const auto nearest = std::ranges::min_element(boxed_a, {}, [&](const Boxed& x) { return gap(x, one); });
    TrueDistance least = convex_distance(*nearest->set, *one.set);
    const Real slack = 1e-15L * (one.high.cwiseAbs().maxCoeff() + nearest->high.cwiseAbs().maxCoeff());
    keep_near(boxed_a, boxed_b, least.upper + slack), keep_near(boxed_b, boxed_a, least.upper + slack);
    for (const Boxed& x : boxed_a)
        for (const Boxed& y : boxed_b) {
            if (gap(x, y) > least.upper + slack) continue;
            const TrueDistance d = convex_distance(*x.set, *y.set);
            least = {std::min(least.lower, d.lower), std::min(least.upper, d.upper)};
            if (least.upper == 0) return least;
        }
    return least;
}

} // namespace oncollide::tools
