#include <oncollide/narrowphase/exact/triangle_distance.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/base/simd/cpu_features.hpp>

namespace oncollide {

using Eigen::Vector3d;

MeasurePairs* measure_pairs(std::size_t pairs)
{
    static MeasurePairs *const many = ONCOLLIDE_CHOOSE(measure_pairs), *const few =
                                                                           ONCOLLIDE_CHOOSE_TO_AVX2(measure_pairs);
    return pairs > 4 ? many : few;
}

NearestPoints nearest_points(std::span<const TrianglePoints> a, const TrianglePoints& b)
{
    NearestPoints nearest{{}, {}, std::numeric_limits<double>::infinity()};
    for (; !a.empty(); a = a.subspan(std::min<std::size_t>(8, a.size()))) {
        const auto count = static_cast<unsigned>(std::min<std::size_t>(8, a.size()));
        CornersOfPairs corners;
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t i = 0; i < 8; ++i)
                corners.a[k][i] = a[std::min<std::size_t>(i, count - 1)][k].data(), corners.b[k][i] = b[k].data();
        constexpr double turn[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, shift[3] = {0, 0, 0};
        NearestOfPairs found;
        measure_pairs(count)(corners, turn, shift, count, found);
        for (unsigned i = 0; i < count; ++i)
            if (const NearestPoints points = points_of(found, i); points.distance < nearest.distance) nearest = points;
    }
    return nearest;
}

NearestPoints nearest_points(const TrianglePoints& a, const TrianglePoints& b)
{
    return nearest_points(std::span(&a, 1), b);
}

double triangle_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    return nearest_points(a, b).distance;
}

double squared_distance(const Vector3d& point, const TrianglePoints& t)
{
    const Vector3d u = t[1] - t[0], v = t[2] - t[0], w = t[2] - t[1];
    const Vector3d from0 = point - t[0], from1 = point - t[1], from2 = point - t[2];
    const double u0 = u.dot(from0), v0 = v.dot(from0), u1 = u.dot(from1), v1 = v.dot(from1), u2 = u.dot(from2),
                 v2 = v.dot(from2);
    if (u0 <= 0 && v0 <= 0) return from0.squaredNorm();
    if (u1 >= 0 && v1 <= u1) return from1.squaredNorm();
    if (v2 >= 0 && u2 <= v2) return from2.squaredNorm();
    if (u0 >= 0 && u1 < 0 && u0 * v1 <= u1 * v0) return (from0 - u0 / (u0 - u1) * u).squaredNorm();
    if (v0 >= 0 && v2 < 0 && u2 * v0 <= u0 * v2) return (from0 - v0 / (v0 - v2) * v).squaredNorm();
    const double w1 = v1 - u1, w2 = u2 - v2; // along w, from its two ends
    if (w1 > 0 && w2 > 0 && u1 * v2 <= u2 * v1) return (from1 - w1 / (w1 + w2) * w).squaredNorm();
    const Vector3d n = u.cross(v);
    const double n2 = n.squaredNorm(), height = n.dot(from0);
    if (n2 > 0x1p-40 * u.squaredNorm() * v.squaredNorm()) return height * height / n2;
    return std::min(from0.squaredNorm(), std::min(from1.squaredNorm(), from2.squaredNorm()));
}

double corner_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : a)
        for (const Vector3d& q : b) least = std::min(least, (p - q).squaredNorm());
    return std::sqrt(least);
}

} // namespace oncollide
