#include "truth/truth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "truth/exact_oracle.hpp"
#include "truth/triangle_distance.hpp"

namespace oncollide::tools {
namespace {

using Matrix3l = Eigen::Matrix<long double, 3, 3>;

/// True if an edge of `of` pierces t, by `spare` in each direction.
bool pierced(const TrianglePoints& t, const TrianglePoints& of, double spare)
{
    const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    if (!(normal.norm() > 0.5)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3d &p = of[k], &q = of[(k + 1) % 3];
        const double x = normal.dot(p - t[0]), y = normal.dot(q - t[0]);
        if (std::abs(x) < spare || std::abs(y) < spare || (x > 0) == (y > 0)) continue;
        const Eigen::Vector3d at = p + x / (x - y) * (q - p);
        bool inside = true;
        for (std::size_t i = 0; i < 3; ++i)
            inside &= normal.cross(t[(i + 1) % 3] - t[i]).normalized().dot(at - t[i]) > spare;
        if (inside) return true;
    }
    return false;
}

/// True if a plane parallel to a face or to two edges separates them with a gap wider than `least`.
bool surely_parted(const TrianglePoints& p, const TrianglePoints& q, double least)
{
    const auto edge = [](const TrianglePoints& t, std::size_t k) -> Eigen::Vector3d { return t[(k + 1) % 3] - t[k]; };
    for (const TrianglePoints* t : {&p, &q})
        if (parted<double>(p, q, edge(*t, 0).cross(edge(*t, 1))) > least) return true;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            if (parted<double>(p, q, edge(p, i).cross(edge(q, j))) > least) return true;
    return false;
}

Eigen::Vector3d nearest_corners(const TrianglePoints& p, const TrianglePoints& q)
{
    Eigen::Vector3d nearest = q[0] - p[0];
    for (const Eigen::Vector3d& of_p : p)
        for (const Eigen::Vector3d& of_q : q)
            if (const Eigen::Vector3d d = of_q - of_p; d.squaredNorm() < nearest.squaredNorm()) nearest = d;
    return nearest;
}

Eigen::AlignedBox<long double, 3> box_of(const TriangleL& t)
{
    Eigen::AlignedBox<long double, 3> box;
    for (const Vector3l& corner : t) box.extend(corner);
    return box;
}

} // namespace

bool cross_deeply(const BoxedTriangles& a, const BoxedTriangles& b)
{
    const double spare = 0x1p-30 * std::max(a.largest(), b.largest());
    double cutoff = 0;
    for_near_pairs(a, b, cutoff, [&](std::uint32_t i, std::uint32_t j) {
        const TrianglePoints p = a.triangle(i), q = b.triangle(j);
        if ((pierced(p, q, spare) || pierced(q, p, spare)) && oracle::contact(p, q) != TriangleContact::separate)
            cutoff = -1;
    });
    return cutoff < 0;
}

TriangleContact contact_of(const BoxedTriangles& a, const BoxedTriangles& b, TriangleContact enough)
{
    const double rounding = 0x1p-46 * std::max(a.largest(), b.largest());
    TriangleContact most = TriangleContact::separate;
    double cutoff = 0;
    for_near_pairs(a, b, cutoff, [&](std::uint32_t i, std::uint32_t j) {
        const TrianglePoints p = a.triangle(i), q = b.triangle(j);
        if (surely_parted(p, q, rounding)) return;
        most = std::max(most, oracle::contact(p, q));
        if (most >= enough) cutoff = -1;
    });
    return most;
}

void for_meeting_triangles(const BoxedTriangles& a, const BoxedTriangles& b,
                           FunctionRef<void(std::uint32_t i, std::uint32_t j)> look)
{
    const double rounding = 0x1p-46 * std::max(a.largest(), b.largest()), cutoff = 0;
    for_near_pairs(a, b, cutoff, [&](std::uint32_t i, std::uint32_t j) {
        const TrianglePoints p = a.triangle(i), q = b.triangle(j);
        if (!surely_parted(p, q, rounding) && oracle::contact(p, q) != TriangleContact::separate) look(i, j);
    });
}

DistanceTruth surface_distance(const HalvedMesh& a, const Eigen::Isometry3d& pose_a, const HalvedMesh& b,
                               const Eigen::Isometry3d& pose_b)
{
    // AABBs in double, relative to a's position; a triangle is transformed again, in long double, when it is tested.
    const Eigen::Vector3d between = pose_b.translation() - pose_a.translation();
    const BoxedTriangles at_a(a, [&](const Eigen::Vector3d& v) { return Eigen::Vector3d(pose_a.linear() * v); });
    const BoxedTriangles at_b(b,
                              [&](const Eigen::Vector3d& v) { return Eigen::Vector3d(pose_b.linear() * v + between); });
    const Matrix3l turn_a = pose_a.linear().cast<long double>(), turn_b = pose_b.linear().cast<long double>();
    const Vector3l between_l = pose_b.translation().cast<long double>() - pose_a.translation().cast<long double>();
    const auto corners = [](const HalvedMesh& m, std::uint32_t triangle, const auto& place) {
        TriangleL t;
        for (std::size_t k = 0; k < 3; ++k)
            t[k] = place(m.mesh->vertices[m.mesh->triangles[triangle][k]].template cast<long double>());
        return t;
    };
    DistanceTruth truth;
    truth.size = std::max(at_a.largest(), at_b.largest());
    const double slack = 0x1p-46 * truth.size;
    constexpr long double far = std::numeric_limits<long double>::infinity();
    long double low = far, high = far;
    double cutoff = std::numeric_limits<double>::infinity();
    for_near_pairs(at_a, at_b, cutoff, [&](std::uint32_t i, std::uint32_t j) {
        const TrianglePoints near_p = at_a.triangle(i), near_q = at_b.triangle(j);
        const Eigen::Vector3d between_corners = nearest_corners(near_p, near_q);
        cutoff = std::min(cutoff, between_corners.norm() + slack);
        if (parted(near_p, near_q, between_corners) > cutoff || surely_parted(near_p, near_q, cutoff)) return;
        const TriangleL p = corners(a, i, [&](const Vector3l& v) { return Vector3l(turn_a * v); });
        const TriangleL q = corners(b, j, [&](const Vector3l& v) { return Vector3l(turn_b * v + between_l); });
        const long double boxes = box_of(p).exteriorDistance(box_of(q));
        if (boxes >= high) return;
        const DistanceRange range = triangle_distance(p, q);
        low = std::min(low, std::max(range.low, boxes)), high = std::min(high, range.high);
        cutoff = std::min(cutoff, double(high) + slack);
    });
    truth.low = double(std::min(low, high)), truth.high = double(high);
    return truth;
}

} // namespace oncollide::tools
