#include <oncollide/narrowphase/obb/terrain_tree.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/narrowphase/obb/fits/box_fit.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>
#include <oncollide/narrowphase/obb/solid_gap_kernel.hpp>

namespace oncollide {

TerrainTree::TerrainTree(const Terrain& terrain) : terrain_(terrain), centre_(terrain.bounds().centre())
{
    set_bounds();
    std::uint32_t level = 0;
    for (Block all = blocks(0); all.x > wide(level) || all.y > high(level); all = blocks(level)) ++level;
    top_ = {0, 0, level, false};
    if (!TerrainAccess::chunks(terrain)) {
        make_squares();
        for (std::uint32_t l = 3; l <= level; ++l) make_level(l);
        return;
    }
    const CookedTerrain& cooked = *cooked_chunks(terrain)->cooked();
    parts_across_ = cooked.blocks_across();
    parts_ = std::vector<std::atomic<Part*>>(cooked.ranges().size());
    bounds_.resize(2); // level 3 is not stored
    for (const CookedRange& r : cooked.ranges())
        bounds_[1].push_back({{r.low, r.high}, {{r.slab_low, r.slab_high}, r.slope_x, r.slope_y}});
    for (std::uint32_t l = part_level + 1; l <= level; ++l) make_level(l);
}

/// Sets the bounds of all cells. The zero level of the ranges stays, and so may be off their middle.
void TerrainTree::set_bounds()
{
    const Aabb& bounds = terrain_.bounds();
    const double half = bounds.half_extent().z(), off = bounds.centre().z() - centre_.z();
    centre_.head<2>() = bounds.centre().head<2>();
    radius_ = (0.5 * bounds.diagonal() + std::abs(off)) * (1 + 0x1p-50) + 1e-150;
    all_ = {static_cast<float>(off - half), static_cast<float>(off + half)};
}

TerrainTree::~TerrainTree()
{
    for (std::atomic<Part*>& part : parts_) delete part.load();
    if (const CookedTerrainChunks* chunks = cooked_chunks(terrain_)) chunks->budget().give(held_);
}

void TerrainTree::add_held(std::vector<Held>& to) const
{
    const CookedTerrainChunks& chunks = *cooked_chunks(terrain_);
    for (std::uint32_t chunk = 0; chunk < chunks.cooked()->chunks(); ++chunk)
        if (chunks.there(chunk)) to.push_back({chunks.needed(chunk), chunk});
}

/// Drops the heights of a chunk, and the parts made of them and of neighbouring heights.
void TerrainTree::drop(std::uint32_t chunk)
{
    CookedTerrainChunks& chunks = *cooked_chunks(terrain_);
    const std::uint32_t x = chunk % chunks.cooked()->across(), y = chunk / chunks.cooked()->across();
    const std::size_t number = std::size_t(y) * parts_across_ + x;
    if (x < parts_across_ && number < parts_.size())
        if (const std::unique_ptr<Part> gone(parts_[number].exchange(nullptr)); gone)
            chunks.budget().give(sizeof(Part)), held_ -= sizeof(Part);
    chunks.drop(chunk);
}

TerrainTree::Range TerrainTree::range(std::uint32_t level, std::uint32_t x, std::uint32_t y) const
{
    if (level > 2) return bounds(level, x, y).range;
    if (level == 2) return range_of(square(x, y));
    const Square& s = square(x / 2, y / 4);
    const std::uint32_t k = y % 4 * 2 + x % 2;
    if (s.lows[k] > s.highs[k]) return {nothing, -nothing};
    return {s.low + s.lows[k] * s.step, s.low + s.highs[k] * s.step};
}

void TerrainTree::cell_ranges(const Node& node, Range (&ranges)[8]) const
{
    const double zero = centre_.z() - terrain_.origin().z();
    TerrainAccess::with_heights(terrain_, [&](auto height) {
        float z[3][5];
        for (std::uint32_t j = 0; j < 3; ++j)
            for (std::uint32_t i = 0; i < 5; ++i) {
                const bool beyond = node.x + i > terrain_.cells_x() || node.y + j > terrain_.cells_y();
                z[j][i] = beyond ? std::numeric_limits<float>::quiet_NaN()
                                 : static_cast<float>(height(node.x + i, node.y + j) - zero);
            }
        for (std::uint32_t k = 0; k < 8; ++k) {
            const std::uint32_t i = k % 4, j = k / 4;
            const float a = z[j][i], b = z[j][i + 1], c = z[j + 1][i], d = z[j + 1][i + 1];
            const float sum = a + b + c + d;
            ranges[k] = sum == sum ? Range{std::min({a, b, c, d}), std::max({a, b, c, d})} : Range{nothing, -nothing};
        }
    });
}

TerrainTree::Entry TerrainTree::entry(const Aabb& box) const
{
    // A margin of half the box, so that omitted cells have a useful distance.
    const double spacing = terrain_.spacing().maxCoeff();
    const double margin = 0.25 * (box.max - box.min).maxCoeff() + spacing, gap = margin - 0x1p-18 * spacing;
    std::uint32_t from[2], to[2]; // first and last cells, both included
    for (int i = 0; i < 2; ++i) {
        const double last = (i ? terrain_.cells_y() : terrain_.cells_x()) - 1;
        const double low = std::floor((box.min[i] - margin - terrain_.origin()[i]) / terrain_.spacing()[i]);
        const double high = std::floor((box.max[i] + margin - terrain_.origin()[i]) / terrain_.spacing()[i]);
        if (!(low <= last && high >= 0)) return {std::nullopt, gap};
        from[i] = static_cast<std::uint32_t>(std::max(low, 0.0));
        to[i] = static_cast<std::uint32_t>(std::min(high, last));
    }
    if (box.min.z() - margin > terrain_.bounds().max.z() || box.max.z() + margin < terrain_.bounds().min.z())
        return {std::nullopt, gap};
    for (std::uint32_t level = 0; level < top_.level; ++level) {
        const std::uint32_t x = from[0] >> log_width(level), y = from[1] >> log_height(level);
        if ((to[0] >> log_width(level)) - x < wide(level) && (to[1] >> log_height(level)) - y < high(level))
            return {Node{x, y, level, true}, gap};
    }
    return {Node{0, 0, top_.level, true}, gap};
}

TerrainTree::Node TerrainTree::node_around(const Aabb& box) const
{
    const auto cell = [&](double at, int axis) {
        const double last = (axis ? terrain_.cells_y() : terrain_.cells_x()) - 1;
        const double number = (at - terrain_.origin()[axis]) / terrain_.spacing()[axis];
        return static_cast<std::uint32_t>(std::clamp(number, 0.0, last));
    };
    const Block from{cell(box.min.x(), 0), cell(box.min.y(), 1)}, to{cell(box.max.x(), 0), cell(box.max.y(), 1)};
    std::uint32_t level = 0;
    while (level < top_.level && ((from.x ^ to.x) >> log_width(level + 1) || (from.y ^ to.y) >> log_height(level + 1)))
        ++level;
    if (level >= top_.level) return top_;
    return {(from.x >> log_width(level + 1)) * wide(level), (from.y >> log_height(level + 1)) * high(level), level,
            false};
}

namespace {

/// @param centre, axes  the centre relative to the placement's `from`; the axes are columns
void put(OpenBoxes& boxes, unsigned k, const Eigen::Vector3f& centre, const Eigen::Matrix3f& axes,
         const Eigen::Vector3f& half, const BoxPlacement* placement)
{
    for (int i = 0; i < 3; ++i) {
        const float* r = placement && placement->rotated ? placement->rotation + 3 * i : nullptr;
        boxes.c[i][k] =
            r ? r[0] * centre[0] + r[1] * centre[1] + r[2] * centre[2] + placement->translation[i] : centre[i];
        for (int axis = 0; axis < 3; ++axis)
            boxes.axis[axis][i][k] =
                r ? r[0] * axes(0, axis) + r[1] * axes(1, axis) + r[2] * axes(2, axis) : axes(i, axis);
        boxes.h[i][k] = half[i];
    }
    boxes.size[k] = half.squaredNorm();
    boxes.margin = std::max(boxes.margin, box_margin * half.sum());
}

void put_nothing(OpenBoxes& boxes, unsigned k)
{
    for (int i = 0; i < 3; ++i) boxes.c[i][k] = 1e30f, boxes.h[i][k] = 0;
    boxes.size[k] = 0;
}

} // namespace

Eigen::Vector3d TerrainTree::origin(const BoxPlacement* placement) const
{
    return placement ? centre_ + Eigen::Map<const Eigen::Vector3f>(placement->from).cast<double>() : centre_;
}

LaneMasks TerrainTree::open_cell(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    boxes.margin = 0;
    const Eigen::Vector3d origin = this->origin(placement);
    for (unsigned k = 0; k < 8; ++k) put_nothing(boxes, k);
    for (auto& axis : boxes.axis)
        for (auto& component : axis) std::fill_n(component, 8, 0.0f);
    for (unsigned k = 0; k < 2; ++k) {
        TrianglePoints t = points(primitives(node, k).numbers[0]);
        for (Eigen::Vector3d& p : t) p -= origin;
        const Eigen::Matrix3d axes = axes_of_triangle(t);
        Aabb along;
        for (const Eigen::Vector3d& p : t) along.add(axes.transpose() * p);
        const Eigen::Vector3d centre = axes * along.centre();
        put(boxes, k, centre.cast<float>(), axes.cast<float>(), along.half_extent().cast<float>(), placement);
    }
    return {3, 3};
}

/// The blocks of a node: the extents of its columns and rows of blocks, and the heights of each block that exists.
struct TerrainTree::OpenedBlocks {
    Range ranges[8];
    float centre[2][4], half[2][4]; ///< by column and by row of the blocks
    std::uint32_t wide = 1;
    unsigned lanes = 0; ///< one bit for each block that exists
};

void TerrainTree::find_blocks(const Node& node, const Eigen::Vector3d& origin, OpenedBlocks& found) const
{
    const auto extent = [&](int axis, unsigned place, std::uint64_t from, std::uint64_t to) {
        const std::uint32_t last = axis ? terrain_.cells_y() : terrain_.cells_x();
        if (from >= last) return false;
        const auto at = [&](std::uint64_t line) {
            const auto l = static_cast<std::uint32_t>(std::min<std::uint64_t>(line, last));
            return (axis ? TerrainAccess::y(terrain_, l) : TerrainAccess::x(terrain_, l)) - origin[axis];
        };
        found.centre[axis][place] = static_cast<float>(0.5 * (at(from) + at(to)));
        found.half[axis][place] = static_cast<float>(0.5 * (at(to) - at(from)));
        return true;
    };
    const std::uint32_t level = node.level;
    if (node.whole) {
        const bool all = level == root.level;
        const std::uint64_t x = all ? 0 : std::uint64_t(node.x) << log_width(level),
                            y = all ? 0 : std::uint64_t(node.y) << log_height(level);
        extent(0, 0, x, all ? ~0u : x + (std::uint64_t(wide(level)) << log_width(level)));
        extent(1, 0, y, all ? ~0u : y + (std::uint64_t(high(level)) << log_height(level)));
        found.ranges[0] = all_, found.lanes = 1;
        return;
    }
    const std::uint32_t w = found.wide = wide(level), h = high(level);
    unsigned columns = 0, rows = 0; // existing columns and rows
    for (unsigned i = 0; i < w; ++i)
        columns += extent(0, i, std::uint64_t(node.x + i) << log_width(level),
                          std::uint64_t(node.x + i + 1) << log_width(level));
    for (unsigned j = 0; j < h; ++j)
        rows += extent(1, j, std::uint64_t(node.y + j) << log_height(level),
                       std::uint64_t(node.y + j + 1) << log_height(level));
    if (level == 0) cell_ranges(node, found.ranges);
    for (unsigned j = 0; j < rows; ++j)
        for (unsigned i = 0; i < columns; ++i) {
            const unsigned k = j * w + i;
            if (level > 0) found.ranges[k] = range(level, node.x + i, node.y + j);
            found.lanes |= unsigned(found.ranges[k].low <= found.ranges[k].high) << k;
        }
}

LaneMasks TerrainTree::open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    if (node.level == triangles) return open_cell(node, placement, boxes);
    const Eigen::Vector3d origin = this->origin(placement);
    OpenedBlocks blocks;
    find_blocks(node, origin, blocks);
    const double zero = centre_.z() - origin.z(); // zero level of the ranges
    const float* const r = placement && placement->rotated ? placement->rotation : nullptr;
    float largest = 0;
    for (unsigned k = 0; k < 8; ++k) {
        if (!(blocks.lanes >> k & 1)) {
            put_nothing(boxes, k);
            continue;
        }
        const unsigned i = k % blocks.wide, j = k / blocks.wide;
        const auto [low, high] = blocks.ranges[k];
        const float x = blocks.centre[0][i], y = blocks.centre[1][j];
        const auto z = static_cast<float>(zero + 0.5 * (double(low) + high));
        const float hx = blocks.half[0][i], hy = blocks.half[1][j], hz = 0.5f * (high - low);
        boxes.h[0][k] = hx, boxes.h[1][k] = hy, boxes.h[2][k] = hz;
        boxes.size[k] = hx * hx + hy * hy + hz * hz;
        largest = std::max(largest, hx + hy + hz);
        if (!r) {
            boxes.c[0][k] = x, boxes.c[1][k] = y, boxes.c[2][k] = z;
            continue;
        }
        for (int row = 0; row < 3; ++row)
            boxes.c[row][k] = r[3 * row] * x + r[3 * row + 1] * y + r[3 * row + 2] * z + placement->translation[row];
    }
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 3; ++i) std::fill_n(boxes.axis[axis][i], 8, r ? r[3 * i + axis] : float(axis == i));
    boxes.margin = box_margin * largest + range_rounding * farthest();
    return {node.level == 0 && !node.whole ? blocks.lanes : 0, 0};
}

