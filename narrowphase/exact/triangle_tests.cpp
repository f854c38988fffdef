#include <oncollide/narrowphase/exact/triangle_tests.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_gap.hpp>

namespace oncollide {

void TriangleTests::start(const ObbTree& a, const ObbTree& b, const RelativePose& b_to_a)
{
    b_to_a_ = &b_to_a;
    vertices_a_ = a.mesh().vertices.data(), vertices_b_ = b.mesh().vertices.data();
    triangles_a_ = a.mesh().triangles.data(), triangles_b_ = b.mesh().triangles.data();
    barely_apart_.clear();
    std::fill(std::begin(nearest2_), std::end(nearest2_), std::numeric_limits<double>::infinity());
}

double TriangleTests::least_gap(double rounding) const
{
    double least = std::numeric_limits<double>::infinity();
    for (const double gap2 : nearest2_) least = std::min(least, std::sqrt(gap2) * (1 - 0x1p-50));
    // Surfaces that nearly coincide have thousands of them, too near each other for their exact gaps to matter.
    constexpr int most_exact_gaps = 64;
    int exact_gaps = 0;
    for (const TrianglePair& pair : barely_apart_) {
        const TrianglePoints a = points_a(pair.a), b = points_b(pair.b);
        const double gap = triangle_distance(a, b) - rounding;
        if (gap > 0)
            least = std::min(least, gap);
        else
            least = std::min(least, exact_gaps++ < most_exact_gaps ? triangle_gap(a, b) : least_possible_gap(a, b));
    }
    return least;
}

double TriangleTests::distance(TrianglePair pair)
{
    ++counts.tested;
    return triangle_distance(points_a(pair.a), points_b(pair.b));
}

NearestPoints TriangleTests::nearest(TrianglePair pair)
{
    ++counts.tested;
    return nearest_points(points_a(pair.a), points_b(pair.b));
}

double TriangleTests::most(TrianglePair pair) const
{
    return corner_distance(points_a(pair.a), points_b(pair.b));
}

} // namespace oncollide
