// The hard cases of 'oncollide-lab hard': each must be decided correctly with any stages left out.
#include <cctype>

#include <gtest/gtest.h>

#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/mesh_parts.hpp"
#include "random_pose.hpp"
#include "truth/exact_inside.hpp"
#include "truth/exact_oracle.hpp"
#include "truth/triangle_distance.hpp"
#include "truth/truth.hpp"
#include "verify/trials/hard_trials.hpp"

namespace oncollide::tools {
namespace {

std::vector<std::string> families()
{
    std::vector<std::string> names;
    for (const BodyCase& c : body_cases())
        if (names.empty() || names.back() != c.family) names.push_back(c.family);
    return names;
}

class HardCases : public testing::TestWithParam<std::string> {};

/// Each case runs a part of the variants, and each family of cases runs all of them.
TEST_P(HardCases, AreAnsweredRightByEveryCombinationOfStages)
{
    constexpr std::size_t parts = 32;
    const std::vector<Variant> all = all_variants();
    std::size_t number = 0;
    Tally sum;
    for (const BodyCase& c : body_cases()) {
        if (c.family != GetParam()) continue;
        std::vector<Variant> variants;
        for (std::size_t k = number++ % parts; k < all.size(); k += parts) variants.push_back(all[k]);
        sum += try_bodies(c, variants);
    }
    EXPECT_EQ(sum.missed, 0u) << sum.first_fault;
    EXPECT_EQ(sum.wrong, 0u) << sum.first_fault;
    EXPECT_EQ(sum.broken, 0u) << sum.first_fault;
    EXPECT_EQ(sum.changed, 0u) << sum.first_fault;
    EXPECT_GE(sum.cases, 5u);
    EXPECT_GT(sum.bounds, 100u);
}

INSTANTIATE_TEST_SUITE_P(Families, HardCases, testing::ValuesIn(families()), [](const auto& family) {
    std::string name;
    for (char c : family.param)
        if (std::isalnum(static_cast<unsigned char>(c))) name += c;
    return name;
});

TEST(HardCrowd, IsAnsweredAlikeByAnyNumberOfThreadsAndBackend)
{
    for (const Mode mode : {Mode::surface, Mode::solid}) {
        std::vector<BodyCase> some;
        const std::vector<BodyCase> all = mode == Mode::surface ? surface_cases() : solid_cases();
        for (std::size_t k = 0; k < all.size(); k += 4) some.push_back(all[k]);
        const Tally tally = try_crowd(some, mode, std::vector<int>{1, 3}, true);
        EXPECT_EQ(tally.faults(), 0u) << tally.first_fault;
        EXPECT_GT(tally.results, 1000u);
    }
}

TEST(HardTriangles, AreAnsweredRight)
{
    for (const TriangleFamily& family : triangle_families())
        for (bool rotated : {false, true}) {
            const Tally tally = try_triangles(family, 600, rotated, 1);
            EXPECT_EQ(tally.faults(), 0u) << tally.family << ": " << tally.first_fault;
            EXPECT_EQ(tally.cases, 600u);
        }
}

/// try_bodies checks the truth of the cases; this test checks that its bounds are tight.
TEST(PairTruth, KnowsDistancesToTheLastDigits)
{
    double loosest = 0;
    int apart = 0;
    for (const BodyCase& c : body_cases()) {
        const PairTruth truth = truth_of(c.a, c.pose_a, c.b, c.poses_b.front());
        EXPECT_LE(truth.distance.low, truth.distance.high);
        EXPECT_FALSE(truth.deep && !truth.collide);
        if (truth.collide) {
            EXPECT_LE(truth.distance.high, 0x1p-50 * truth.distance.size) << c.family << ": " << c.name;
            continue;
        }
        ++apart;
        const double slack =
            (truth.distance.high - truth.distance.low) / (1e-6 * truth.distance.high + 0x1p-54 * truth.distance.size);
        if (slack > 1)
            ADD_FAILURE() << c.family << ": " << c.name << ", " << truth.distance.low << " to " << truth.distance.high;
        loosest = std::max(loosest, slack);
    }
    EXPECT_GT(apart, 80);
}

TEST(PairTruth, FindsWhatALoopOverAllTrianglesFinds)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 120), soup = make_soup_mesh(30, 0.3, 1, 6),
               box = make_box_mesh({0.25, 0.5, 0.75});
    int count[3] = {};
    for (const auto& [a, b] : {std::pair(&knot, &soup), std::pair(&soup, &box), std::pair(&box, &box)})
        for (std::uint64_t k = 0; k < 30; ++k) {
            Eigen::Isometry3d pose = random_pose(k, 1.6);
            if (k % 2) pose = at((pose.translation() * 4).array().round().matrix() / 4, Eigen::Matrix3d::Identity());
            const HalvedMesh halved_a(*a), halved_b(*b);
            const BoxedTriangles in_a(halved_a, [](const Eigen::Vector3d& v) { return v; });
            const BoxedTriangles b_in_a(halved_b, RelativePose(Eigen::Isometry3d::Identity(), pose));
            TriangleContact most = TriangleContact::separate;
            long double low = 1e9L, high = 1e9L;
            for (std::uint32_t i = 0; i < a->triangles.size(); ++i)
                for (std::uint32_t j = 0; j < b->triangles.size(); ++j) {
                    const TrianglePoints p = in_a.triangle(i), q = b_in_a.triangle(j);
                    most = std::max(most, oracle::contact(p, q));
                    TriangleL p_l, q_l;
                    for (std::size_t c = 0; c < 3; ++c) {
                        p_l[c] = p[c].cast<long double>();
                        q_l[c] =
                            (pose.linear().cast<long double>() * b->vertices[b->triangles[j][c]].cast<long double>()) +
                            pose.translation().cast<long double>();
                    }
                    const DistanceRange range = triangle_distance(p_l, q_l);
                    low = std::min(low, range.low), high = std::min(high, range.high);
                }
            ++count[int(most)];
            EXPECT_EQ(contact_of(in_a, b_in_a, TriangleContact::crossing), most) << k;
            EXPECT_EQ(contact_of(in_a, b_in_a, TriangleContact::touching) != TriangleContact::separate,
                      most != TriangleContact::separate);
            const DistanceTruth distance = surface_distance(halved_a, Eigen::Isometry3d::Identity(), halved_b, pose);
            EXPECT_EQ(distance.high, double(high)) << k;
            EXPECT_GE(distance.low, double(low)) << k; // bounds may be wider for boxes
        }
    for (int n : count) EXPECT_GE(n, 5) << "the poses must produce every result";
}

