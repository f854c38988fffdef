#include <oncollide/narrowphase/boxes/terrain_tree.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/narrowphase/boxes/oriented_box.hpp>

namespace oncollide {

namespace {

constexpr std::uint32_t side = 8; ///< of a block of level 2, cells
constexpr float nothing = std::numeric_limits<float>::infinity();
constexpr float range_rounding = 0x1p-20f; ///< of stored heights, of half the terrain's own

} // namespace

TerrainTree::TerrainTree(const Terrain& terrain)
    : terrain_(terrain), centre_(terrain.bounds().centre()),
      radius_(0.5 * terrain.bounds().diagonal() * (1 + 0x1p-50) + 1e-150)
{
    const Eigen::Vector3d half = terrain.bounds().half_extent();
    all_ = {static_cast<float>(-half.z()), static_cast<float>(half.z())};
    std::uint32_t level = 0;
    for (Block all = blocks(0); all.x > wide(level) || all.y > high(level); all = blocks(level)) ++level;
    top_ = {0, 0, level, false};
    make_squares();
    for (std::uint32_t l = 3; l <= level; ++l) make_level(l);
}

void TerrainTree::make_squares()
{
    const Block all = blocks(2);
    squares_.resize(std::size_t(all.x) * all.y);
    const double zero = centre_.z() - terrain_.origin().z();
    // The rows of heights around a row of squares; beyond the last ones these are given again.
    const std::size_t width = std::size_t(all.x) * side + 1;
    std::vector<float> z(width * (side + 1));
    const auto read = [&](std::uint32_t row, float* out) {
        terrain_.read_row(std::min(row, terrain_.cells_y()), zero, out);
        std::fill(out + terrain_.columns(), out + width, out[terrain_.cells_x()]);
    };
    read(0, &z[side * width]);
    for (std::uint32_t y = 0; y < all.y; ++y) {
        std::copy_n(&z[side * width], width, z.data());
        for (std::uint32_t j = 1; j <= side; ++j) read(y * side + j, &z[j * width]);
        for (std::uint32_t x = 0; x < all.x; ++x)
            squares_[std::size_t(y) * all.x + x] = square_of(&z[std::size_t(x) * side], width);
    }
}

/// @param z  the heights at its corners: nine rows of nine, `width` apart
TerrainTree::Square TerrainTree::square_of(const float* z, std::size_t width) const
{
    Range of[8];
    bool holes = false;
    if (terrain_.holes())
        for (std::uint32_t j = 0; j <= side; ++j)
            for (std::uint32_t i = 0; i <= side; ++i) holes |= std::isnan(z[j * width + i]);
    for (std::uint32_t k = 0; k < 8; ++k) {
        const std::uint32_t x = k % 2 * 4, y = k / 2 * 2;
        Range& range = of[k] = {nothing, -nothing};
        const float *a = z + y * width + x, *b = a + width, *c = b + width;
        if (holes) {
            for (const float* low : {a, a + 1, a + 2, a + 3, b, b + 1, b + 2, b + 3}) {
                const float* const high = low + width;
                if (std::isnan(low[0] + low[1] + high[0] + high[1])) continue;
                range.low = std::min({range.low, low[0], low[1], high[0], high[1]});
                range.high = std::max({range.high, low[0], low[1], high[0], high[1]});
            }
            continue;
        }
        const auto less = [](float p, float q) { return p < q ? p : q; };
        const auto more = [](float p, float q) { return p < q ? q : p; };
        float low[4], high[4]; // of four columns, for the compiler to take together
        for (std::uint32_t i = 0; i < 4; ++i) {
            low[i] = less(less(a[i], b[i]), c[i]), high[i] = more(more(a[i], b[i]), c[i]);
            low[i] = less(low[i], less(less(a[i + 1], b[i + 1]), c[i + 1]));
            high[i] = more(high[i], more(more(a[i + 1], b[i + 1]), c[i + 1]));
        }
        range.low = less(less(low[0], low[1]), less(low[2], low[3]));
        range.high = more(more(high[0], high[1]), more(high[2], high[3]));
    }

    Range whole{nothing, -nothing};
    for (const Range& r : of) whole.low = std::min(whole.low, r.low), whole.high = std::max(whole.high, r.high);
    Square square{whole.low, whole.low <= whole.high ? (whole.high - whole.low) / 255 : 0, {}, {}};
    const float per_step = square.step > 0 ? 1 / square.step : 0;
    for (std::uint32_t k = 0; k < 8; ++k) {
        square.lows[k] = 255, square.highs[k] = 0;
        if (of[k].low > of[k].high) continue;
        // These steps round by less than range_rounding, and open() allows for that.
        square.lows[k] = static_cast<std::uint8_t>(std::max(0.0f, (of[k].low - square.low) * per_step));
        square.highs[k] = static_cast<std::uint8_t>(std::min(255.0f, (of[k].high - square.low) * per_step + 1));
    }
    return square;
}

void TerrainTree::make_level(std::uint32_t level)
{
    const Block all = blocks(level);
    std::vector<Range>& ranges = ranges_.emplace_back(std::size_t(all.x) * all.y);
    const std::uint32_t w = wide(level - 1), h = high(level - 1);
    const Block below = blocks(level - 1);
    for (std::uint32_t y = 0; y < all.y; ++y)
        for (std::uint32_t x = 0; x < all.x; ++x) {
            Range& sum = ranges[std::size_t(y) * all.x + x] = {nothing, -nothing};
            for (std::uint32_t j = y * h; j < std::min((y + 1) * h, below.y); ++j)
                for (std::uint32_t i = x * w; i < std::min((x + 1) * w, below.x); ++i) {
                    const Range part = range(level - 1, i, j);
                    sum.low = std::min(sum.low, part.low), sum.high = std::max(sum.high, part.high);
                }
        }
}

TerrainTree::Range TerrainTree::range(std::uint32_t level, std::uint32_t x, std::uint32_t y) const
{
    if (level > 2) return ranges_[level - 3][std::size_t(y) * blocks(level).x + x];
    if (level == 2) {
        const Square& s = squares_[std::size_t(y) * blocks(2).x + x];
        return {s.low, s.low < nothing ? s.low + 255 * s.step : -nothing};
    }
    const Square& s = squares_[std::size_t(y / 4) * blocks(2).x + x / 2];
    const std::uint32_t k = y % 4 * 2 + x % 2;
    if (s.lows[k] > s.highs[k]) return {nothing, -nothing};
    return {s.low + s.lows[k] * s.step, s.low + s.highs[k] * s.step};
}

void TerrainTree::cell_ranges(const Node& node, Range (&ranges)[8]) const
{
    const double zero = centre_.z() - terrain_.origin().z();
    terrain_.with_heights([&](auto height) {
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
    // A margin of half the box, so that what is left out is not merely apart.
    const double spacing = terrain_.spacing().maxCoeff();
    const double margin = 0.25 * (box.max - box.min).maxCoeff() + spacing, gap = margin - 0x1p-18 * spacing;
    std::uint32_t from[2], to[2]; // cells, both included
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

namespace {

/// @param centre, axes  the centre relative to `from` of the placement; the axes are columns
void put(OpenBoxes& boxes, unsigned k, const Eigen::Vector3f& centre, const Eigen::Matrix3f& axes,
         const Eigen::Vector3f& half, const BoxPlacement* placement)
{
    for (int i = 0; i < 3; ++i) {
        const float* r = placement && placement->turned ? placement->rotation + 3 * i : nullptr;
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
        const OrientedBox box = fit_box({&t, 1});
        put(boxes, k, box.centre.cast<float>(), box.axes.cast<float>(), box.half.cast<float>(), placement);
    }
    return {3, 3};
}

LaneMasks TerrainTree::open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    if (node.level == triangles) return open_cell(node, placement, boxes);
    const Eigen::Vector3d origin = this->origin(placement);
    const double zero = centre_.z() - origin.z(); // of ranges
    Range ranges[8];
    float centre[2][4], half[2][4]; // of the blocks' columns and rows
    unsigned lanes = 0;             // a bit for each block that is there
    const auto extent = [&](int axis, unsigned place, std::uint64_t from, std::uint64_t to) {
        const std::uint32_t last = axis ? terrain_.cells_y() : terrain_.cells_x();
        if (from >= last) return false;
        const auto at = [&](std::uint64_t line) {
            const auto l = static_cast<std::uint32_t>(std::min<std::uint64_t>(line, last));
            return (axis ? terrain_.y(l) : terrain_.x(l)) - origin[axis];
        };
        centre[axis][place] = static_cast<float>(0.5 * (at(from) + at(to)));
        half[axis][place] = static_cast<float>(0.5 * (at(to) - at(from)));
        return true;
    };
    const std::uint32_t level = node.level, w = node.whole ? 1 : wide(level);
    if (node.whole) {
        const bool all = level == root.level;
        const std::uint64_t x = all ? 0 : std::uint64_t(node.x) << log_width(level),
                            y = all ? 0 : std::uint64_t(node.y) << log_height(level);
        extent(0, 0, x, all ? ~0u : x + (std::uint64_t(wide(level)) << log_width(level)));
        extent(1, 0, y, all ? ~0u : y + (std::uint64_t(high(level)) << log_height(level)));
        ranges[0] = all_, lanes = 1;
    } else {
        const std::uint32_t h = high(level);
        unsigned columns = 0, rows = 0; // that are there
        for (unsigned i = 0; i < w; ++i)
            columns += extent(0, i, std::uint64_t(node.x + i) << log_width(level),
                              std::uint64_t(node.x + i + 1) << log_width(level));
        for (unsigned j = 0; j < h; ++j)
            rows += extent(1, j, std::uint64_t(node.y + j) << log_height(level),
                           std::uint64_t(node.y + j + 1) << log_height(level));
        if (level == 0) cell_ranges(node, ranges);
        for (unsigned j = 0; j < rows; ++j)
            for (unsigned i = 0; i < columns; ++i) {
                const unsigned k = j * w + i;
                if (level > 0) ranges[k] = range(level, node.x + i, node.y + j);
                lanes |= unsigned(ranges[k].low <= ranges[k].high) << k;
            }
    }

    const float* const r = placement && placement->turned ? placement->rotation : nullptr;
    float largest = 0;
    for (unsigned k = 0; k < 8; ++k) {
        if (!(lanes >> k & 1)) {
            put_nothing(boxes, k);
            continue;
        }
        const unsigned i = k % w, j = k / w;
        const float x = centre[0][i], y = centre[1][j];
        const auto z = static_cast<float>(zero + 0.5 * (double(ranges[k].low) + ranges[k].high));
        const float hx = half[0][i], hy = half[1][j], hz = 0.5f * (ranges[k].high - ranges[k].low);
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
    boxes.margin = box_margin * largest + range_rounding * all_.high;
    return {level == 0 && !node.whole ? lanes : 0, 0};
}

std::size_t TerrainTree::bytes() const
{
    std::size_t sum = squares_.capacity() * sizeof(Square);
    for (const auto& level : ranges_) sum += level.capacity() * sizeof(Range);
    return sum;
}

} // namespace oncollide
