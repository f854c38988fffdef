#include "body_truth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <oncollide/narrowphase/into_a.hpp>

#include "exact_oracle.hpp"
#include "triangle_distance.hpp"

namespace oncollide::tools {
namespace {

/// A body's triangles somewhere, with their boxes.
template <class Real>
struct Placed {
    using Point = Eigen::Matrix<Real, 3, 1>;
    std::vector<std::array<Point, 3>> triangles;
    std::vector<Eigen::AlignedBox<Real, 3>> boxes;

    template <class Place>
    Placed(const Mesh& mesh, Place place)
    {
        for (const Triangle& t : mesh.triangles) {
            boxes.emplace_back();
            triangles.push_back({place(mesh.vertices[t[0]]), place(mesh.vertices[t[1]]), place(mesh.vertices[t[2]])});
            for (const Point& p : triangles.back()) boxes.back().extend(p);
        }
    }
    Real largest() const
    {
        Real most = 0;
        for (const auto& t : triangles)
            for (const Point& p : t) most = std::max(most, p.cwiseAbs().maxCoeff());
        return most;
    }
};

/// An edge of `of` pierces t, by `spare` in each direction.
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

void find_contact(const Placed<double>& a, const Placed<double>& b, BodyTruth& truth)
{
    const double spare = 0x1p-30 * std::max(a.largest(), b.largest());
    for (std::size_t i = 0; i < a.triangles.size(); ++i)
        for (std::size_t j = 0; j < b.triangles.size(); ++j) {
            if (!a.boxes[i].intersects(b.boxes[j])) continue;
            const TrianglePoints &p = a.triangles[i], &q = b.triangles[j];
            const bool deep = pierced(p, q, spare) || pierced(q, p, spare);
            if (!deep && truth.collide) continue;
            if (oracle::contact(p, q) == TriangleContact::separate) continue;
            truth.collide = true, truth.deep |= deep;
            if (truth.deep) return;
        }
}

void find_distance(const Placed<long double>& a, const Placed<long double>& b, BodyTruth& truth)
{
    constexpr long double far = std::numeric_limits<long double>::infinity();
    long double low = far, high = far;
    for (std::size_t i = 0; i < a.triangles.size(); ++i)
        for (std::size_t j = 0; j < b.triangles.size(); ++j) {
            const long double boxes = a.boxes[i].exteriorDistance(b.boxes[j]);
            if (boxes >= high) continue;
            const DistanceRange range = triangle_distance(a.triangles[i], b.triangles[j]);
            low = std::min(low, std::max(range.low, boxes)), high = std::min(high, range.high);
        }
    truth.low = double(std::min(low, high)), truth.high = double(high);
}

} // namespace

BodyTruth truth_of(const Mesh& a, const Eigen::Isometry3d& pose_a, const Mesh& b, const Eigen::Isometry3d& pose_b)
{
    BodyTruth truth;
    find_contact({a, [](const Eigen::Vector3d& v) { return v; }}, {b, IntoA(pose_a, pose_b)}, truth);

    using Matrix3l = Eigen::Matrix<long double, 3, 3>;
    const Matrix3l turn_a = pose_a.linear().cast<long double>(), turn_b = pose_b.linear().cast<long double>();
    const Vector3l between = pose_b.translation().cast<long double>() - pose_a.translation().cast<long double>();
    const Placed<long double> at_a(a,
                                   [&](const Eigen::Vector3d& v) { return Vector3l(turn_a * v.cast<long double>()); });
    const Placed<long double> at_b(
        b, [&](const Eigen::Vector3d& v) { return Vector3l(turn_b * v.cast<long double>() + between); });
    truth.size = double(std::max(at_a.largest(), at_b.largest()));
    if (truth.deep) return truth;
    find_distance(at_a, at_b, truth);
    if (truth.collide) truth.low = 0;
    return truth;
}

} // namespace oncollide::tools
