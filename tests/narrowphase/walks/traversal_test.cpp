// Traversals of OBB trees, compared with brute force over all triangles.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>

#include "narrowphase/mesh_cases.hpp"

namespace oncollide::mesh_cases {
namespace {

struct Truth {
    std::vector<TrianglePair> meeting;
    double distance = std::numeric_limits<double>::infinity();
};

Truth brute_force(const Mesh& a, const Mesh& b, const RelativePose& b_to_a)
{
    const auto corners = [](const Mesh& mesh, std::uint32_t t, auto place) {
        TrianglePoints points;
        for (std::size_t k = 0; k < 3; ++k) points[k] = place(mesh.vertices[mesh.triangles[t][k]]);
        return points;
    };
    Truth truth;
    for (std::uint32_t i = 0; i < a.triangles.size(); ++i)
        for (std::uint32_t j = 0; j < b.triangles.size(); ++j) {
            const TrianglePoints p = corners(a, i, [](const Vector3d&v) { return v; }), q = corners(b, j, b_to_a);
            if (triangles_meet(p, q))
                truth.meeting.push_back({i, j}), truth.distance = 0;
            else if (truth.distance > 0)
                truth.distance = std::min(truth.distance, triangle_distance(p, q));
        }
    return truth;
}

TEST(Traversal, FindsEveryPairOfTrianglesOfBruteForce)
{
    Traversal walk;
    for (const Case& c : cases()) {
        ObbTree a(c.a), b(c.b);
        std::uint64_t colliding = 0;
        for (const Isometry3d& pose : poses_of(c, 14)) {
            const Truth truth = brute_force(c.a, c.b, at(pose));
            std::vector<TrianglePair> pairs;
            walk.all_meeting(a, b, at(pose), pairs);
            EXPECT_EQ(pairs, truth.meeting) << c.name;
            const auto [first, gap] = walk.first_meeting(a, b, at(pose));
            EXPECT_EQ(first.has_value(), !truth.meeting.empty()) << c.name;
            if (first) {
                EXPECT_TRUE(std::binary_search(pairs.begin(), pairs.end(), *first)) << c.name;
                EXPECT_EQ(walk.first_meeting(a, b, at(pose), pairs.back()).pair, pairs.back()) << "a hint that holds";
            }
            const TrianglePair wrong{0, static_cast<std::uint32_t>(c.b.triangles.size() - 1)};
            EXPECT_EQ(walk.first_meeting(a, b, at(pose), wrong).pair.has_value(), first.has_value()) << c.name;
            colliding += first.has_value();
        }
        EXPECT_GT(colliding, 1u) << c.name;
        EXPECT_LT(colliding, 14u) << c.name;
        EXPECT_LE(a.nodes(), ObbTree::most_nodes(c.a.triangles.size()));
        EXPECT_LE(a.bytes(), ObbTree::most_bytes(c.a.triangles.size()));
    }
}

TEST(Traversal, BoundsTheDistanceOfMeshesThatDoNotMeet)
{
    Traversal walk;
    for (const Case& c : cases()) {
        ObbTree a(c.a), b(c.b);
        int apart = 0;
        for (const Isometry3d& pose : poses_of(c, 14)) {
            const double distance = brute_force(c.a, c.b, at(pose)).distance;
            for (const double bound :
                 {walk.first_meeting(a, b, at(pose)).bound,
                  walk.first_meeting(a, b, at(pose), TrianglePair{0, 0}).bound, walk.contact(a, b, at(pose)).bound}) {
                EXPECT_LE(bound, distance) << c.name;
                EXPECT_EQ(bound > 0, distance > 0) << c.name;
                EXPECT_GE(bound, 1e-4 * std::min(distance, 0.1 * (a.radius() + b.radius()))) << c.name;
            }
            const auto near = walk.near(a, b, at(pose), 0, 0);
            EXPECT_EQ(near.bound > 0 || near.near, true) << c.name;
            apart += distance > 0;
        }
        EXPECT_GT(apart, 0) << c.name;
    }
}

TEST(Traversal, BoundsTheDistanceOfBoxesAUnitInTheLastPlaceApart)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    ObbTree tree(box);
    Isometry3d beside = Isometry3d::Identity();
    for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(1, 0.5, 0.25), Vector3d(1, 1, 1)}) {
        beside.translation() = 2 * way;
        EXPECT_EQ(Traversal().first_meeting(tree, tree, at(beside)).bound, 0) << "they touch";
        beside.translation().x() = 2 + 0x1p-51;
        const auto [pair, bound] = Traversal().first_meeting(tree, tree, at(beside));
        EXPECT_FALSE(pair);
        EXPECT_GT(bound, 0.99 * 0x1p-52);
        EXPECT_LE(bound, 0x1p-51);
    }
}

