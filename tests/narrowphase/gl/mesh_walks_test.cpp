#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"

namespace oncollide::mesh_walks_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A mesh with its tree, grown down to its leaves.
struct Grown {
    Mesh mesh;
    ObbTree tree;

    explicit Grown(Mesh from, bool whole = true) : mesh(std::move(from)), tree(mesh)
    {
        tree.grow_in(tree.bounds(), whole ? ObbTree::leaf_triangles : 64);
    }
};

struct Case {
    ObbTree *a, *b;
    Isometry3d pose_a, pose_b;
    float enough = 0;
};

/// One MeshWalks serves all tests: compiling its shaders takes longer than they do.
MeshWalks& shared_walks()
{
    static const std::unique_ptr<MeshWalks> walks = make_mesh_walks();
    return *walks;
}

struct Decided {
    std::vector<MeshWalkResult> results;
    std::vector<UnsureTriangles> unsure;
    std::vector<WantedNode> wanted;
};

void fill(MeshWalks& walks, const std::vector<Case>& cases, const std::vector<TrianglePair>& hints)
{
    const std::span<MeshWalkPair> pairs = walks.begin(cases.size());
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const Case& c = cases[i];
        MeshWalkPair pair(RelativePose(c.pose_a, c.pose_b), walks.hold(*c.a, 1).value(), walks.hold(*c.b, 1).value());
        pair.enough = c.enough;
        if (!hints.empty()) pair.hint_a = hints[i].a, pair.hint_b = hints[i].b;
        pairs[i] = pair;
    }
}

Decided collected(MeshWalks& walks)
{
    const auto results = walks.collect();
    return {{results.begin(), results.end()},
            {walks.unsure().begin(), walks.unsure().end()},
            {walks.wanted().begin(), walks.wanted().end()}};
}

Decided decide(MeshWalks& walks, const std::vector<Case>& cases, bool by_distance = false,
               const std::vector<TrianglePair>& hints = {})
{
    fill(walks, cases, hints);
    walks.submit(by_distance);
    return collected(walks);
}

/// Compares the results with the CPU's. Returns how many pairs meet.
/// @param some_open  pairs may be open
int expect_right(const std::vector<Case>& cases, const Decided& decided, bool some_open = false)
{
    Traversal traversal;
    int met = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const auto& [a, b, pose_a, pose_b, enough] = cases[i];
        const RelativePose b_to_a(pose_a, pose_b);
        TriangleTests tests;
        tests.start(*a, *b, b_to_a);
        const MeshWalkResult& result = decided.results[i];
        bool meets = result.verdict() == MeshWalkVerdict::meets;
        if (meets) {
            EXPECT_TRUE(tests.meet({result.a, result.b})) << i;
        }
        bool listed_meets = false, any = false;
        for (const UnsureTriangles& u : decided.unsure) {
            if (u.pair != i) continue;
            any = true;
            listed_meets |= tests.meet({u.a, u.b});
        }
        if (result.verdict() == MeshWalkVerdict::unsure) {
            EXPECT_TRUE(any) << i;
            meets = listed_meets;
        }
        if (result.verdict() == MeshWalkVerdict::open) {
            EXPECT_TRUE(some_open || listed_meets) << i;
            if (!listed_meets) continue;
            meets = true;
        }
        EXPECT_EQ(meets, traversal.first_meeting(*a, *b, b_to_a, {}, nullptr).pair.has_value()) << i;
        met += meets;
        if (result.verdict() != MeshWalkVerdict::apart) continue;
        const auto distance = traversal.distance(*a, *b, b_to_a, 0);
        EXPECT_GT(result.bound, 0) << i;
        EXPECT_LE(double(result.bound), distance.upper) << i;
    }
    return met;
}

std::vector<Case> around(ObbTree& a, ObbTree& b, int count, double reach, std::uint64_t seed,
                         const Vector3d& at = {0, 0, 0})
{
    std::vector<Case> cases;
    for (int i = 0; i < count; ++i) {
        Isometry3d pose_a = random_pose(seed + 2 * i, 0.1 * reach), pose_b = random_pose(seed + 2 * i + 1, reach);
        pose_a.translation() += at, pose_b.translation() += at;
        cases.push_back({&a, &b, pose_a, pose_b});
    }
    return cases;
}