void TerrainTree::open_cells(const Node& node, const Eigen::Vector3d& from, TerrainCells& cells) const
{
    const double zero = from.z() - terrain_.origin().z();
    std::uint32_t columns[5], rows[3];
    for (std::uint32_t i = 0; i < 5; ++i) {
        columns[i] = std::min(node.x + i, terrain_.cells_x());
        cells.x[i] = static_cast<float>(TerrainAccess::x(terrain_, columns[i]) - from.x());
    }
    for (std::uint32_t j = 0; j < 3; ++j) {
        rows[j] = std::min(node.y + j, terrain_.cells_y());
        cells.y[j] = static_cast<float>(TerrainAccess::y(terrain_, rows[j]) - from.y());
    }
    TerrainAccess::with_heights(terrain_, [&](auto height) {
        for (std::uint32_t j = 0; j < 3; ++j)
            for (std::uint32_t i = 0; i < 5; ++i)
                cells.z[j][i] = static_cast<float>(height(columns[i], rows[j]) - zero);
    });
    cells.falling = TerrainAccess::diagonal(terrain_, 0, 0) == CellDiagonal::falling ? 0xff : 0;
    if (terrain_.mixed_diagonals()) {
        cells.falling = 0;
        for (std::uint32_t k = 0; k < 8; ++k)
            if (columns[k % 4] < terrain_.cells_x() && rows[k / 4] < terrain_.cells_y())
                cells.falling |=
                    unsigned(TerrainAccess::diagonal(terrain_, columns[k % 4], rows[k / 4]) == CellDiagonal::falling)
                    << k;
    }
    cells.margin = box_margin * static_cast<float>(terrain_.spacing().sum());
}

