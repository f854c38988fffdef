#include <oncollide/narrowphase/pairs/manifolds/overlap_patches.hpp>

#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/samples/generators.hpp>

#include "narrowphase/mesh_parts.hpp"
#include "random_pose.hpp"

namespace oncollide::overlap_patches_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// The overlap of two meshes, of which b is at a pose.
class Overlap : public OverlapPatches {
public:
    Overlap(const Mesh& a, const Mesh& b, const Isometry3d& pose, bool joins = false)
        : mesh_a_(a), mesh_b_(b), model_a_(add(a)), model_b_(add(b)), into_(Isometry3d::Identity(), pose),
          a_(model_a_, RelativePose(Isometry3d::Identity(), Isometry3d::Identity()), {}, joins),
          b_(model_b_, into_, {}, joins)
    {
        a_.with_tree([&](auto& tree_a) {
            b_.with_tree(
                [&](auto& tree_b) { worker_.traversal(tree_a, tree_b).all_meeting(tree_a, tree_b, into_, pairs); });
        });
        find(a_, b_, pairs, worker_.locator);
    }
    double rounding() const { return rounding_of(a_, b_); }
    /// How often the other body winds around a point, by solid angles.
    double winding(int side, const Vector3d& p) const
    {
        return side == 0 ? winding_number(mesh_b_, into_.rotation.transpose() * (p - into_.translation))
                         : winding_number(mesh_a_, p);
    }
    std::vector<TrianglePair> pairs;

private:
    Model& add(const Mesh& mesh)
    {
        Model& model = store_[store_.add(std::make_shared<const Geometry>(Geometry{{}, mesh, {}}))];
        store_.obb_tree(model, 0);
        return model;
    }
    Settings settings_;
    ModelStore store_{settings_, make_cpu_backend()};
    const Mesh &mesh_a_, &mesh_b_;
    Model &model_a_, &model_b_;
    const RelativePose into_;
    PlacedSurface a_, b_;
    PairWorker worker_;
};

Isometry3d at(double x, double y, double z)
{
    return Isometry3d(Eigen::Translation3d(x, y, z));
}

TEST(OverlapPatches, MeasureTheOverlapOfTwoBoxes)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    const Overlap overlap(box, box, at(1.5, 1.375, 1.25)); // overlap: 0.5 x 0.625 x 0.75
    ASSERT_EQ(overlap.lumps.size(), 1u);
    const Lump& lump = overlap.lumps[0];
    EXPECT_NEAR(lump.volume, 0.5 * 0.625 * 0.75, 1e-15);
    EXPECT_NEAR((lump.area_a - Vector3d(0.625 * 0.75, 0.5 * 0.75, 0.5 * 0.625)).norm(), 0, 1e-15);
    EXPECT_NEAR((lump.area_a + lump.area_b).norm(), 0, 1e-15);
    EXPECT_NEAR(lump.pieces_a, lump.area_a.norm(), 1e-15);
    EXPECT_FALSE(lump.open);
    EXPECT_TRUE(lump.has_volume(overlap.rounding()));
    EXPECT_EQ(lump.box.max, Vector3d(1, 1, 1));
    EXPECT_EQ(lump.box.min, Vector3d(0.5, 0.375, 0.25));
}

TEST(OverlapPatches, WindAsSolidAnglesSay)
{
    int inside = 0, outside = 0;
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.08, 400), ball = make_sphere_mesh(0.4, 300);
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        const Overlap overlap(knot, ball, random_pose(seed, 0.4));
        for (const int side : {0, 1})
            for (const Patch& p : overlap.patches[side]) {
                EXPECT_FALSE(p.conflict) << seed;
                for (int k = 0; k < 3; ++k) {
                    EXPECT_EQ(p.inside[k], std::lround(overlap.winding(side, p.points[k]))) << seed;
                    ++(p.inside[k] ? inside : outside);
                }
            }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(outside, 1000);
}