TEST(Traversal, BoundsTheDistanceToTheToleranceAsked)
{
    Traversal walk;
    for (const Case& c : cases()) {
        ObbTree a(c.a), b(c.b);
        const double size = a.radius() + b.radius(), rounding = size * 1e-10;
        for (const Isometry3d& pose : poses_of({c.name, c.a, c.b, 2 * c.reach}, 10)) {
            const double truth = brute_force(c.a, c.b, at(pose)).distance;
            for (const double tolerance : {0.0, 0.001 * size, 0.1 * size}) {
                const auto distance = walk.distance(a, b, at(pose), tolerance);
                EXPECT_LE(distance.lower, truth) << c.name;
                EXPECT_GE(distance.upper, truth) << c.name;
                EXPECT_LE(distance.upper - distance.lower, tolerance + rounding) << c.name;
                EXPECT_TRUE(distance.nearest);
                if (tolerance == 0) {
                    EXPECT_EQ(distance.upper == 0, truth == 0) << c.name;
                }
                if (truth == 0) continue;
                const auto far = walk.distance(a, b, at(pose), tolerance, 0.5 * truth);
                EXPECT_GT(far.lower, 0.5 * truth) << c.name;
                EXPECT_LE(far.lower, truth) << c.name;
                EXPECT_FALSE(far.nearest);
                for (const double share : {1 - 1e-11, 1.0, 1 + 1e-11}) { // exactly the cutoff, up to rounding
                    const auto just = walk.distance(a, b, at(pose), tolerance, share * truth);
                    EXPECT_TRUE(just.nearest ? just.upper >= truth : just.lower > share * truth) << c.name;
                    EXPECT_LE(just.lower, truth) << c.name;
                }
            }
        }
    }
}

/// Without the first guess, 380 and 294 rows.
TEST(Traversal, FindsFarDistancesInFewRows)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 5000), ball = make_sphere_mesh(0.5, 3000);
    const auto rows = [&](const Mesh& other) {
        ObbTree a(knot), b(other);
        Traversal walk;
        for (std::uint64_t seed = 0; seed < 30; ++seed) {
            Isometry3d pose = random_pose(seed, 1);
            pose.translation() = (2.5 + 2 * u01(seed, 3, 0)) * random_pose(seed + 50, 1).linear().col(0);
            walk.distance(a, b, at(pose), 0);
        }
        return double(walk.counts().box_rows) / 30;
    };
    EXPECT_LE(rows(knot), 345) << "knots";
    EXPECT_LE(rows(ball), 265) << "a ball";
}

/// In the order of the gaps alone, 116 rows.
TEST(Traversal, FindsDeepMeetingsInFewRows)
{
    const Mesh needles = make_needles_mesh(3000, 1, 1e3, 2, 5), soup = make_soup_mesh(3000, 0.5, 0.2, 6);
    ObbTree a(needles), b(soup);
    Traversal walk;
    std::uint64_t meet = 0, rows = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        walk.reset_counts();
        if (walk.first_meeting(a, b, at(random_pose(seed, 1))).pair) ++meet, rows += walk.counts().box_rows;
    }
    EXPECT_GT(meet, 100u);
    EXPECT_LE(double(rows), 14 * double(meet));
}

TEST(Traversal, CallsMeshesNearThatAreWithinTheClearanceAndNoneBeyondTheTolerance)
{
    Traversal walk;
    int near = 0, apart = 0;
    for (const Case& c : cases()) {
        ObbTree a(c.a), b(c.b);
        const double size = a.radius() + b.radius();
        const TrianglePair last{static_cast<std::uint32_t>(c.a.triangles.size() - 1),
                                static_cast<std::uint32_t>(c.b.triangles.size() - 1)};
        for (const Isometry3d& pose : poses_of({c.name, c.a, c.b, 1.5 * c.reach}, 12)) {
            const Truth truth = brute_force(c.a, c.b, at(pose));
            for (const double clearance : {0.0, 0.01 * size, 0.1 * size})
                for (const double tolerance : {0.0, 1e-4 * size, 0.02 * size}) {
                    const auto answer = walk.near(a, b, at(pose), clearance, tolerance);
                    if (truth.distance <= clearance) {
                        EXPECT_TRUE(answer.near) << c.name;
                    }
                    if (answer.near) {
                        EXPECT_LE(truth.distance, answer.bound) << c.name;
                        EXPECT_LE(answer.bound, clearance + tolerance + 1e-4 * clearance + 1e-10 * size) << c.name;
                    } else {
                        EXPECT_GE(answer.bound, clearance);
                        EXPECT_LE(answer.bound, truth.distance) << c.name;
                    }
                    near += answer.near, apart += !answer.near;
                    // The result does not depend on the hint from the last frame, right or wrong.
                    for (const TrianglePair hint :
                         {TrianglePair{0, 0}, truth.meeting.empty() ? last : truth.meeting[0]}) {
                        const auto same = walk.near(a, b, at(pose), clearance, tolerance, hint);
                        EXPECT_EQ(same.near, answer.near) << c.name;
                        EXPECT_EQ(same.bound, answer.bound) << c.name;
                    }
                }
        }
    }
    EXPECT_GT(near, 100);
    EXPECT_GT(apart, 100);
}

} // namespace
} // namespace oncollide::mesh_cases
