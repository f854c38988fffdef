// Changes of heights: the terrain is as one that is made anew from the same heights.
#include <gtest/gtest.h>

#include <oncollide/scenes/model/terrain/height_mover.hpp>

#include "digging.hpp"
#include "test_files.hpp"

namespace oncollide::height_mover_test {
namespace {

using test::expect_error;

void expect_same(const Terrain& now, const Terrain& made, const std::string& when)
{
    ASSERT_EQ(now.bounds().min, made.bounds().min) << when;
    ASSERT_EQ(now.bounds().max, made.bounds().max) << when;
    ASSERT_EQ(now.cells(), made.cells()) << when;
    ASSERT_EQ(now.holes(), made.holes()) << when;
    ASSERT_EQ(now.error(), made.error()) << when;
    for (std::uint32_t row = 0; row < made.rows(); ++row)
        for (std::uint32_t column = 0; column < made.columns(); ++column) {
            const double a = now.height(column, row), b = made.height(column, row);
            ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << when << ": " << column << ' ' << row;
        }
    for (std::uint32_t y = 0; y < made.cells_y(); ++y)
        for (std::uint32_t x = 0; x < made.cells_x(); ++x) {
            ASSERT_EQ(now.has_cell(x, y), made.has_cell(x, y)) << when;
            ASSERT_EQ(now.diagonal(x, y), made.diagonal(x, y)) << when;
        }
}

TEST(HeightMover, MakesTheTerrainOfTheSameHeights)
{
    struct Size {
        std::uint32_t columns, rows;
    };
    int refused = 0, flips = 0;
    for (const auto& [columns, rows] : {Size{2, 2}, Size{2, 40}, Size{9, 9}, Size{17, 3}, Size{130, 70}})
        for (const double unit : {0.0, 0.25})
            for (const double holes : {0.0, 0.1}) {
                DugTerrain dug(columns, rows, 0.5, unit, columns < 5 && holes > 0 ? 1e-9 : holes, columns + rows);
                Terrain terrain = dug.made();
                HeightMover mover(terrain);
                expect_same(terrain, dug.made(), "before");
                for (int k = 0; k < 150; ++k) {
                    const std::string when =
                        fmt::format("{} x {}, unit {}, holes {}: {}", columns, rows, unit, holes, k);
                    const Terrain before = terrain;
                    const std::vector<double> then = dug.heights();
                    const Dig dig = dug.dig();
                    HeightMove moved;
                    try {
                        moved = mover.move("dug", terrain, dig.where, dig.heights);
                    } catch (const Error& error) { // the last cell would go
                        ASSERT_THROW(dug.made(), Error) << when;
                        expect_same(terrain, before, when + ", refused");
                        dug = DugTerrain(columns, rows, 0.5, unit, 1e-9, std::uint64_t(k));
                        terrain = dug.made(), mover = HeightMover(terrain);
                        ++refused;
                        continue;
                    }
                    ASSERT_NO_FATAL_FAILURE(expect_same(terrain, dug.made(), when));
                    double most = 0;
                    bool flipped = false;
                    for (std::size_t i = 0; i < then.size(); ++i) {
                        const double now = dug.heights()[i];
                        ASSERT_TRUE(then[i] == before.height(std::uint32_t(i % columns), std::uint32_t(i / columns)) ||
                                    std::isnan(then[i]))
                            << when << ": a copy keeps the old heights";
                        flipped |= std::isnan(then[i]) != std::isnan(now);
                        if (const double by = std::abs(now - then[i]); by > most) most = by;
                    }
                    ASSERT_EQ(moved.holes, flipped) << when;
                    ASSERT_GE(moved.distance, most) << when;
                    ASSERT_LE(moved.distance, most * (1 + 1e-12) + (most > 0 ? 1e-14 : 0)) << when;
                    flips += flipped;
                }
            }
    EXPECT_GT(refused, 3);
    EXPECT_GT(flips, 300);
}

TEST(HeightMover, KeepsTheErrorOfHeightsThatWereStoredInFewerBytes)
{
    TerrainGrid grid{.columns = 20, .rows = 20};
    grid.bytes = 1, grid.error = 0.25;
    std::vector<double> heights;
    for (int i = 0; i < 400; ++i) heights.push_back(0.37 * (i % 23) * (i % 7));
    Terrain terrain = make_terrain("coarse", grid, heights);
    const double error = terrain.error(), old = terrain.height(3, 4);
    EXPECT_GT(error, 0.25);
    HeightMover mover(terrain);
    const double one[] = {1.0 / 3};
    mover.move("coarse", terrain, {5, 5, 1, 1}, one);
    EXPECT_EQ(terrain.height(5, 5), 1.0 / 3);
    EXPECT_EQ(terrain.height(3, 4), old);
    EXPECT_EQ(terrain.error(), error);
    EXPECT_EQ(terrain.bytes_per_height(), 8);
}

TEST(HeightMover, NamesTheHeightThatItRefuses)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    DugTerrain dug(10, 8, 1, 0, 0, 1);
    Terrain terrain = dug.made();
    HeightMover mover(terrain);
    std::vector<double> heights(6, 0.25);
    const auto refuse = [&](double height, const char* words) {
        heights[4] = height;
        expect_error(
            ErrorKind::bad_data,
            [&] {
                mover.move("dug", terrain, {3, 5, 3, 2}, heights);
            },
            words);
        expect_same(terrain, dug.made(), words);
    };
    refuse(nan, "dug: the height in column 4, row 6 is nan; set no_data to NaN");
    refuse(2e15, "dug: the height in column 4, row 6 is 2000000000000000; at most 1e+15 m");
    refuse(-std::numeric_limits<double>::infinity(), "column 4, row 6 is -inf");
}

TEST(HeightMover, TakesTheValueOfNoDataAsAHole)
{
    TerrainGrid grid{.columns = 3, .rows = 3};
    grid.no_data = -9999;
    Terrain terrain = make_terrain("t", grid, std::vector<double>(9, 1));
    EXPECT_FALSE(terrain.holes());
    HeightMover mover(terrain);
    const double hole[] = {-9999}, height[] = {2}, nan[] = {std::numeric_limits<double>::quiet_NaN()};
    EXPECT_TRUE(mover.move("t", terrain, {0, 0, 1, 1}, hole).holes);
    EXPECT_EQ(terrain.cells(), 3u);
    EXPECT_FALSE(mover.move("t", terrain, {0, 0, 1, 1}, nan).any()) << "it was one";
    expect_error(
        ErrorKind::bad_data,
        [&] {
            mover.move("t", terrain, {1, 1, 1, 1}, nan);
        },
        "no cell");
    EXPECT_TRUE(mover.move("t", terrain, {0, 0, 1, 1}, height).holes);
    EXPECT_EQ(terrain.cells(), 4u);
    EXPECT_EQ(terrain.bounds().max.z(), 2);
}

} // namespace
} // namespace oncollide::height_mover_test
