#include <oncollide/narrowphase/obb/terrain_tree.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace oncollide {

/// A block of level 3 or above encloses the ranges of the blocks below it.
std::string TerrainTree::fault_of_level(std::uint32_t level) const
{
    const Block all = blocks(level), below = blocks(level - 1);
    if (bounds_.size() <= level - 3 || bounds_[level - 3].size() != std::size_t(all.x) * all.y)
        return fmt::format("level {} has a wrong number of blocks", level);
    for (std::uint32_t y = 0; y < all.y; ++y)
        for (std::uint32_t x = 0; x < all.x; ++x) {
            const auto& [range, slab] = bounds(level, x, y);
            const auto fault = [&](const char* what) {
                return fmt::format("level {}, block ({}, {}): {}", level, x, y, what);
            };
            if ((range.low <= range.high) != (slab.low <= slab.high)) return fault("its slab and its range differ");
            for (std::uint32_t j = y * high(level - 1); j < std::min((y + 1) * high(level - 1), below.y); ++j)
                for (std::uint32_t i = x * wide(level - 1); i < std::min((x + 1) * wide(level - 1), below.x); ++i) {
                    const Range part = bounds_below(level - 1, i, j).range;
                    if (part.low <= part.high && !(range.low <= part.low && part.high <= range.high))
                        return fault("does not enclose a block below it");
                }
        }
    return {};
}

/// The blocks and the slabs of every level enclose the corners of their cells.
std::string TerrainTree::fault_of_cells() const
{
    const double zero = centre_.z() - terrain_.origin().z();
    const float slack = 4 * range_rounding * farthest();
    std::vector<float> low(terrain_.columns()), high(terrain_.columns());
    for (std::uint32_t y = 0; y < terrain_.cells_y(); ++y) {
        terrain_.read_row(y, zero, low.data()), terrain_.read_row(y + 1, zero, high.data());
        for (std::uint32_t x = 0; x < terrain_.cells_x(); ++x) {
            const float corners[] = {low[x], low[x + 1], high[x], high[x + 1]};
            if (std::isnan(corners[0] + corners[1] + corners[2] + corners[3])) continue;
            for (std::uint32_t level = 1; level <= std::max(top_.level, 1u); ++level) {
                const std::uint32_t bx = x >> log_width(level), by = y >> log_height(level);
                const Range range = this->range(level, bx, by);
                const auto fault = [&](const char* what) {
                    return fmt::format("level {}, block ({}, {}): {} of cell ({}, {})", level, bx, by, what, x, y);
                };
                for (float z : corners)
                    if (!(z >= range.low - slack && z <= range.high + slack)) return fault("does not enclose a corner");
                if (level < 2) continue;
                const Slab slab = bounds_below(level, bx, by).slab;
                const Eigen::Vector2f half = half_of_block(level), cell = terrain_.spacing().cast<float>();
                for (std::uint32_t k = 0; k < 4; ++k) {
                    const float dx = cell.x() * float(x + k % 2 - (bx << log_width(level))) - half.x(),
                                dy = cell.y() * float(y + k / 2 - (by << log_height(level))) - half.y();
                    const float up = slab.slope_x * dx + slab.slope_y * dy,
                                doubt =
                                    slack + 16 * range_rounding *
                                                (std::abs(slab.slope_x) * half.x() + std::abs(slab.slope_y) * half.y());
                    if (!(corners[k] - up >= slab.low - doubt && corners[k] - up <= slab.high + doubt))
                        return fault("its slab does not enclose a corner");
                }
            }
        }
    }
    return {};
}

std::string TerrainTree::validate() const
{
    const Block all = blocks(top_.level);
    if (all.x > wide(top_.level) || all.y > high(top_.level)) return "the top node does not hold all cells";
    const bool in_memory = !TerrainAccess::chunks(terrain_);
    for (std::uint32_t level = in_memory ? 3 : part_level + 1; level <= top_.level; ++level)
        if (std::string fault = fault_of_level(level); !fault.empty()) return fault;
    return in_memory ? fault_of_cells() : "";
}

} // namespace oncollide
