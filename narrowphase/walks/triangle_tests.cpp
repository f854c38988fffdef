#include <oncollide/narrowphase/walks/triangle_tests.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/exact/triangle_gap.hpp>

namespace oncollide {

template <class A, class B>
void TriangleTestsOf<A, B>::start(const A& a, const B& b, const RelativePose& b_to_a)
{
    b_to_a_ = &b_to_a;
    a_.start(a), b_.start(b);
    barely_apart_.clear(), met_ = false;
    std::fill(std::begin(nearest2_), std::end(nearest2_), std::numeric_limits<double>::infinity());
}

template <class A, class B>
double TriangleTestsOf<A, B>::least_gap(double rounding) const
{
    double least = std::sqrt(*std::ranges::min_element(nearest2_)) * (1 - 0x1p-50);
    // Surfaces that nearly coincide have thousands of such pairs, which are too near for their exact gaps to matter.
    constexpr int most_exact_gaps = 64;
    int exact_gaps = 0;
    for (const TrianglePair& pair : barely_apart_) {
        const TrianglePoints a = points_a(pair.a), b = points_b(pair.b);
        const double gap = nearest_points(a, b, 0.5 * rounding).distance - rounding;
        if (gap > 0)
            least = std::min(least, gap);
        else
            least = std::min(least, exact_gaps++ < most_exact_gaps ? triangle_gap(a, b) : least_possible_gap(a, b));
    }
    return least;
}

template <class A, class B>
unsigned TriangleTestsOf<A, B>::segments(std::span<const TrianglePair> pairs, const RigidMap& place,
                                         SegmentsOfPairs& out)
{
    const RigidMap b_to_a{b_to_a_->rotation.data(), b_to_a_->translation.data()};
    return common_segments()(corners_of(pairs), b_to_a, place, out);
}

template <class A, class B>
NearestPoints TriangleTestsOf<A, B>::nearest(TrianglePair pair, double rounding)
{
    ++counts.tested;
    return nearest_points(points_a(pair.a), points_b(pair.b), rounding);
}

template <class A, class B>
double TriangleTestsOf<A, B>::most(TrianglePair pair) const
{
    return corner_distance(points_a(pair.a), points_b(pair.b));
}

template class TriangleTestsOf<ObbTree, ObbTree>;
template class TriangleTestsOf<TerrainTree, ObbTree>;
template class TriangleTestsOf<ObbTree, TerrainTree>;
template class TriangleTestsOf<TerrainTree, TerrainTree>;

} // namespace oncollide
