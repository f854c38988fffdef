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

double corner_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : a)
        for (const Vector3d& q : b) least = std::min(least, (p - q).squaredNorm());
    return std::sqrt(least);
}

} // namespace oncollide