TEST(MeshWalks, DecideAsTheCpuDoes)
{
    Grown knot(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800)), gear(make_gear_mesh(12, 1, 1.3, 0.4, 0.3)),
        soup(make_soup_mesh(300, 0.2, 1.5, 5)), small(make_box_mesh({0.05, 0.04, 0.03})),
        plate(make_box_mesh({40, 40, 0.1}, 12));
    std::vector<Case> cases = around(knot.tree, knot.tree, 60, 1.6, 1);
    const auto add = [&](const std::vector<Case>& more) { cases.insert(cases.end(), more.begin(), more.end()); };
    add(around(gear.tree, knot.tree, 60, 1.6, 1000)), add(around(soup.tree, gear.tree, 40, 1.6, 2000));
    add(around(knot.tree, small.tree, 60, 1.2, 3000)), add(around(plate.tree, small.tree, 30, 3, 4000));
    add(around(plate.tree, knot.tree, 30, 30, 5000, {1e6, -2e6, 3e5}));
    const int met = expect_right(cases, decide(shared_walks(), cases));
    EXPECT_GT(met, 60);
    EXPECT_LT(met, static_cast<int>(cases.size()) - 60);
}

TEST(MeshWalks, LeaveContactsInOnePlaneToExactTests)
{
    Grown box(make_box_mesh({1, 1, 1}, 3)), knot(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 400));
    std::vector<Case> cases;
    const auto place = [](double x, double y) { return Isometry3d(Eigen::Translation3d(x, y, 0.25)); };
    for (const double x : {2.0, std::nextafter(2.0, 3.0), std::nextafter(2.0, 1.0), 2 + 1e-12, 2 - 1e-12, 2 + 1e-7})
        cases.push_back({&box.tree, &box.tree, Isometry3d::Identity(), place(x, 0.3)});
    const Isometry3d turned = random_pose(3, 1);
    cases.push_back({&knot.tree, &knot.tree, turned, turned}); // equal poses
    const Decided decided = decide(shared_walks(), cases);
    EXPECT_EQ(expect_right(cases, decided, true), 4);
    EXPECT_EQ(decided.results[0].verdict(), MeshWalkVerdict::open); // after a few triangles, as two probably meet
    EXPECT_EQ(decided.results[5].verdict(), MeshWalkVerdict::apart);
}

TEST(MeshWalks, NameTheBoxesThatAreNotGrown)
{
    // A probe in the middle of a triangle meets it, and hardly any other.
    Grown soup(make_soup_mesh(1500, 0.05, 2, 3), false), probe(make_box_mesh({0.003, 0.002, 0.001}));
    const auto at_triangles = [&](std::size_t first, std::size_t step) {
        std::vector<Case> cases;
        for (std::size_t i = first; i < soup.mesh.triangles.size(); i += step) {
            const TrianglePoints t = soup.tree.corners(static_cast<std::uint32_t>(i));
            Isometry3d pose = random_pose(i, 0);
            pose.translation() = (t[0] + t[1] + t[2]) / 3;
            cases.push_back({&soup.tree, &probe.tree, Isometry3d::Identity(), pose});
        }
        return cases;
    };
    const std::vector<Case> cases = at_triangles(0, 150);
    Decided decided = decide(shared_walks(), cases);
    const auto open = [&] {
        return std::ranges::count(decided.results, MeshWalkVerdict::open, &MeshWalkResult::verdict);
    };
    EXPECT_GT(open(), 0);
    ASSERT_FALSE(decided.wanted.empty());
    int batches = 0; // one box each time, so that only the new nodes go up
    for (; open() > 0 && batches < 200; ++batches) {
        soup.tree.child(decided.wanted.front().node, decided.wanted.front().box);
        decided = decide(shared_walks(), cases);
    }
    EXPECT_GT(batches, 5);
    EXPECT_EQ(open(), 0);
    EXPECT_EQ(expect_right(cases, decided), 10);
    const std::vector<Case> more = at_triangles(1, 5); // with the parts that are grown
    EXPECT_GT(expect_right(more, decide(shared_walks(), more), true), 10);
}

