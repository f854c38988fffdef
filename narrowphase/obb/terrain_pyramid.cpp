// The bounds that a terrain tree stores: squares of eight by eight cells, and the levels above them.
#include <oncollide/narrowphase/obb/terrain_tree.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace oncollide {

namespace {

constexpr std::uint32_t square_side = 8; ///< side of a block of level 2, in cells

} // namespace

/// Makes the squares of a block and the level above them, from its heights. Squares of other blocks begin where it
/// ends.
void TerrainTree::fill(Part& part, std::uint32_t x, std::uint32_t y) const
{
    constexpr std::uint32_t cells = TerrainChunks::side, width = cells + 1;
    const double zero = centre_.z() - terrain_.origin().z();
    std::vector<float> z(std::size_t(width) * width);
    const std::uint32_t begin = x * cells, end = std::min(begin + width, terrain_.columns());
    double heights[width];
    for (std::uint32_t j = 0; j < width; ++j) {
        TerrainAccess::chunks(terrain_)->read_row(std::min(y * cells + j, terrain_.cells_y()), begin, end, heights);
        std::fill(heights + (end - begin), heights + width, heights[end - begin - 1]); // beyond the last column
        for (std::uint32_t i = 0; i < width; ++i) z[j * width + i] = static_cast<float>(heights[i] - zero);
    }
    const auto each = [&](std::uint32_t level, std::uint32_t across, std::uint32_t down, auto visit) {
        const Block all = blocks(level);
        for (std::uint32_t j = 0; j < std::min(down, all.y - y * down); ++j)
            for (std::uint32_t i = 0; i < std::min(across, all.x - x * across); ++i) visit(j * across + i, i, j);
    };
    each(2, 8, 8, [&](std::uint32_t k, std::uint32_t i, std::uint32_t j) {
        part.squares[k] = square_of(&z[std::size_t(j * square_side) * width + i * square_side], width);
    });
    each(3, 2, 4, [&](std::uint32_t k, std::uint32_t i, std::uint32_t j) {
        part.bounds[k] = bounds_around(3, 2 * x + i, 4 * y + j, [&](std::uint32_t of_x, std::uint32_t of_y) {
            const Square& square = part.squares[of_y % 8 * 8 + of_x % 8];
            return Bounds{range_of(square), slab_of(square)};
        });
    });
}

const TerrainTree::Part& TerrainTree::make_part(std::uint32_t x, std::uint32_t y) const
{
    const std::lock_guard lock(making_);
    const std::size_t number = std::size_t(y) * parts_across_ + x;
    if (const Part* const there = parts_[number].load(std::memory_order_acquire)) return *there;
    CookedTerrainChunks& chunks = *cooked_chunks(terrain_);
    chunks.budget().take(sizeof(Part), chunks.cooked()->file().name());
    try {
        auto made = std::make_unique<Part>();
        fill(*made, x, y);
        const Bounds of = bounds_around(part_level, x, y, [&](std::uint32_t of_x, std::uint32_t of_y) {
            return made->bounds[of_y % 4 * 2 + of_x % 2];
        });
        if (std::memcmp(&of, &bounds_[1][number], sizeof of) != 0)
            chunks.cooked()->refuse_chunk(std::size_t(y) * chunks.cooked()->across() + x,
                                          "its heights are not within the bounds that the top says");
        parts_[number].store(made.release(), std::memory_order_release);
    } catch (...) {
        chunks.budget().give(sizeof(Part));
        throw;
    }
    held_ += sizeof(Part);
    return *parts_[number].load(std::memory_order_relaxed);
}

CookedRange TerrainTree::range_of_chunk(std::uint32_t x, std::uint32_t y) const
{
    const Bounds of = bounds_around(part_level, x, y, [&](std::uint32_t of_x, std::uint32_t of_y) {
        const auto square_bounds = [&](std::uint32_t sx, std::uint32_t sy) { return bounds_below(2, sx, sy); };
        return bounds_around(3, of_x, of_y, square_bounds);
    });
    return {of.range.low, of.range.high, of.slab.low, of.slab.high, of.slab.slope_x, of.slab.slope_y};
}

