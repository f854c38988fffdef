// Terrains: storage of heights, and the errors of make_terrain.
#include <cmath>

#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/terrain.hpp>

#include "test_files.hpp"

namespace oncollide {
namespace {

using test::expect_error;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TerrainGrid grid_of(std::uint32_t columns, std::uint32_t rows, int bytes = 0)
{
    TerrainGrid grid{.columns = columns, .rows = rows};
    grid.bytes = bytes;
    return grid;
}

/// Slopes of all sizes, so that tiles need different shifts.
std::vector<double> heights_of(const TerrainGrid& grid, double unit)
{
    std::vector<double> heights;
    for (std::uint32_t r = 0; r < grid.rows; ++r)
        for (std::uint32_t c = 0; c < grid.columns; ++c) {
            const double height = std::pow(1.3, c) * r - 3 * c + u01(5, r, c);
            heights.push_back(unit > 0 ? unit * std::floor(height) : height);
        }
    return heights;
}

TEST(TerrainHeights, AreOffByNoMoreThanTheErrorSays)
{
    for (const int bytes : {0, 1, 2, 4, 8})
        for (const double unit : {0.0, 0.25, 0.1})
            for (const bool holes : {false, true}) {
                TerrainGrid grid = grid_of(29, 19, bytes);
                grid.unit = unit;
                std::vector<double> heights = heights_of(grid, unit);
                if (holes) {
                    grid.no_data = -9999;
                    for (std::uint64_t i = 0; i < heights.size(); ++i)
                        if (u01(1, i, 0) < 0.1) heights[i] = -9999;
                }
                const Terrain terrain = make_terrain("t", grid, heights);
                double off = 0, low = 1e9, high = -1e9;
                for (std::uint32_t r = 0; r < grid.rows; ++r)
                    for (std::uint32_t c = 0; c < grid.columns; ++c) {
                        const double given = heights[r * grid.columns + c], kept = terrain.height(c, r);
                        ASSERT_EQ(given == -9999, std::isnan(kept)) << c << ' ' << r;
                        if (given != -9999) off = std::max(off, std::abs(given - kept));
                        if (given != -9999) low = std::min(low, given), high = std::max(high, given);
                    }
                EXPECT_LE(off, terrain.error());
                EXPECT_LE(terrain.error(), off * (1 + 1e-9));
                if (bytes == 0 || bytes == 8) {
                    EXPECT_EQ(off, 0);
                }
                if (bytes) {
                    EXPECT_EQ(terrain.bytes_per_height(), bytes);
                }
                EXPECT_LE(off, (high - low) / (bytes == 1 ? 400 : 1e5));
                if (!holes) {
                    EXPECT_LE(terrain.bounds().min.z(), low);
                    EXPECT_GE(terrain.bounds().max.z(), high);
                }
            }
}

TEST(TerrainHeights, TakeTheFewestBytesThatAreExact)
{
    const auto bytes = [](double step, std::size_t count = 100) {
        std::vector<double> heights;
        for (std::size_t i = 0; i < count; ++i) heights.push_back(step * double(i % 97));
        return make_terrain("t", grid_of(10, 10), heights).bytes_per_height();
    };
    EXPECT_EQ(bytes(1), 1);
    EXPECT_EQ(bytes(0.125), 1);
    EXPECT_EQ(bytes(300), 2);
    EXPECT_EQ(bytes(1000.125), 4);
    EXPECT_EQ(bytes(0.1), 8);
    std::vector<float> floats;
    for (int i = 0; i < 100; ++i) floats.push_back(0.1f * float(i));
    EXPECT_EQ(make_terrain("t", grid_of(10, 10), floats).bytes_per_height(), 4);
    // Integer multiples of a tenth, as from a file of integers with a scale.
    TerrainGrid grid = grid_of(10, 10);
    grid.unit = 0.1;
    std::vector<double> tenths;
    for (int i = 0; i < 100; ++i) tenths.push_back(0.1 * i);
    const Terrain terrain = make_terrain("t", grid, tenths);
    EXPECT_EQ(terrain.bytes_per_height(), 1);
    EXPECT_EQ(terrain.error(), 0);
    EXPECT_EQ(terrain.height(7, 3), 0.1 * 37);
}

TEST(TerrainHeights, GiveCellsTheirDiagonals)
{
    TerrainGrid grid = grid_of(3, 2);
    grid.falling = {false, true};
    const Terrain terrain = make_terrain("t", grid, std::vector<double>{0, 1, 2, 3, 4, 5});
    EXPECT_EQ(terrain.diagonal(0, 0), CellDiagonal::rising);
    EXPECT_EQ(terrain.diagonal(1, 0), CellDiagonal::falling);
    const Mesh mesh = mesh_of(terrain);
    ASSERT_EQ(mesh.triangles.size(), 4u);
    EXPECT_EQ(mesh.triangles[0], (Triangle{0, 1, 4}));
    EXPECT_EQ(mesh.triangles[1], (Triangle{0, 4, 3}));
    EXPECT_EQ(mesh.triangles[2], (Triangle{1, 2, 4}));
    EXPECT_EQ(mesh.triangles[3], (Triangle{2, 5, 4}));
    for (const Triangle& t : mesh.triangles) { // seen from above, counter-clockwise
        const Eigen::Vector3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
        EXPECT_GT((b - a).cross(c - a).z(), 0);
    }
}

TEST(TerrainHeights, LeaveOutCellsAtHoles)
{
    TerrainGrid grid = grid_of(4, 3);
    grid.no_data = nan;
    std::vector<double> heights(12, 1.0);
    heights[0] = nan, heights[1] = 50; // the 50 is in one cell, beside the hole's
    heights[11] = nan;
    const Terrain terrain = make_terrain("t", grid, heights);
    EXPECT_TRUE(terrain.holes());
    EXPECT_EQ(terrain.cells(), 4u);
    EXPECT_FALSE(terrain.has_cell(0, 0));
    EXPECT_TRUE(terrain.has_cell(1, 0));
    EXPECT_FALSE(terrain.has_cell(2, 1));
    EXPECT_EQ(mesh_of(terrain).triangles.size(), 8u);
    EXPECT_EQ(terrain.bounds().max.z(), 50);
    const Terrain middle = centred(terrain);
    EXPECT_TRUE(middle.bounds().centre().isZero(1e-12));
    EXPECT_EQ(middle.bounds().max.z(), 24.5);
}

TEST(TerrainHeights, RefusesWhatIsNoTerrain)
{
    const std::vector<double> four{0, 1, 2, 3};
    const auto refused = [&](TerrainGrid grid, const std::vector<double>& heights, auto... parts) {
        expect_error(
            ErrorKind::bad_data, [&] { make_terrain("land", grid, heights); }, "land: ", parts...);
    };
    refused(grid_of(4, 1), four, "4 x 1", "at least two");
    refused(grid_of(0, 0), {}, "at least two");
    refused(grid_of(100'000, 100'000), four, "2147483648 cells");
    refused(grid_of(0xffffffff, 0xffffffff), four, "2147483648 cells");
    refused(grid_of(2, 3), four, "4 heights for 2 x 3");
    refused(grid_of(2, 2), {0, 1, nan, 3}, "column 0, row 1", "no_data");
    refused(grid_of(2, 2), {0, 1, 2, std::numeric_limits<double>::infinity()}, "column 1, row 1", "inf");
    refused(grid_of(2, 2), {0, 1e16, 2, 3}, "column 1, row 0", "1e+15 m are allowed");
    TerrainGrid grid = grid_of(2, 2);
    grid.no_data = 7;
    refused(grid, {7, 7, 7, 7}, "every height is a hole");
    refused(grid, {7, 1, 2, 3}, "no cell");
    for (const double spacing : {0.0, -1.0, nan}) {
        grid = grid_of(2, 2), grid.spacing = {1, spacing};
        refused(grid, four, "the spacing is");
    }
    grid = grid_of(2, 2), grid.spacing = {1e15, 1e16};
    refused(grid, four, "1e+15 m");
    grid = grid_of(2, 2), grid.origin = {1e9, 0, 0}, grid.spacing = {0.5, 0.5};
    refused(grid, four, "too small");
    grid = grid_of(2, 2), grid.falling = {true, false};
    refused(grid, four, "2 diagonals for 1 x 1 cells");
    grid = grid_of(2, 2, 3);
    expect_error(
        ErrorKind::usage, [&] { make_terrain("land", grid, four); }, "land: ", "3 bytes");
    grid = grid_of(2, 2), grid.error = -1;
    refused(grid, four, "error of heights is -1");
    expect_error(
        ErrorKind::usage, [] { make_hills(0, 5, 1, 1, 1); }, "hills", "number of cells");
    expect_error(
        ErrorKind::usage, [] { make_hills(5, 5, 0, 1, 1); }, "hills", "spacing");
}

TEST(TerrainHeights, OfHillsAreTheSameEverywhere)
{
    const Terrain hills = make_hills(40, 30, 2, 10, 3);
    EXPECT_EQ(hills.columns(), 41u);
    EXPECT_LE(hills.bytes_per_height(), 2);
    EXPECT_EQ(hills.error(), 0);
    EXPECT_GE(hills.bounds().min.z(), 0);
    EXPECT_LE(hills.bounds().max.z(), 10);
    EXPECT_GT(hills.bounds().max.z() - hills.bounds().min.z(), 3);
    EXPECT_EQ(hills.height(7, 11), 6.058837890625);
    EXPECT_EQ(hills.height(40, 30), 3.7890625);
}

} // namespace
} // namespace oncollide
