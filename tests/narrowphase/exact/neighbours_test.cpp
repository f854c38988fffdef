// How triangles that share corners meet elsewhere, compared with rational arithmetic of another project.
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/neighbours.hpp>

#include "truth/exact_point.hpp"

namespace oncollide::neighbours_test {
namespace {

using Eigen::Vector3d;
using Rational =
    boost::multiprecision::number<boost::multiprecision::cpp_rational_backend, boost::multiprecision::et_off>;
using Point = oracle::PointOf<Rational>;

/// The half-space of points x with normal . (x - at) >= 0.
struct HalfSpace {
    Point at, normal;
    Rational height(const Point& x) const { return dot(normal, x - at); }
};

Point minus(const Point& p)
{
    return Point{0, 0, 0} - p;
}

/// The half-spaces whose intersection is the triangle, or the segment or point that it is.
std::vector<HalfSpace> half_spaces(const std::array<Point, 3>& t)
{
    std::vector<HalfSpace> all;
    const auto add_both = [&](const Point& at, const Point& normal) {
        all.push_back({at, normal}), all.push_back({at, minus(normal)});
    };
    const Point normal = cross(t[1] - t[0], t[2] - t[0]);
    if (dot(normal, normal) != 0) {
        add_both(t[0], normal);
        for (int k = 0; k < 3; ++k) all.push_back({t[k], cross(normal, t[(k + 1) % 3] - t[k])});
        return all;
    }
    int from = 0, to = 0; // the ends of the segment
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (dot(t[j] - t[i], t[j] - t[i]) > dot(t[to] - t[from], t[to] - t[from])) from = i, to = j;
    const Point along = t[to] - t[from], axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const Point& axis : axes) add_both(t[from], from == to ? axis : cross(along, axis));
    all.push_back({t[from], along}), all.push_back({t[to], minus(along)});
    return all;
}

/// The corners of the intersection of a triangle and the half-spaces, perhaps with repetitions.
std::vector<Point> cut(const std::array<Point, 3>& triangle, const std::vector<HalfSpace>& by)
{
    std::vector<Point> figure(triangle.begin(), triangle.end());
    for (const HalfSpace& side : by) {
        std::vector<Point> rest;
        for (std::size_t i = 0; i < figure.size(); ++i) {
            const Point &p = figure[i], &q = figure[(i + 1) % figure.size()];
            const Rational of_p = side.height(p), of_q = side.height(q);
            if (of_p >= 0) rest.push_back(p);
            if ((of_p > 0 && of_q < 0) || (of_p < 0 && of_q > 0)) rest.push_back(p + (of_p / (of_p - of_q)) * (q - p));
        }
        figure = rest;
    }
    return figure;
}

/// True if p is on the segment from a to b.
bool on_segment(const Point& p, const Point& a, const Point& b)
{
    const Point across = cross(b - a, p - a);
    return dot(across, across) == 0 && dot(p - a, p - b) <= 0;
}

/// From the definition: the common figure is not within one of the shared corners and edges.
bool truly_meet_beyond_shared(const TrianglePoints& a, const TrianglePoints& b)
{
    std::array<Point, 3> of_a, of_b;
    for (int k = 0; k < 3; ++k) of_a[k] = oracle::point_of<Rational>(a[k]), of_b[k] = oracle::point_of<Rational>(b[k]);
    const std::vector<Point> common = cut(of_a, half_spaces(of_b));
    if (common.empty()) return false;
    std::vector<Point> shared;
    for (const Point& p : of_a)
        if (std::find(of_b.begin(), of_b.end(), p) != of_b.end()) shared.push_back(p);
    for (const Point& from : shared)
        for (const Point& to : shared)
            if (std::all_of(common.begin(), common.end(), [&](const Point& p) { return on_segment(p, from, to); }))
                return false;
    return true;
}

/// Draws two triangles with common corners, mostly of few coordinates, so that all special positions occur.
std::array<TrianglePoints, 2> draw_two(std::uint64_t seed)
{
    std::uint64_t drawn = 0;
    const auto below = [&](int n) { return int(u01(seed, drawn++, 1) * n); };
    const int range = 2 + below(3);
    const bool any = below(4) == 0, flat = below(3) == 0;
    const double scales[] = {1, 0x1p-30, 0x1p30, 1e-9, 1e9, 0.1};
    const double scale = scales[below(6)];
    std::array<Vector3d, 6> points;
    for (Vector3d& p : points)
        for (double& x : p) x = scale * (any ? u01(seed, drawn++, 2) : below(range));
    if (flat)
        for (Vector3d& p : points) p.z() = below(6) ? 0 : p.z();
    if (below(3) == 0) points[5] = 0.5 * (points[0] + points[1]);
    std::array<TrianglePoints, 2> two;
    const int of_both = 3 + below(4);
    for (TrianglePoints& t : two)
        for (Vector3d& p : t) p = points[below(of_both)];
    return two;
}

TEST(Neighbours, MeetBeyondWhatTheyShareAsRationalsSay)
{
    std::array<std::array<int, 4>, 2> seen{}; // by result and number of shared corners
    for (std::uint64_t seed = 0; seed < 6'000; ++seed) {
        const auto [a, b] = draw_two(seed);
        const bool truth = truly_meet_beyond_shared(a, b);
        std::vector<Vector3d> shared;
        for (const Vector3d& p : a)
            if (std::find(b.begin(), b.end(), p) != b.end() &&
                std::find(shared.begin(), shared.end(), p) == shared.end())
                shared.push_back(p);
        ++seen[truth][shared.size()];
        EXPECT_EQ(meet_beyond_shared(a, b), truth) << "seed " << seed;
        EXPECT_EQ(meet_beyond_shared(b, a), truth) << "seed " << seed << ", swapped";
        EXPECT_EQ(meet_beyond_shared({a[2], a[1], a[0]}, {b[1], b[2], b[0]}), truth) << "seed " << seed << ", turned";
    }
    for (const auto& of_result : seen)
        for (const int count : of_result) EXPECT_GT(count, 0);
}

TEST(Neighbours, AreCertainOnlyWhereRationalsSayThatNothingElseIsShared)
{
    int certain = 0, uncertain = 0;
    for (std::uint64_t seed = 0; seed < 6'000; ++seed) {
        auto [a, b] = draw_two(seed);
        b[0] = a[0];
        const bool corner = certainly_share_corner_only(a[0], a[1], a[2], b[1], b[2]);
        EXPECT_FALSE(corner && truly_meet_beyond_shared(a, b)) << "seed " << seed;
        b[1] = a[1];
        const bool edge = certainly_share_edge_only(a[0], a[1], a[2], b[2]);
        EXPECT_FALSE(edge && truly_meet_beyond_shared(a, b)) << "seed " << seed;
        certain += corner + edge, uncertain += !corner + !edge;
    }
    EXPECT_GT(certain, 500);
    EXPECT_GT(uncertain, 500);
}

/// An edge of a fold that closes to less than rounding can show.
TEST(Neighbours, DecideAFoldOfOneBit)
{
    const Vector3d p{0, 0, 0}, q{1, 0, 0}, r{0.3, 1, 0};
    for (const double height : {0x1p-52, 0x1p-200, 0x1p-1074}) {
        EXPECT_FALSE(meet_beyond_shared({p, q, r}, {p, q, {0.4, 2, height}})) << height;
        EXPECT_FALSE(meet_beyond_shared({p, q, r}, {p, {0.1, 2, 0}, {0.2, 3, height}})) << height << ", one corner";
    }
    EXPECT_TRUE(meet_beyond_shared({p, q, r}, {p, q, {0.4, 2, 0}}));
    EXPECT_FALSE(meet_beyond_shared({p, q, r}, {p, q, {0.4, -2, 0}}));
}

} // namespace
} // namespace oncollide::neighbours_test