void TerrainTree::make_squares()
{
    const Block all = blocks(2);
    squares_.resize(std::size_t(all.x) * all.y);
    const double zero = centre_.z() - terrain_.origin().z();
    // The rows of heights around a row of squares; the last row and column are repeated beyond the end.
    const std::size_t width = std::size_t(all.x) * square_side + 1;
    std::vector<float> z(width * (square_side + 1));
    const auto read = [&](std::uint32_t row, float* out) {
        terrain_.read_row(std::min(row, terrain_.cells_y()), zero, out);
        std::fill(out + terrain_.columns(), out + width, out[terrain_.cells_x()]);
    };
    read(0, &z[square_side * width]);
    for (std::uint32_t y = 0; y < all.y; ++y) {
        std::copy_n(&z[square_side * width], width, z.data());
        for (std::uint32_t j = 1; j <= square_side; ++j) read(y * square_side + j, &z[j * width]);
        for (std::uint32_t x = 0; x < all.x; ++x)
            squares_[std::size_t(y) * all.x + x] = square_of(&z[std::size_t(x) * square_side], width);
    }
}

/// The blocks over these cells.
TerrainTree::BlockRange TerrainTree::blocks_over(std::uint32_t level, const BlockRange& cells)
{
    const auto over = [&](const Block& cell) { return Block{cell.x >> log_width(level), cell.y >> log_height(level)}; };
    return {over(cells.first), over(cells.last)};
}

/// As make_squares(), for some of them.
void TerrainTree::find_squares(const BlockRange& of)
{
    constexpr std::uint32_t width = square_side + 1;
    const double zero = centre_.z() - terrain_.origin().z();
    const std::uint32_t across = blocks(2).x;
    TerrainAccess::with_heights(terrain_, [&](auto height) {
        float z[width * width];
        for (std::uint32_t y = of.first.y; y <= of.last.y; ++y)
            for (std::uint32_t x = of.first.x; x <= of.last.x; ++x) {
                for (std::uint32_t j = 0; j < width; ++j)
                    for (std::uint32_t i = 0; i < width; ++i)
                        z[j * width + i] =
                            static_cast<float>(height(std::min(x * square_side + i, terrain_.cells_x()),
                                                      std::min(y * square_side + j, terrain_.cells_y())) -
                                               zero);
                squares_[std::size_t(y) * across + x] = square_of(z, width);
            }
    });
}

void TerrainTree::change(const TerrainRectangle& where)
{
    ONCOLLIDE_ASSERT(!TerrainAccess::chunks(terrain_) && where.columns > 0 && where.rows > 0);
    const Block last{terrain_.cells_x() - 1, terrain_.cells_y() - 1};
    BlockRange cells{
        {where.column - (where.column > 0), where.row - (where.row > 0)},
        {std::min(where.column + where.columns - 1, last.x), std::min(where.row + where.rows - 1, last.y)}};
    set_bounds();
    // Floats round ranges that are far from their zero level more than necessary.
    constexpr float most_off = 4;
    const BlockRange of = blocks_over(2, cells);
    const std::uint64_t changed = std::uint64_t(of.last.x - of.first.x + 1) * (of.last.y - of.first.y + 1);
    if (2 * changed >= squares_.size() || farthest() > most_off * 0.5f * (all_.high - all_.low)) {
        centre_ = terrain_.bounds().centre(), cells = {{0, 0}, last};
        set_bounds();
    }
    find_squares(blocks_over(2, cells));
    for (std::uint32_t level = 3; level <= top_.level; ++level) find_level(level, blocks_over(level, cells));
}

/// The height ranges of the eight blocks of a square.
void TerrainTree::ranges_of_blocks(const float* z, std::size_t width, bool holes, Range (&of)[8])
{
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
        float low[4], high[4]; // per column, so that the compiler can vectorise
        for (std::uint32_t i = 0; i < 4; ++i) {
            low[i] = less(less(a[i], b[i]), c[i]), high[i] = more(more(a[i], b[i]), c[i]);
            low[i] = less(low[i], less(less(a[i + 1], b[i + 1]), c[i + 1]));
            high[i] = more(high[i], more(more(a[i + 1], b[i + 1]), c[i + 1]));
        }
        range.low = less(less(low[0], low[1]), less(low[2], low[3]));
        range.high = more(more(high[0], high[1]), more(high[2], high[3]));
    }
}