void TerrainTree::open_blocks(const Node& node, const Eigen::Vector3d& from, TerrainBlocks& blocks) const
{
    const std::uint32_t level = node.level, w = wide(level), h = high(level);
    const Block all = this->blocks(level);
    const auto lines = [](float* out, std::uint32_t count, double first, double step, double last) {
        for (std::uint32_t i = 0; i <= count; ++i) out[i] = static_cast<float>(std::min(first + i * step, last));
    };
    const double across = terrain_.spacing().x() * cells_wide(level),
                 along = terrain_.spacing().y() * cells_high(level);
    const Eigen::Vector3d& origin = terrain_.origin();
    lines(blocks.x, w, origin.x() + node.x * across - from.x(), across, terrain_.x(terrain_.cells_x()) - from.x());
    lines(blocks.y, h, origin.y() + node.y * along - from.y(), along, terrain_.y(terrain_.cells_y()) - from.y());
    const Eigen::Vector2f half = half_of_block(level);
    blocks.half_x = half.x(), blocks.half_y = half.y();
    blocks.wide = w == 4, blocks.one_slope = level == 1;
    blocks.zero = static_cast<float>(centre_.z() - from.z());
    blocks.margin = box_margin * 2 * (half.x() + half.y()) + range_rounding * farthest();
    const auto put = [&](unsigned k, const Range& range, const Slab& slab) {
        blocks.low[k] = range.low, blocks.high[k] = range.high;
        blocks.slab_low[k] = slab.low, blocks.slab_high[k] = slab.high;
        blocks.slope_x[k] = slab.slope_x, blocks.slope_y[k] = slab.slope_y;
    };
    if (level == 1) { // the eight blocks of one square
        const Square& s = square(node.x / 2, node.y / 4);
        const auto put_all = [](float* out, float low, float step, const std::uint8_t* steps) {
            for (unsigned k = 0; k < 8; ++k) out[k] = low + float(steps[k]) * step;
        };
        put_all(blocks.low, s.low, s.step, s.lows), put_all(blocks.high, s.low, s.step, s.highs);
        put_all(blocks.slab_low, s.slab_low, s.slab_step, s.slab_lows);
        put_all(blocks.slab_high, s.slab_low, s.slab_step, s.slab_highs);
        for (unsigned k = 0; k < 8; ++k) blocks.high[k] = s.lows[k] > s.highs[k] ? -nothing : blocks.high[k];
        std::fill_n(blocks.slope_x, 8, s.slope_x), std::fill_n(blocks.slope_y, 8, s.slope_y);
        return;
    }
    // Only chunks of a cooked terrain are read on demand.
    const bool in_memory = !TerrainAccess::chunks(terrain_);
    const Square* const squares = level == 2 && in_memory ? squares_.data() : nullptr;
    const Bounds* const stored = level > 2 && (in_memory || level >= part_level) ? bounds_[level - 3].data() : nullptr;
    const std::uint32_t columns = std::min(w, all.x - node.x), rows = std::min(h, all.y - node.y);
    for (unsigned k = 0; columns * rows < 8 && k < 8; ++k) put(k, {nothing, -nothing}, {});
    for (std::uint32_t j = 0; j < rows; ++j)
        for (std::uint32_t i = 0; i < columns; ++i) {
            const std::uint32_t x = node.x + i, y = node.y + j;
            const std::size_t number = std::size_t(y) * all.x + x;
            if (level == 2) {
                const Square& block = squares ? squares[number] : square(x, y);
                put(j * w + i, range_of(block), slab_of(block));
            } else {
                const Bounds& block = stored ? stored[number] : bounds(level, x, y);
                put(j * w + i, block.range, block.slab);
            }
        }
}

std::size_t TerrainTree::bytes() const
{
    std::size_t sum = squares_.capacity() * sizeof(Square);
    for (const auto& level : bounds_) sum += level.capacity() * sizeof(Bounds);
    if (TerrainAccess::chunks(terrain_))
        sum += parts_.size() * sizeof(parts_[0]) + held_ + TerrainAccess::chunks(terrain_)->bytes();
    return sum;
}

} // namespace oncollide
