#include <oncollide/narrowphase/pairs/manifolds/facings.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace oncollide::facings_test {
namespace {

using Eigen::Vector3d;

/// Adds a patch with an outward normal.
void add(OverlapPatches& overlap, int side, const Vector3d& normal, double area, const Vector3d& centre,
         std::uint32_t lump = 0)
{
    Patch patch{};
    patch.lump = lump, patch.normal = normal.normalized(), patch.area = area, patch.moment = area * centre;
    overlap.patches[side].push_back(patch);
}

LumpFacings find(PatchFacings& facings, const OverlapPatches& overlap, double spread = 0.2)
{
    LumpParts parts;
    parts.set(overlap), facings.clear(overlap);
    return facings.find(overlap, parts[0], spread);
}

TEST(Facings, TheSidesOfASunkBoxFaceNothing)
{
    OverlapPatches overlap;
    overlap.lumps.resize(1);
    add(overlap, 0, {0, 0, 1}, 4, {0, 0, 0});     // the ground
    add(overlap, 1, {0, 0, -1}, 4, {0, 0, -0.1}); // the box's base
    for (const Vector3d& out : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, -1, 0)})
        add(overlap, 1, out, 0.2, out - Vector3d(0, 0, 0.05));
    PatchFacings facings;
    const LumpFacings found = find(facings, overlap);
    ASSERT_EQ(found.all.size(), 1u);
    EXPECT_EQ(found.all[0].direction, Vector3d(Vector3d::UnitZ()));
    EXPECT_EQ(found.all[0].matched(), 4);
    EXPECT_NEAR(found.all[0].thickness(), 0.1, 1e-15);
    EXPECT_EQ(facings.of(0, 0, found), 0u);
    EXPECT_EQ(facings.of(1, 0, found), 0u);
    for (const std::uint32_t side : {1u, 2u, 3u, 4u}) EXPECT_EQ(facings.of(1, side, found), PatchFacings::none);
}

TEST(Facings, AGrooveHasTwoDirections)
{
    OverlapPatches overlap;
    overlap.lumps.resize(1);
    for (const double x : {1.0, -1.0}) {
        add(overlap, 0, {x, 0, 1}, 1, {-x, 0, 0});
        add(overlap, 1, {-x, 0, -1}, 1, Vector3d(-x, 0, 0) - 0.01 * Vector3d(x, 0, 1));
    }
    PatchFacings facings;
    LumpFacings found = find(facings, overlap);
    ASSERT_EQ(found.all.size(), 2u);
    EXPECT_NE(facings.of(0, 0, found), facings.of(0, 1, found));
    EXPECT_EQ(facings.of(0, 0, found), facings.of(1, 0, found));
    EXPECT_EQ(facings.of(0, 1, found), facings.of(1, 1, found));
    join_facings(found, 1); // the directions are pi / 2 apart
    EXPECT_EQ(found.all.size(), 2u);
    join_facings(found, 1.6);
    ASSERT_EQ(found.all.size(), 1u);
    EXPECT_EQ(found.all[0].matched(), 2);
    EXPECT_EQ(facings.of(0, 0, found), 0u);
    EXPECT_EQ(facings.of(1, 1, found), 0u);
}

TEST(Facings, TheFarSidesOfAnOverlapAreNoContact)
{
    OverlapPatches overlap; // a plate of 0.1 x 1 x 1: its two large sides face each other, and its small sides, too
    overlap.lumps.resize(1);
    add(overlap, 0, {0, 0, 1}, 1, {0, 0, 0.1});
    add(overlap, 1, {0, 0, -1}, 1, {0, 0, 0});
    add(overlap, 0, {1, 0, 0}, 0.1, {1, 0, 0});
    add(overlap, 1, {-1, 0, 0}, 0.1, {0, 0, 0});
    PatchFacings facings;
    const LumpFacings found = find(facings, overlap);
    ASSERT_EQ(found.all.size(), 1u);
    EXPECT_EQ(found.all[0].direction, Vector3d(Vector3d::UnitZ()));
}

TEST(Facings, DirectionsWithLittleAreaHaveNoRegion)
{
    OverlapPatches overlap;
    overlap.lumps.resize(1);
    for (const auto& [out, area] : {std::pair(Vector3d(0, 0, 1), 1.0), std::pair(Vector3d(1, 0, 0), 0.01)}) {
        add(overlap, 0, out, area, {0, 0, 0});
        add(overlap, 1, -out, area, -0.01 * out);
    }
    PatchFacings facings;
    EXPECT_EQ(find(facings, overlap).all.size(), 1u);
    overlap.patches[0][1].area = overlap.patches[1][1].area = 0.1;
    EXPECT_EQ(find(facings, overlap).all.size(), 2u);
}

TEST(Facings, PartsOfLumpsHaveTheirPatchesAndPoints)
{
    OverlapPatches overlap;
    overlap.lumps.resize(3);
    for (const std::uint32_t lump : {2u, 0u, 2u, 2u}) add(overlap, 0, {0, 0, 1}, 1, {0, 0, 0}, lump);
    for (const std::uint32_t lump : {0u, 2u}) add(overlap, 1, {0, 0, -1}, 1, {0, 0, 0}, lump);
    for (const std::uint32_t patch : {0u, 1u, 3u}) overlap.curve.push_back({Vector3d::Zero(), patch, 0, 0, 0});
    LumpParts parts;
    for (int use = 0; use < 2; ++use) { // the memory is kept
        parts.set(overlap);
        const auto numbers = [](std::span<const std::uint32_t> s) { return std::vector(s.begin(), s.end()); };
        EXPECT_EQ(numbers(parts[0].a), (std::vector{1u}));
        EXPECT_EQ(numbers(parts[0].b), (std::vector{0u}));
        EXPECT_EQ(numbers(parts[0].curve), (std::vector{1u}));
        EXPECT_TRUE(parts[1].a.empty() && parts[1].b.empty() && parts[1].curve.empty());
        EXPECT_EQ(numbers(parts[2].a), (std::vector{0u, 2u, 3u}));
        EXPECT_EQ(numbers(parts[2].b), (std::vector{1u}));
        EXPECT_EQ(numbers(parts[2].curve), (std::vector{0u, 2u}));
    }
}

} // namespace
} // namespace oncollide::facings_test