TEST(MeshWalks, LeaveTrianglesOpenThatAreNearEnough)
{
    Grown knot(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800));
    Traversal traversal;
    for (const bool by_distance : {false, true}) {
        std::vector<Case> cases = around(knot.tree, knot.tree, 80, 2, 11);
        for (Case& c : cases) c.enough = 0.2f;
        const Decided decided = decide(shared_walks(), cases, by_distance);
        int apart = 0, open = 0;
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const RelativePose b_to_a(cases[i].pose_a, cases[i].pose_b);
            const double distance = traversal.distance(knot.tree, knot.tree, b_to_a, 0).upper;
            EXPECT_NE(decided.results[i].verdict(), MeshWalkVerdict::unsure);
            if (decided.results[i].verdict() == MeshWalkVerdict::meets) {
                EXPECT_EQ(distance, 0);
            }
            open += decided.results[i].verdict() == MeshWalkVerdict::open;
            if (decided.results[i].verdict() != MeshWalkVerdict::apart) continue;
            ++apart;
            if (by_distance) {
                EXPECT_GT(distance, 0.2);
            }
        }
        EXPECT_GT(apart, 5);
        EXPECT_GT(open, 5);
    }
}

TEST(MeshWalks, TestTheHintFirst)
{
    Grown knot(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800));
    const std::vector<Case> cases = around(knot.tree, knot.tree, 40, 1, 21);
    const Decided decided = decide(shared_walks(), cases);
    std::vector<TrianglePair> hints;
    for (const MeshWalkResult& result : decided.results) hints.push_back({result.a, result.b});
    const std::uint64_t rows = shared_walks().counts().box_rows;
    const Decided again = decide(shared_walks(), cases, false, hints);
    const std::uint64_t with_hints = shared_walks().counts().box_rows - rows;
    expect_right(cases, again);
    std::vector<TrianglePair> wrong(cases.size(), TrianglePair{0, 0});
    expect_right(cases, decide(shared_walks(), cases, false, wrong));
    EXPECT_LT(2 * with_hints, shared_walks().counts().box_rows - rows - with_hints);
}

TEST(MeshWalks, DecideTwoBatchesAtATime)
{
    Grown knot(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 800)), gear(make_gear_mesh(12, 1, 1.3, 0.4, 0.3));
    const std::vector<Case> cases[2] = {around(knot.tree, gear.tree, 40, 1.6, 41),
                                        around(gear.tree, knot.tree, 90, 1.6, 43)};
    MeshWalks& walks = shared_walks();
    for (const std::vector<Case>& of_batch : cases) fill(walks, of_batch, {}), walks.submit(false);
    for (const std::vector<Case>& of_batch : cases) {
        const Decided decided = collected(walks);
        ASSERT_EQ(decided.results.size(), of_batch.size());
        EXPECT_EQ(walks.batch().pairs, of_batch.size());
        EXPECT_GT(expect_right(of_batch, decided), 5);
    }
}

TEST(MeshWalks, LosePairsToTheCpuWhereAQueueIsFull)
{
    const auto made = make_mesh_walks({.first_items = 64});
    MeshWalks& walks = *made;
    Grown plate(make_box_mesh({1, 1, 0.001}, 24));
    std::vector<Case> cases; // near each other everywhere, so that every walk spills into the queues
    for (int i = 0; i < 6; ++i)
        cases.push_back(
            {&plate.tree, &plate.tree, Isometry3d::Identity(), Isometry3d(Eigen::Translation3d(0.001 * i, 0, 0.0021))});
    Decided decided = decide(walks, cases);
    EXPECT_EQ(walks.batch().full, 1u);
    EXPECT_EQ(decided.results[0].verdict(), MeshWalkVerdict::open);
    for (int i = 0; i < 8 && decided.results[0].verdict() == MeshWalkVerdict::open; ++i) decided = decide(walks, cases);
    expect_right(cases, decided);
}

