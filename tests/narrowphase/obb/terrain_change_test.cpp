// The quadtree of a terrain whose heights change: as a tree that is made anew.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/narrowphase/obb/solid_gap_kernel.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/scenes/model/terrain/height_mover.hpp>

#include "digging.hpp"

namespace oncollide::terrain_change_test {
namespace {

/// Compares the boxes of all nodes of two trees of the same heights, from the top. They are equal; if the ranges have
/// other zero levels, rounding may differ.
class Comparison {
public:
    Comparison(const TerrainTree& now, const TerrainTree& made, double scale)
        : now_(now), made_(made), up_(now.centre().z() - made.centre().z()), slack_(0x1p-18 * scale)
    {
    }
    void run() { below(TerrainTree::root); }

private:
    void below(const TerrainTree::Node& node)
    {
        OpenBoxes a, b;
        const LaneMasks masks = now_.open(node, nullptr, a), others = made_.open(node, nullptr, b);
        ASSERT_EQ(masks.leaves, others.leaves);
        compare_blocks(node);
        for (unsigned k = 0; k < 8; ++k) {
            ASSERT_EQ(a.c[0][k] > 1e29f, b.c[0][k] > 1e29f);
            if (a.c[0][k] > 1e29f) continue;
            // The ends of a small block are steps of its square's height, which rounding may shift by one.
            const double step =
                node.level == 1 ? (made_.terrain().bounds().max - made_.terrain().bounds().min).z() / 255 : 0;
            for (const float sign : {-1.0f, 1.0f}) {
                const double end = a.c[2][k] + sign * a.h[2][k], other = b.c[2][k] + sign * b.h[2][k];
                ASSERT_NEAR(end + up_, other, up_ == 0 ? 0 : slack_ + step) << "level " << node.level;
            }
            if (!(masks.leaves >> k & 1)) below(now_.child(node, k));
            if (testing::Test::HasFatalFailure()) return;
        }
    }
    void compare_blocks(const TerrainTree::Node& node)
    {
        if (node.whole || node.level == 0 || node.level >= TerrainTree::triangles) return;
        TerrainBlocks a, b;
        now_.open_blocks(node, made_.centre(), a), made_.open_blocks(node, made_.centre(), b);
        for (unsigned k = 0; k < 8 && up_ == 0; ++k) {
            ASSERT_EQ(a.low[k], b.low[k]) << "level " << node.level;
            ASSERT_EQ(a.high[k], b.high[k]) << "level " << node.level;
            ASSERT_EQ(a.slab_low[k], b.slab_low[k]) << "level " << node.level;
            ASSERT_EQ(a.slab_high[k], b.slab_high[k]) << "level " << node.level;
            ASSERT_EQ(a.slope_x[k], b.slope_x[k]) << "level " << node.level;
            ASSERT_EQ(a.slope_y[k], b.slope_y[k]) << "level " << node.level;
        }
    }

    const TerrainTree &now_, &made_;
    double up_, slack_;
};

TEST(TerrainTreeChange, GivesTheBoxesOfANewTree)
{
    struct Size {
        std::uint32_t columns, rows;
    };
    int same_level = 0, other_level = 0;
    for (const auto& [columns, rows] :
         {Size{2, 2}, Size{2, 40}, Size{9, 9}, Size{33, 17}, Size{130, 67}, Size{260, 300}, Size{700, 3}})
        for (const double holes : {0.0, 0.05}) {
            DugTerrain dug(columns, rows, 0.5, 0, columns < 5 && holes > 0 ? 1e-9 : holes, columns * rows);
            Terrain terrain = dug.made();
            HeightMover mover(terrain);
            TerrainTree tree(terrain);
            for (int k = 0; k < (columns > 100 ? 25 : 60); ++k) {
                SCOPED_TRACE(fmt::format("{} x {}, holes {}: change {}", columns, rows, holes, k));
                Dig dig;
                // Several changes, each known to the tree.
                for (int i = 0; i < 3; ++i) {
                    dig = dug.dig();
                    try {
                        if (mover.move("dug", terrain, dig.where, dig.heights).any()) tree.change(dig.where);
                    } catch (const Error&) { // the last cell would go: all heights come back
                        dug = DugTerrain(columns, rows, 0.5, 0, 1e-9, std::uint64_t(k));
                        const TerrainRectangle all{0, 0, columns, rows};
                        if (mover.move("dug", terrain, all, dug.heights()).any()) tree.change(all);
                    }
                }
                ASSERT_EQ(tree.validate(), "");
                const Terrain now = dug.made();
                const TerrainTree made(now);
                const double scale = now.bounds().half_extent().z(),
                             off = std::abs(tree.centre().z() - made.centre().z());
                ASSERT_LE(off, 3.001 * scale);
                ASSERT_LE((tree.centre() - now.bounds().centre()).norm() + now.bounds().half_extent().norm(),
                          tree.radius() * (1 + 1e-12));
                ++(off == 0 ? same_level : other_level);
                Comparison comparison(tree, made, scale);
                comparison.run();
                if (HasFatalFailure()) return;
            }
        }
    EXPECT_GT(same_level, 100);
    EXPECT_GT(other_level, 50);
}

} // namespace
} // namespace oncollide::terrain_change_test
