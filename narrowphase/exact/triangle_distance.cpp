#include <oncollide/narrowphase/exact/triangle_distance.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/base/cpu_features.hpp>

namespace oncollide {

using Eigen::Vector3d;

MeasurePairs* measure_pairs()
{
    static MeasurePairs* const kernel = ONCOLLIDE_CHOOSE(measure_pairs);
    return kernel;
}

NearestPoints nearest_points(const TrianglePoints& a, const TrianglePoints& b)
{
    CornersOfPairs corners;
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 8; ++i) corners.a[k][i] = a[k].data(), corners.b[k][i] = b[k].data();
    constexpr double stay[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    NearestOfPairs nearest;
    measure_pairs()(corners, stay, stay + 1, 1, nearest);
    return points_of(nearest, 0);
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
