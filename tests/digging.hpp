#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <tuple>
#include <vector>

#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

/// A change of heights.
struct Dig {
    TerrainRectangle where;
    std::vector<double> heights;
};

/// The heights of a terrain that changes, kept beside it: the truth for tests.
class DugTerrain {
public:
    /// @param holes  share of the heights that are holes; 0: there can be none
    DugTerrain(std::uint32_t columns, std::uint32_t rows, double spacing, double unit, double holes, std::uint64_t seed)
        : random_(seed), unit_(unit)
    {
        grid_.columns = columns, grid_.rows = rows, grid_.spacing = {spacing, 1.25 * spacing};
        grid_.origin = {-0.5 * spacing * columns, -0.625 * spacing * rows, -0.25};
        if (holes > 0) grid_.no_data = std::numeric_limits<double>::quiet_NaN();
        for (std::uint32_t i = 0; i < columns * rows; ++i) heights_.push_back(u() < holes ? no_height : height(0.5));
        for (std::uint32_t i = 0; i < (columns - 1) * (rows - 1); ++i) grid_.falling.push_back(u() < 0.5);
    }

    /// The terrain as made anew from the heights.
    Terrain made() const { return make_terrain("dug", grid_, heights_); }
    const std::vector<double>& heights() const { return heights_; }
    const TerrainGrid& grid() const { return grid_; }

    /// Draws a change and applies it: a height, a row, a region at a border or anywhere, or all; raised, dug,
    /// flattened, shaken, shifted as a whole, or left as it is.
    Dig dig()
    {
        const auto part = [&](std::uint32_t all) {
            const auto count = static_cast<std::uint32_t>(1 + below(below(4) ? 1 + all / 4 : all));
            const auto first = static_cast<std::uint32_t>(below(4) ? below(all - count + 1) : all - count);
            return std::pair(first, count);
        };
        Dig dig;
        std::tie(dig.where.column, dig.where.columns) = part(grid_.columns);
        std::tie(dig.where.row, dig.where.rows) = part(grid_.rows);
        if (const auto size = below(10); size < 3)
            dig.where.columns = dig.where.rows = 1;
        else if (size == 3)
            dig.where = {0, 0, grid_.columns, grid_.rows};
        const auto how = below(7);
        const double by = height(below(3) ? 0.125 : 1) - height(0.0625), flat = height(0.5);
        for (std::uint32_t y = 0; y < dig.where.rows; ++y)
            for (std::uint32_t x = 0; x < dig.where.columns; ++x) {
                double& h = heights_[std::size_t(dig.where.row + y) * grid_.columns + dig.where.column + x];
                if (how == 0) h = flat;
                if (how == 1) h = height(0.75);
                if (how == 2 || how == 3) h += by;
                if (how == 4) h += 0.004 * (u() - 0.5);
                if (how == 5) h *= 0.75;
                if (std::abs(h) > 1.5) h = flat;
                if (grid_.no_data && u() < 0.02) h = std::isnan(h) ? flat : no_height;
                dig.heights.push_back(h);
            }
        return dig;
    }
    std::size_t below(std::size_t n) { return random_() % n; }
    double u() { return std::uniform_real_distribution<>()(random_); }

private:
    static constexpr double no_height = std::numeric_limits<double>::quiet_NaN();
    double height(double most) { return unit_ > 0 ? unit_ * std::floor(most * u() / unit_) : most * u(); }

    std::mt19937_64 random_;
    double unit_; ///< of the first heights; 0: any
    TerrainGrid grid_;
    std::vector<double> heights_; ///< NaN: a hole
};

} // namespace oncollide
