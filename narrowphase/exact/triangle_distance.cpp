#include <oncollide/narrowphase/exact/triangle_distance.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/narrowphase/exact/exact_nearest.hpp>

namespace oncollide {

using Eigen::Vector3d;

namespace {

TrianglePoints triangle(const double* const (&corners)[3][8], unsigned i)
{
    TrianglePoints points;
    for (std::size_t k = 0; k < 3; ++k) points[k] = Eigen::Map<const Vector3d>(corners[k][i]);
    return points;
}

} // namespace

void measure_pairs(const CornersOfPairs& corners, const RelativePose& b_to_a, unsigned pairs, double rounding,
                   NearestOfPairs& out)
{
    static MeasurePairs *const many = ONCOLLIDE_CHOOSE(measure_pairs), *const few =
                                                                           ONCOLLIDE_CHOOSE_TO_AVX2(measure_pairs);
    unsigned unsure =
        (pairs > 4 ? many : few)(corners, b_to_a.rotation.data(), b_to_a.translation.data(), pairs, rounding, out);
    for (; unsure; unsure &= unsure - 1) {
        const auto i = static_cast<unsigned>(std::countr_zero(unsure));
        const TrianglePoints a = triangle(corners.a, i);
        TrianglePoints b = triangle(corners.b, i);
        for (Vector3d& p : b) p = b_to_a(p);
        if (triangles_meet(a, b)) continue; // their nearest points have no meaning
        const NearestPoints exact = exact_nearest_points(a, b);
        for (int k = 0; k < 3; ++k) out.a[k][i] = exact.a[k], out.b[k][i] = exact.b[k];
        out.distance2[i] = exact.distance * exact.distance;
    }
}

double usual_rounding(const TrianglePoints& a, const TrianglePoints& b)
{
    Vector3d low = a[0], high = a[0];
    for (const TrianglePoints* t : {&a, &b})
        for (const Vector3d& p : *t) low = low.cwiseMin(p), high = high.cwiseMax(p);
    return 0x1p-40 * (high - low).maxCoeff() + 0x1p-49 * std::max(high.maxCoeff(), -low.minCoeff());
}

NearestPoints nearest_points(std::span<const TrianglePoints> a, const TrianglePoints& b, double rounding)
{
    static const RelativePose here(Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
    NearestPoints nearest{{}, {}, std::numeric_limits<double>::infinity()};
    for (; !a.empty(); a = a.subspan(std::min<std::size_t>(8, a.size()))) {
        const auto count = static_cast<unsigned>(std::min<std::size_t>(8, a.size()));
        CornersOfPairs corners;
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t i = 0; i < 8; ++i)
                corners.a[k][i] = a[std::min<std::size_t>(i, count - 1)][k].data(), corners.b[k][i] = b[k].data();
        NearestOfPairs found;
        measure_pairs(corners, here, count, rounding, found);
        for (unsigned i = 0; i < count; ++i)
            if (const NearestPoints points = points_of(found, i); points.distance < nearest.distance) nearest = points;
    }
    return nearest;
}

NearestPoints nearest_points(const TrianglePoints& a, const TrianglePoints& b, double rounding)
{
    return nearest_points(std::span(&a, 1), b, rounding);
}

double triangle_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    return nearest_points(a, b, usual_rounding(a, b)).distance;
}

OnTriangle nearest_on(const TrianglePoints& t, const Vector3d& p)
{
    const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0], bp = p - t[1], cp = p - t[2];
    const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d1 <= 0 && d2 <= 0) return {t[0], 1};
    if (d3 >= 0 && d4 <= d3) return {t[1], 2};
    if (d6 >= 0 && d5 <= d6) return {t[2], 4};
    const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {t[0] + d1 / (d1 - d3) * ab, 3};
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {t[0] + d2 / (d2 - d6) * ac, 5};
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {t[1] + (d4 - d3) / (d4 - d3 + (d5 - d6)) * (t[2] - t[1]), 6};
    const double sum = va + vb + vc;
    if (!(sum > 0)) return {t[0], 1}; // no area, to rounding: still a point of the triangle
    return {t[0] + vb / sum * ab + vc / sum * ac, 7};
}

double corner_distance(const TrianglePoints& a, const TrianglePoints& b)
{
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& p : a)
        for (const Vector3d& q : b) least = std::min(least, (p - q).squaredNorm());
    return std::sqrt(least);
}

} // namespace oncollide