/// Their driver ends loops too soon, as llvmpipe does after 65,535 passes, and buffers are small.
MeshWalks& poor_walks()
{
    static const std::unique_ptr<MeshWalks> walks = [] {
        MeshWalkOptions options;
        options.most_buffer_bytes = 1 << 19, options.first_items = 4096;
        options.edit_shader = [](std::string source) {
            const std::string loop = "for (;;) {\n        if (lane == 0u) {";
            if (const auto at = source.find(loop); at != std::string::npos)
                source.replace(at, loop.size(), "for (int pass = 0; pass < 200; ++pass) {\n        if (lane == 0u) {");
            return source;
        };
        return make_mesh_walks(options);
    }();
    return *walks;
}

TEST(MeshWalks, LosePairsToTheCpuWhereADriverEndsALoopTooSoon)
{
    Grown plate(make_box_mesh({1, 1, 0.001}, 24));
    std::vector<Case> cases;
    for (int i = 0; i < 6; ++i)
        cases.push_back({&plate.tree, &plate.tree, Isometry3d::Identity(),
                         Isometry3d(Eigen::Translation3d(0.001 * i, 0, i % 2 ? 0.0021 : 0.0019))});
    const Decided decided = decide(poor_walks(), cases);
    EXPECT_EQ(poor_walks().batch().full, 0u);
    expect_right(cases, decided, true);
    EXPECT_GT(std::ranges::count(decided.results, MeshWalkVerdict::open, &MeshWalkResult::verdict), 0);
}

TEST(MeshWalks, RefuseTreesWithoutRoom)
{
    MeshWalks& walks = poor_walks();
    Grown large(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 8000)), small(make_box_mesh({1, 1, 1}));
    EXPECT_FALSE(walks.hold(large.tree, 1));
    EXPECT_EQ(walks.counts().trees_without_room, 1u);
    EXPECT_TRUE(walks.hold(small.tree, 1));
    Grown far(transformed("far", make_box_mesh({1, 1, 1}), 1e-14, {0, 0, 0}));
    EXPECT_FALSE(walks.hold(far.tree, 1)); // out of the range of floats
}

TEST(MeshWalks, KeepTreesThatAreHeldAndDropOthers)
{
    MeshWalks& walks = shared_walks();
    Grown a(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 400)), b(make_gear_mesh(12, 1, 1.3, 0.4, 0.3));
    ASSERT_TRUE(walks.hold(a.tree, 5) && walks.hold(b.tree, 9));
    walks.drop_unused(9);
    const std::vector<Case> cases = around(a.tree, b.tree, 20, 1.5, 31);
    expect_right(cases, decide(walks, cases)); // goes up again
}

TEST(MeshWalks, FailTheSelfTestOnADriverThatComputesWrongly)
{
    struct Fault {
        const char *from, *to;
    };
    for (const Fault& fault : {Fault{"return q;", "return dvec3(vec3(q));"},               // floats for doubles
                               Fault{"gap = float(widest)", "gap = 0.05 + float(widest)"}, // bounds
                               Fault{"gap > frames[pair].limit", "gap + 0.5 > frames[pair].limit"}, // lost boxes
                               Fault{"if (lone_b < 0) first", "if (lone_b > 0) first"},             // a wrong sign
                               Fault{"float(bitfieldExtract(int(", "float(bitfieldExtract(uint("}}) {
        MeshWalkOptions options;
        bool planted = false;
        options.edit_shader = [&](std::string source) {
            if (const auto at = source.find(fault.from); at != std::string::npos)
                source.replace(at, std::string(fault.from).size(), fault.to), planted = true;
            return source;
        };
        EXPECT_THROW(make_mesh_walks(options), GpuLost) << fault.to;
        EXPECT_TRUE(planted) << fault.from;
    }
}

} // namespace
} // namespace oncollide::mesh_walks_test