/// Only for points far from surfaces: nearer, rounded angles are unreliable, and cases have a known truth by
/// construction.
TEST(SolidTruth, CountsWindingsAsSolidAnglesDo)
{
    int inside = 0, outside = 0;
    for (const BodyCase& c : body_cases()) {
        if (!has_inside(c.a) || c.a.triangles.size() > 300) continue;
        std::vector<TrianglePoints> surface;
        for (const Triangle& t : c.a.triangles)
            surface.push_back({c.a.vertices[t[0]], c.a.vertices[t[1]], c.a.vertices[t[2]]});
        const RelativePose into(c.pose_a, c.poses_b.front());
        for (std::size_t k = 0; k < c.b.vertices.size(); k += 3) {
            const Eigen::Vector3d point = into(c.b.vertices[k]);
            const Vector3l p = point.cast<long double>();
            const bool near = std::ranges::any_of(surface, [&](const TrianglePoints& t) {
                const TriangleL triangle{t[0].cast<long double>(), t[1].cast<long double>(), t[2].cast<long double>()};
                return triangle_distance({p, p, p}, triangle).low < 1e-5 * c.a.bounds.diagonal();
            });
            if (near) continue;
            const int found = oracle::winding(surface, point).value();
            EXPECT_NEAR(found, winding_number(c.a, point), 1e-6) << c.family << ": " << c.name << ", corner " << k;
            ++(found ? inside : outside);
        }
    }
    EXPECT_GT(inside, 300);
    EXPECT_GT(outside, 300);
}

TEST(SolidTruth, KnowsWhichMeshesAreClosed)
{
    int closed = 0, open = 0;
    for (const BodyCase& c : body_cases())
        for (const Mesh* mesh : {&c.a, &c.b}) {
            EXPECT_EQ(has_inside(*mesh), is_closed(*mesh)) << c.family << ": " << c.name;
            ++(has_inside(*mesh) ? closed : open);
        }
    EXPECT_GT(closed, 100);
    EXPECT_GT(open, 100);
}

TEST(TriangleDistance, IsThatOfFacesEdgesAndCorners)
{
    const TriangleL floor{Vector3l(0, 0, 0), Vector3l(4, 0, 0), Vector3l(0, 4, 0)};
    const auto check = [&](Vector3l a, Vector3l b, Vector3l c, long double expected) {
        for (const DistanceRange range : {triangle_distance(floor, {a, b, c}), triangle_distance({c, a, b}, floor)}) {
            EXPECT_NEAR(double(range.high), double(expected), 1e-18);
            EXPECT_NEAR(double(range.low), double(expected), 1e-18);
        }
    };
    check({1, 1, 0.25L}, {2, 1, 1}, {1, 2, 3}, 0.25L);              // a corner above the face
    check({-3, -4, 1}, {-3, -4, 2}, {-5, -6, 2}, std::sqrt(26.0L)); // corner and corner
    check({2, -1, -1}, {2, -1, 1}, {3, -5, 0}, 1);                  // edge across edge
    check({1, 1, -1}, {1, 1, 1}, {9, 9, 0}, 0);                     // an edge through the face
    check({1, 1, 0.5L}, {1, 1, 0.5L}, {1, 1, 0.5L}, 0.5L);          // a point
    check({-1, -3, 0}, {-1, 5, 0}, {-1, 5, 0}, 1);                  // a segment beside an edge
    check({1, 1, 0}, {2, 1, 0}, {1, 2, 0}, 0);                      // inside, coplanar
}

} // namespace
} // namespace oncollide::tools
