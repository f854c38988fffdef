// The tree of a mesh whose vertices move finds the same pairs as a new tree.
#include <gtest/gtest.h>

#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/walks/traversal.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/vertex_mover.hpp>

#include "deforming_mesh.hpp"
#include "random_pose.hpp"

namespace oncollide::obb_tree_deform_test {
namespace {

using Eigen::Vector3d;

Mesh part_of_knot(std::uint32_t triangles)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 6000);
    return make_mesh("part", knot.vertices, {knot.triangles.begin(), knot.triangles.begin() + triangles});
}

struct Moving {
    Mesh mesh;
    std::vector<Vector3d> rest;
    VertexMover mover;
    ObbTree tree;

    explicit Moving(Mesh m, BoxTotals* totals = nullptr)
        : mesh(std::move(m)), rest(mesh.vertices), mover(mesh), tree(mesh, totals)
    {
    }
    Moving(const Moving&) = delete;
    void set(std::size_t first, std::span<const Vector3d> positions)
    {
        const VertexMove moved = mover.move("mesh", mesh, first, positions);
        if (moved.distance > 0)
            tree.deform(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(positions.size()), moved.radius2);
    }
};

class Walks {
public:
    std::vector<TrianglePair> meetings(ObbTree& a, ObbTree& b, const RelativePose& b_to_a)
    {
        std::vector<TrianglePair> found;
        walk_.all_meeting(a, b, b_to_a, found);
        return found;
    }
    double distance(ObbTree& a, ObbTree& b, const RelativePose& b_to_a)
    {
        return walk_.distance(a, b, b_to_a, 0).upper;
    }

private:
    Traversal walk_;
};

/// The pairs that meet and the distance, in the tree that follows the mesh and in a new one.
void expect_as_new(Moving& moving, ObbTree& other, std::uint64_t seed, const std::string& when)
{
    Walks walks;
    ObbTree fresh(moving.mesh);
    const Eigen::Isometry3d pose = random_pose(seed, seed % 3 ? 0.4 : 1.5);
    const RelativePose into(Eigen::Isometry3d::Identity(), pose);
    const auto found = walks.meetings(moving.tree, other, into);
    ASSERT_EQ(found, walks.meetings(fresh, other, into)) << when;
    const double distance = walks.distance(fresh, other, into);
    ASSERT_NEAR(walks.distance(moving.tree, other, into), distance, 1e-9 * (1 + distance)) << when;
    ASSERT_EQ(moving.tree.validate(), "") << when;
    ASSERT_EQ(moving.tree.centre(), fresh.centre()) << when;
    ASSERT_EQ(moving.tree.radius(), fresh.radius()) << when;
}

TEST(DeformedObbTree, FindsWhatANewTreeFinds)
{
    const Mesh partner = make_sphere_mesh(0.3, 300);
    ObbTree other(partner);
    for (const std::uint32_t triangles : {1u, 2u, 3u, 17u, 500u, 600u, 6000u})
        for (int how = 0; how < deformations; ++how) {
            Moving moving(part_of_knot(triangles));
            for (int frame = 0; frame < 40; ++frame) {
                const auto when = std::to_string(triangles) + " triangles, deformation " + std::to_string(how) +
                                  ", frame " + std::to_string(frame);
                moving.set(0, deformed(moving.rest, DeformingWay(how), 0.037 * frame));
                if (frame % 7 == 3) continue; // no traversal between two changes
                ASSERT_NO_FATAL_FAILURE(
                    expect_as_new(moving, other, static_cast<std::uint64_t>(50 * how + frame), when));
            }
        }
}

TEST(DeformedObbTree, FollowsRangesOfVertices)
{
    const Mesh partner = make_sphere_mesh(0.3, 300);
    ObbTree other(partner);
    for (const std::uint32_t triangles : {40u, 6000u}) {
        Moving moving(part_of_knot(triangles));
        for (std::uint64_t frame = 0; frame < 300; ++frame) {
            const std::size_t all = moving.rest.size(),
                              first = static_cast<std::size_t>(double(all) * u01(frame, 1, 0)),
                              count = std::min<std::size_t>(all - first, 1 + all / 20 * (frame % 4));
            const auto how = static_cast<DeformingWay>(frame % 5 == 4 ? DeformingWay::wave : DeformingWay::shiver);
            const std::vector<Vector3d> now = deformed(moving.rest, how, 0.01 * double(frame));
            moving.set(first, std::span(now).subspan(first, count));
            ASSERT_NO_FATAL_FAILURE(expect_as_new(moving, other, frame, "frame " + std::to_string(frame)));
        }
    }
}

