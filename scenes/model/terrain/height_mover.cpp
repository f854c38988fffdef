#include <oncollide/scenes/model/terrain/height_mover.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/vertex_mover.hpp>

namespace oncollide {

void refuse_height(const std::string& name, std::size_t column, std::size_t row, double height)
{
    refuse(name, fmt::format("the height in column {}, row {} is {}; {}", column, row, height,
                             std::isnan(height) ? "set no_data to NaN if such heights are holes"
                                                : fmt::format("at most {:g} m are allowed", largest_coordinate)));
}

namespace {

/// The height as it is stored: NaN for a hole.
double stored_height(const Terrain& terrain, double given)
{
    return given == terrain.no_data() ? std::numeric_limits<double>::quiet_NaN() : given;
}

bool is_in(const TerrainRectangle& where, std::uint32_t column, std::uint32_t row)
{
    return column - where.column < where.columns && row - where.row < where.rows;
}

/// The number of present cells after a change. Cost: O(heights of the rectangle).
std::uint64_t cells_after(const Terrain& terrain, const TerrainRectangle& where, std::span<const double> heights)
{
    const auto height = [&](std::uint32_t column, std::uint32_t row) {
        if (!is_in(where, column, row)) return TerrainAccess::height(terrain, column, row);
        return stored_height(terrain, heights[std::size_t(row - where.row) * where.columns + (column - where.column)]);
    };
    std::uint64_t cells = terrain.cells();
    const std::uint32_t x1 = std::min(where.column + where.columns, terrain.cells_x()),
                        y1 = std::min(where.row + where.rows, terrain.cells_y());
    for (std::uint32_t y = where.row - (where.row > 0); y < y1; ++y)
        for (std::uint32_t x = where.column - (where.column > 0); x < x1; ++x) {
            cells -= terrain.has_cell(x, y);
            cells += !std::isnan(height(x, y) + height(x + 1, y) + height(x, y + 1) + height(x + 1, y + 1));
        }
    return cells;
}

} // namespace

HeightMove examine_heights(const std::string& name, const Terrain& terrain, const TerrainRectangle& where,
                           std::span<const double> heights)
{
    ONCOLLIDE_ASSERT(heights.size() == std::size_t(where.columns) * where.rows);
    HeightMove move;
    double largest = 0; // magnitude of a height, before or after
    TerrainAccess::with_heights(terrain, [&](auto height_at) {
        const double* given = heights.data();
        for (std::uint32_t row = where.row; row < where.row + where.rows; ++row)
            for (std::uint32_t column = where.column; column < where.column + where.columns; ++column, ++given) {
                const double now = stored_height(terrain, *given), before = height_at(column, row);
                if (std::isnan(now) ? !terrain.no_data().has_value() : !(std::abs(now) <= largest_coordinate))
                    refuse_height(name, column, row, *given);
                move.holes |= std::isnan(now) != std::isnan(before);
                const double moved = std::abs(now - before); // NaN at a hole
                if (moved > move.distance) move.distance = moved;
                if (moved > 0) largest = std::max({largest, std::abs(now), std::abs(before)});
            }
    });
    if (move.holes && cells_after(terrain, where, heights) == 0)
        refuse(name, "the terrain has no cell: each touches a hole");
    // The difference was rounded, and points at these heights are rounded, too.
    if (move.distance > 0)
        move.distance = move.distance * (1 + 0x1p-50) + 0x1p-51 * (largest + std::abs(terrain.origin().z()));
    return move;
}

void HeightMover::Extent::add(const Extent& other)
{
    low = std::min(low, other.low), high = std::max(high, other.high);
    least = {std::min(least.column, other.least.column), std::min(least.row, other.least.row)};
    greatest = {std::max(greatest.column, other.greatest.column), std::max(greatest.row, other.greatest.row)};
    cells += other.cells;
}

HeightMover::HeightMover(Terrain& terrain) : own_(std::make_shared<TerrainHeights>())
{
    own_->falling = terrain.heights_->falling;
    LargeVector<double> samples(std::size_t(terrain.tiles_x_) * ((terrain.rows_ - 1) / Terrain::tile + 1) *
                                    Terrain::tile * Terrain::tile,
                                std::numeric_limits<double>::quiet_NaN());
    TerrainAccess::with_heights(terrain, [&](auto height_at) {
        for (std::uint32_t row = 0; row < terrain.rows_; ++row)
            for (std::uint32_t column = 0; column < terrain.columns_; ++column)
                samples[TerrainAccess::place(terrain, column, row)] = height_at(column, row);
    });
    own_->samples = std::move(samples);
    terrain.heights_ = own_, terrain.bytes_ = 8;

    const auto blocks = [](std::uint32_t below) { return (below - 1) / side + 1; };
    std::uint32_t across = terrain.cells_x(), down = terrain.cells_y();
    do {
        across = blocks(across), down = blocks(down);
        levels_.push_back({across, down, std::vector<Extent>(std::size_t(across) * down)});
    } while (across > 1 || down > 1);
    find_extents(terrain, {0, 0, terrain.cells_x() - 1, terrain.cells_y() - 1});
}

HeightMover::Extent HeightMover::extent_of(const Terrain& terrain, std::uint32_t x, std::uint32_t y)
{
    Extent extent;
    const std::uint32_t x0 = x * side, x1 = std::min(x0 + side, terrain.cells_x()), y0 = y * side,
                        y1 = std::min(y0 + side, terrain.cells_y());
    const auto& samples = std::get<LargeVector<double>>(terrain.heights_->samples);
    double z[side + 1][side + 1];
    bool holes = false;
    for (std::uint32_t row = y0; row <= y1; ++row)
        for (std::uint32_t column = x0; column <= x1; ++column) {
            const double height = z[row - y0][column - x0] = samples[TerrainAccess::place(terrain, column, row)];
            extent.low = height < extent.low ? height : extent.low;
            extent.high = height > extent.high ? height : extent.high;
            holes |= std::isnan(height);
        }
    if (!holes) {
        extent.least = {x0, y0}, extent.greatest = {x1, y1}, extent.cells = std::uint64_t(x1 - x0) * (y1 - y0);
        return extent;
    }
    extent = {};
    for (std::uint32_t j = 0; j < y1 - y0; ++j)
        for (std::uint32_t i = 0; i < x1 - x0; ++i) {
            const double a = z[j][i], b = z[j][i + 1], c = z[j + 1][i], d = z[j + 1][i + 1];
            if (std::isnan(a + b + c + d)) continue;
            const auto [low, high] = std::minmax({a, b, c, d});
            extent.add({low, high, {x0 + i, y0 + j}, {x0 + i + 1, y0 + j + 1}, 1});
        }
    return extent;
}

void HeightMover::find_extents(const Terrain& terrain, CellRange of)
{
    for (std::size_t level = 0; level < levels_.size(); ++level) {
        of = {of.x0 / side, of.y0 / side, of.x1 / side, of.y1 / side};
        const Level* const below = level ? &levels_[level - 1] : nullptr;
        for (std::uint32_t y = of.y0; y <= of.y1; ++y)
            for (std::uint32_t x = of.x0; x <= of.x1; ++x) {
                Extent& extent = levels_[level].blocks[std::size_t(y) * levels_[level].across + x];
                if (!below) {
                    extent = extent_of(terrain, x, y);
                    continue;
                }
                extent = {};
                for (std::uint32_t j = y * side; j < std::min((y + 1) * side, below->down); ++j)
                    for (std::uint32_t i = x * side; i < std::min((x + 1) * side, below->across); ++i)
                        extent.add(below->blocks[std::size_t(j) * below->across + i]);
            }
    }
}

HeightMove HeightMover::move(const std::string& name, Terrain& terrain, const TerrainRectangle& where,
                             std::span<const double> heights)
{
    const HeightMove move = examine_heights(name, terrain, where, heights);
    if (!move.any()) return move;
    ONCOLLIDE_ASSERT(terrain.heights_ == own_);
    if (own_.use_count() > 2) // a copy of the terrain shares them
        terrain.heights_ = own_ = std::make_shared<TerrainHeights>(*own_);
    auto& samples = std::get<LargeVector<double>>(own_->samples);
    const double* given = heights.data();
    for (std::uint32_t row = where.row; row < where.row + where.rows; ++row)
        for (std::uint32_t column = where.column; column < where.column + where.columns; ++column)
            samples[TerrainAccess::place(terrain, column, row)] = stored_height(terrain, *given++);

    find_extents(terrain, {where.column - (where.column > 0), where.row - (where.row > 0),
                           std::min(where.column + where.columns, terrain.cells_x()) - 1,
                           std::min(where.row + where.rows, terrain.cells_y()) - 1});
    const Extent& all = levels_.back().blocks.front();
    terrain.cells_ = all.cells, terrain.holes_ = all.cells < std::uint64_t(terrain.cells_x()) * terrain.cells_y();
    terrain.least_ = all.least, terrain.greatest_ = all.greatest, terrain.low_ = all.low, terrain.high_ = all.high;
    terrain.find_bounds();
    return move;
}

} // namespace oncollide