/// @param z  the heights at the square's corners: nine rows of nine, `width` apart
TerrainTree::Square TerrainTree::square_of(const float* z, std::size_t width) const
{
    Range of[8];
    bool holes = false;
    if (terrain_.holes())
        for (std::uint32_t j = 0; j <= square_side; ++j)
            for (std::uint32_t i = 0; i <= square_side; ++i) holes |= std::isnan(z[j * width + i]);
    ranges_of_blocks(z, width, holes, of);
    Range whole{nothing, -nothing};
    for (const Range& r : of) whole.low = std::min(whole.low, r.low), whole.high = std::max(whole.high, r.high);
    Square square{};
    square.low = whole.low, square.step = whole.low <= whole.high ? (whole.high - whole.low) / 255 : 0;
    const float per_step = square.step > 0 ? 1 / square.step : 0;
    for (std::uint32_t k = 0; k < 8; ++k) {
        square.lows[k] = 255, square.highs[k] = 0;
        if (of[k].low > of[k].high) continue;
        // These steps round by less than range_rounding, which open() allows for.
        square.lows[k] = static_cast<std::uint8_t>(std::max(0.0f, (of[k].low - square.low) * per_step));
        square.highs[k] = static_cast<std::uint8_t>(std::min(255.0f, (of[k].high - square.low) * per_step + 1));
    }
    add_slabs(square, z, width, holes);
    return square;
}

/// Slabs around the plane that fits the heights best; a horizontal plane if there are holes.
void TerrainTree::add_slabs(Square& square, const float* z, std::size_t width, bool holes) const
{
    constexpr std::uint32_t line = square_side + 1, middle = square_side / 2;
    float a = 0, b = 0; // slopes, heights per cell
    if (!holes) {
        float columns[line] = {}, rows[line] = {};
        for (std::uint32_t j = 0; j < line; ++j)
            for (std::uint32_t i = 0; i < line; ++i) columns[i] += z[j * width + i], rows[j] += z[j * width + i];
        constexpr float squares = line * 60; // sum of the squared distances of the 81 points from the middle column
        for (std::uint32_t i = 0; i < line; ++i) {
            a += (float(i) - middle) * columns[i] / squares;
            b += (float(i) - middle) * rows[i] / squares;
        }
    }
    float above[line * line];
    for (std::uint32_t j = 0; j < line; ++j)
        for (std::uint32_t i = 0; i < line; ++i)
            above[j * line + i] = z[j * width + i] - (a * (float(i) - middle) + b * (float(j) - middle));
    Range of[8], whole{nothing, -nothing};
    ranges_of_blocks(above, line, holes, of);
    for (const Range& r : of) whole.low = std::min(whole.low, r.low), whole.high = std::max(whole.high, r.high);
    square.slope_x = a / static_cast<float>(terrain_.spacing().x());
    square.slope_y = b / static_cast<float>(terrain_.spacing().y());
    square.slab_low = whole.low, square.slab_step = whole.low <= whole.high ? (whole.high - whole.low) / 255 : 0;
    const float per_step = square.slab_step > 0 ? 1 / square.slab_step : 0;
    for (std::uint32_t k = 0; k < 8; ++k) {
        if (of[k].low > of[k].high) continue;
        square.slab_lows[k] = static_cast<std::uint8_t>(std::max(0.0f, (of[k].low - whole.low) * per_step));
        square.slab_highs[k] = static_cast<std::uint8_t>(std::min(255.0f, (of[k].high - whole.low) * per_step + 1));
    }
}

void TerrainTree::make_level(std::uint32_t level)
{
    const Block all = blocks(level);
    bounds_.emplace_back(std::size_t(all.x) * all.y);
    find_level(level, {{0, 0}, {all.x - 1, all.y - 1}});
}