TEST(DeformedObbTree, FitsOnlyBoxesThatATraversalReaches)
{
    Moving moving(make_terrain_mesh(1, 0.05, 220, 3)); // 96,800 triangles
    const Mesh partner = make_sphere_mesh(0.02, 300);
    ObbTree other(partner);
    Walks walks;
    const auto touch = [&](const Vector3d& at) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = at;
        return walks.meetings(moving.tree, other, RelativePose(Eigen::Isometry3d::Identity(), pose));
    };
    const auto lift = [&](double height) {
        std::vector<Vector3d> moved = moving.rest;
        for (Vector3d& p : moved) p.z() += height;
        moving.set(0, moved);
    };
    const std::size_t middle = moving.rest.size() / 2 + 100;
    lift(0.001);
    EXPECT_FALSE(touch(moving.mesh.vertices[middle]).empty());
    const std::uint64_t before = moving.tree.boxes_refitted();
    lift(0.002);
    EXPECT_EQ(moving.tree.boxes_refitted(), before) << "nothing is fitted before a traversal";
    EXPECT_FALSE(touch(moving.mesh.vertices[middle]).empty());
    const std::uint64_t fitted = moving.tree.boxes_refitted() - before;
    EXPECT_GT(fitted, 0u);
    EXPECT_LT(fitted, moving.mesh.triangles.size() / 200);
    EXPECT_FALSE(touch(moving.mesh.vertices[middle]).empty());
    EXPECT_EQ(moving.tree.boxes_refitted() - before, fitted) << "and only once";

    const Vector3d far = moving.mesh.vertices[10] + Vector3d(0, 0, 0.001);
    moving.set(10, {&far, 1});
    EXPECT_FALSE(touch(moving.mesh.vertices[middle]).empty());
    EXPECT_LT(moving.tree.boxes_refitted() - before - fitted, 100u) << "the moved vertex is elsewhere";
}

TEST(DeformedObbTree, DividesTrianglesAnewOnceTheyAreScattered)
{
    BoxTotals totals;
    {
        Moving moving(part_of_knot(6000), &totals);
        const Mesh partner = make_sphere_mesh(0.3, 300);
        ObbTree other(partner);
        const std::uint32_t identity = moving.tree.identity();
        for (std::uint64_t frame = 0; frame < 10; ++frame) { // of small triangles in other places
            std::vector<Vector3d> now = moving.rest;
            for (std::size_t v = 0; frame > 2 && v < now.size(); ++v)
                now[v] = 0.1 * now[v] + Vector3d(u01(v % 997, 0, 0), u01(v % 997, 0, 1), u01(v % 997, 0, 2));
            now[0].x() += 1e-3 * double(frame);
            moving.set(0, now);
            ASSERT_NO_FATAL_FAILURE(expect_as_new(moving, other, frame, "frame " + std::to_string(frame)));
            if (frame == 2) {
                EXPECT_EQ(moving.tree.identity(), identity);
            }
        }
        EXPECT_NE(moving.tree.identity(), identity);
        EXPECT_EQ(totals.nodes, moving.tree.nodes());
        EXPECT_EQ(totals.bytes, moving.tree.bytes());
        EXPECT_EQ(moving.tree.validate(), "");
    }
    EXPECT_EQ(totals.nodes, 0u);
    EXPECT_EQ(totals.bytes, 0u);
}

TEST(VertexMover, RenewsTheBoundsOfUsedVertices)
{
    Mesh mesh = make_mesh("mesh", {{0, 0, 0}, {9, 9, 9}, {1, 0, 0}, {0, 1, 0}}, {{0, 2, 3}});
    const VertexMover mover(mesh);
    const std::vector<Vector3d> now{{-1, 0, 0}, {50, 0, 0}, {2, 0, 0}, {0, 3, 1}};
    EXPECT_GE(mover.move("mesh", mesh, 0, now).distance, 41);
    EXPECT_NO_THROW(check_mesh("mesh", mesh));
    EXPECT_EQ(mesh.bounds.max, Vector3d(2, 3, 1));
    EXPECT_EQ(mover.move("mesh", mesh, 0, now).distance, 0) << "the same positions";
    EXPECT_EQ(mover.move("mesh", mesh, 2, {}).distance, 0);
    EXPECT_EQ(mover.move("mesh", mesh, 1, std::span(mesh.vertices).subspan(1, 2)).distance, 0) << "its own positions";
    const Vector3d up(0, 3, 7);
    EXPECT_GE(mover.move("mesh", mesh, 3, {&up, 1}).distance, 6);
    EXPECT_NO_THROW(check_mesh("mesh", mesh));
    for (const double bad : {std::nan(""), 1.0 / 0.0, -1.1e15}) {
        std::vector<Vector3d> wrong = now;
        wrong[2].y() = bad;
        const Mesh before = mesh;
        EXPECT_THROW(mover.move("mesh", mesh, 0, wrong), Error);
        EXPECT_EQ(mesh.vertices, before.vertices);
        try {
            mover.move("cloth", mesh, 2, std::span(wrong).subspan(2));
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("cloth: vertex 2 is "), std::string::npos) << error.what();
        }
    }
}

} // namespace
} // namespace oncollide::obb_tree_deform_test