TEST(OverlapPatches, CountAPointInTwoPartsTwice)
{
    // A stake into two boxes that overlap each other: its tip is in both.
    const Mesh stake = make_box_mesh({0.125, 0.125, 2}), box = make_box_mesh({1, 1, 1});
    const Mesh boxes = joined({box, moved(box, {0, 0, -0.5})});
    for (const double depth :
         {0.25, 0.0}) { // in the second box; at 0 it touches its face, as b counts as moved along z
        const Overlap overlap(stake, boxes, at(0, 0, -2.5 + depth));
        int twice = 0;
        for (const Patch& p : overlap.patches[0])
            for (int k = 0; k < 3; ++k) {
                EXPECT_EQ(p.inside[k], p.points[k].z() < 0 ? 2 : 0);
                twice += p.inside[k] == 2;
            }
        EXPECT_GT(twice, 0);
        double volume = 0;
        for (const Lump& lump : overlap.lumps) volume += lump.volume;
        EXPECT_NEAR(volume, 0.0625 * (0.5 + 2 * depth), 1e-14) << "both parts count";
    }
}

TEST(OverlapPatches, ABarThroughTwoWallsHasTwoLumps)
{
    const Mesh wall = make_box_mesh({0.125, 1, 1}), bar = make_box_mesh({2, 0.25, 0.25}, 8);
    const Mesh walls = joined({moved(wall, {-1, 0, 0}), moved(wall, {1, 0, 0})});
    const Overlap overlap(walls, bar, Isometry3d::Identity());
    ASSERT_EQ(overlap.lumps.size(), 2u);
    for (const Lump& lump : overlap.lumps) {
        EXPECT_NEAR(lump.volume, 0.25 * 0.25, 1e-15);
        EXPECT_NEAR(lump.area_a.norm(), 0, 1e-15) << "the bar leaves through the other side";
        EXPECT_NEAR(lump.pieces_a, 2 * 0.25, 1e-15);
        EXPECT_TRUE(lump.has_volume(overlap.rounding()));
    }
    for (std::size_t i = 0; i < overlap.pairs.size(); ++i)
        if (const std::uint32_t patch = overlap.crossing[i]; patch != OverlapPatches::none) {
            EXPECT_EQ(overlap.patches[0][patch].triangle, overlap.pairs[i].a);
        }
}

TEST(OverlapPatches, FacesThatTouchHaveNoVolume)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    const Overlap overlap(box, box, at(0.5, 0.25, 2));
    EXPECT_FALSE(overlap.pairs.empty());
    for (const Lump& lump : overlap.lumps) EXPECT_FALSE(lump.has_volume(overlap.rounding()));
    const Overlap apart(box, box, at(0, 0, 2.5));
    EXPECT_TRUE(apart.pairs.empty() && apart.lumps.empty());
}

TEST(OverlapPatches, WhatRoundingMakesHasNoVolume)
{
    const Mesh box = make_box_mesh({1, 1, 1});
    int rounded = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        const Isometry3d pose = random_pose(seed, 0.5);
        std::vector<Vector3d> vertices;
        for (const Vector3d& v : box.vertices) vertices.push_back(pose * v);
        const Mesh turned = make_mesh("turned", std::move(vertices), box.triangles);
        const Overlap overlap(turned, box, pose * at(0.5, 0.25, 2));
        for (const Lump& lump : overlap.lumps) {
            EXPECT_FALSE(lump.has_volume(overlap.rounding())) << seed;
            rounded += lump.volume > 0;
        }
    }
    EXPECT_GT(rounded, 0);
}

TEST(OverlapPatches, TheCurveIsOnBothSurfaces)
{
    const Mesh ball = make_sphere_mesh(0.5, 500), box = make_box_mesh({0.5, 0.5, 0.5});
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const Overlap overlap(ball, box, random_pose(seed, 0.3));
        ASSERT_EQ(overlap.curve.size() % 2, 0u);
        for (const CurvePoint& c : overlap.curve)
            for (const auto& [side, patch] : {std::pair(0, c.patch_a), std::pair(1, c.patch_b)}) {
                const Patch& p = overlap.patches[side][patch];
                EXPECT_NEAR(p.normal.dot(c.at - p.points[0]), 0, 1e-14) << seed;
                for (int k = 0; k < 3; ++k) {
                    const Vector3d& from = p.points[k];
                    EXPECT_GT(p.normal.dot((p.points[(k + 1) % 3] - from).cross(c.at - from)), -1e-14) << seed;
                }
            }
    }
}

} // namespace
} // namespace oncollide::overlap_patches_test