/// Finds the bounds of blocks of level 3 or above from the level below.
void TerrainTree::find_level(std::uint32_t level, const BlockRange& of)
{
    const std::uint32_t across = blocks(level).x;
    for (std::uint32_t y = of.first.y; y <= of.last.y; ++y)
        for (std::uint32_t x = of.first.x; x <= of.last.x; ++x)
            bounds_[level - 3][std::size_t(y) * across + x] =
                bounds_around(level, x, y, [&](std::uint32_t of_x, std::uint32_t of_y) {
                    return bounds_below(level - 1, of_x, of_y);
                });
}

/// The level is 2 or above.
TerrainTree::Bounds TerrainTree::bounds_below(std::uint32_t level, std::uint32_t x, std::uint32_t y) const
{
    if (level > 2) return bounds(level, x, y);
    const Square& of = square(x, y);
    return {range_of(of), slab_of(of)};
}

template <class Below>
TerrainTree::Bounds TerrainTree::bounds_around(std::uint32_t level, std::uint32_t x, std::uint32_t y,
                                               Below bounds_of) const
{
    const std::uint32_t w = wide(level - 1), h = high(level - 1);
    const Block below = blocks(level - 1);
    Bounds sum;
    sum.range = {nothing, -nothing};
    for (std::uint32_t j = y * h; j < std::min((y + 1) * h, below.y); ++j)
        for (std::uint32_t i = x * w; i < std::min((x + 1) * w, below.x); ++i) {
            const Range part = bounds_of(i, j).range;
            sum.range.low = std::min(sum.range.low, part.low);
            sum.range.high = std::max(sum.range.high, part.high);
        }
    sum.slab = slab_around(level, x, y, bounds_of);
    return sum;
}

/// The slab around the plane that fits the middles of the blocks below.
template <class Below>
TerrainTree::Slab TerrainTree::slab_around(std::uint32_t level, std::uint32_t x, std::uint32_t y, Below bounds_of) const
{
    const Eigen::Vector2f half = half_of_block(level - 1);
    const std::uint32_t w = wide(level - 1), h = high(level - 1);
    const Block below = blocks(level - 1);
    const auto each = [&](auto visit) {
        for (std::uint32_t j = 0; j < std::min(h, below.y - y * h); ++j)
            for (std::uint32_t i = 0; i < std::min(w, below.x - x * w); ++i)
                if (const Slab part = bounds_of(x * w + i, y * h + j).slab; part.low <= part.high)
                    visit(part, half.x() * (2 * float(i) + 1 - float(w)), half.y() * (2 * float(j) + 1 - float(h)));
    };
    Eigen::Vector3f sums = Eigen::Vector3f::Zero();
    float parts = 0;
    each([&](const Slab& part, float dx, float dy) {
        sums += Eigen::Vector3f(dx, dy, 0.5f * part.low + 0.5f * part.high), ++parts;
    });
    Slab slab{{nothing, -nothing}, 0, 0};
    if (parts == 0) return slab;
    const Eigen::Vector3f mean = sums / parts;
    Eigen::Matrix2f squares = Eigen::Matrix2f::Zero();
    Eigen::Vector2f rises = Eigen::Vector2f::Zero();
    each([&](const Slab& part, float dx, float dy) {
        const Eigen::Vector2f d(dx - mean.x(), dy - mean.y());
        squares += d * d.transpose(), rises += (0.5f * part.low + 0.5f * part.high - mean.z()) * d;
    });
    // Blocks in one row or column leave the slope across it undetermined.
    const Eigen::Vector2f slope = squares.determinant() > 0.01f * squares.diagonal().prod()
                                      ? Eigen::Vector2f(squares.inverse() * rises)
                                      : Eigen::Vector2f(0, 0);
    if (slope.allFinite()) slab.slope_x = slope.x(), slab.slope_y = slope.y();
    each([&](const Slab& part, float dx, float dy) {
        const float across = half.x() * std::abs(part.slope_x - slab.slope_x) +
                             half.y() * std::abs(part.slope_y - slab.slope_y),
                    up = slab.slope_x * dx + slab.slope_y * dy;
        const float rounding = range_rounding * (across + std::abs(up) + std::abs(part.low) + std::abs(part.high));
        slab.low = std::min(slab.low, part.low - across - up - rounding);
        slab.high = std::max(slab.high, part.high + across - up + rounding);
    });
    return slab;
}

} // namespace oncollide
