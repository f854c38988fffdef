#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/model/terrain/height_mover.hpp>
#include <oncollide/scenes/model/vertex_mover.hpp>

namespace oncollide {

namespace {

/// Exponent of the lowest bit that is set; a large number for 0.
int lowest_bit(double value)
{
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const int exponent = static_cast<int>(bits >> 52 & 0x7ff);
    const std::uint64_t digits = (bits & ((std::uint64_t{1} << 52) - 1)) | (exponent ? std::uint64_t{1} << 52 : 0);
    return digits ? std::max(exponent, 1) - 1075 + std::countr_zero(digits) : 4096;
}

/// The nearest integer, for magnitudes below 2^51: std::nearbyint() is a function call without SSE4.1.
double nearest(double value)
{
    constexpr double shift = 0x1.8p52;
    return (value + shift) - shift;
}

} // namespace

/// Reads all heights once, chooses their storage, and stores them.
class TerrainBuilder {
public:
    TerrainBuilder(const std::string& name, const TerrainGrid& grid, std::size_t count) : name_(name), grid_(grid)
    {
        check_grid(count);
    }

    template <class Height>
    Terrain build(std::span<const Height> heights)
    {
        look_at(heights);
        choose_unit();
        const int bytes = grid_.bytes ? grid_.bytes : fewest_bytes(heights);
        Terrain& t = terrain_;
        t.columns_ = grid_.columns, t.rows_ = grid_.rows;
        t.tiles_x_ = (grid_.columns + Terrain::tile - 1) / Terrain::tile;
        t.spacing_ = grid_.spacing, t.origin_ = grid_.origin, t.diagonal_ = grid_.diagonal;
        t.bytes_ = bytes, t.no_data_ = grid_.no_data;
        if (bytes == 1) heights_->samples = keep_whole<std::uint8_t>(heights);
        if (bytes == 2) heights_->samples = keep_whole<std::uint16_t>(heights);
        if (bytes == 4) heights_->samples = keep_real<float>(heights);
        if (bytes == 8) heights_->samples = keep_real<double>(heights);
        t.error_ = t.error_ * (1 + 0x1p-40) + grid_.error; // differences were rounded
        keep_diagonals();
        t.heights_ = std::move(heights_);
        find_cells();
        return std::move(t);
    }

private:
    [[noreturn]] void fail(const std::string& what) const { refuse(name_, what); }
    void check_grid(std::size_t count) const;
    template <class Height>
    void look_at(std::span<const Height> heights);
    void choose_unit();
    template <class Height>
    int fewest_bytes(std::span<const Height> heights) const;
    template <class Sample, class Height>
    LargeVector<Sample> keep_whole(std::span<const Height> heights);
    template <class Sample, class Height>
    LargeVector<Sample> keep_real(std::span<const Height> heights);
    void keep_diagonals();
    void find_cells();

    bool hole(double height) const
    {
        return grid_.no_data && (height == *grid_.no_data || (std::isnan(height) && std::isnan(*grid_.no_data)));
    }
    /// Calls visit(tile number, columns from, to, rows from, to).
    template <class Visit>
    void each_tile(Visit visit) const
    {
        std::size_t number = 0;
        for (std::uint32_t row = 0; row < grid_.rows; row += Terrain::tile)
            for (std::uint32_t column = 0; column < grid_.columns; column += Terrain::tile, ++number)
                visit(number, column, std::min(column + Terrain::tile, grid_.columns), row,
                      std::min(row + Terrain::tile, grid_.rows));
    }
    std::size_t tiles() const
    {
        return std::size_t((grid_.columns + Terrain::tile - 1) / Terrain::tile) *
               ((grid_.rows + Terrain::tile - 1) / Terrain::tile);
    }
    std::size_t at(std::uint32_t column, std::uint32_t row) const { return std::size_t(row) * grid_.columns + column; }

    struct Range {
        std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = std::numeric_limits<std::int32_t>::min();
        void add(std::int32_t n) { low = std::min(low, n), high = std::max(high, n); }
        std::int64_t size() const { return std::int64_t(high) - low; }
    };
    /// The height in units of unit_.
    std::int32_t whole(double height) const { return static_cast<std::int32_t>(nearest(height * per_unit_)); }

    const std::string& name_;
    const TerrainGrid& grid_;
    Terrain terrain_;
    std::shared_ptr<TerrainHeights> heights_ = std::make_shared<TerrainHeights>();
    double least_ = std::numeric_limits<double>::infinity(), greatest_ = -least_;
    double largest_ = 0; ///< largest magnitude of a height
    int lowest_ = 4096;  ///< exponent of a power of two that divides all heights
    bool holes_ = false;
    bool floats_ = true, units_ = true; ///< all heights are floats; all are multiples of grid.unit
    bool whole_ = false;                ///< all heights are integer multiples of unit_
    double unit_ = 1, per_unit_ = 1;
};

void TerrainBuilder::check_grid(std::size_t count) const
{
    const auto& [columns, rows] = std::pair(grid_.columns, grid_.rows);
    if (columns < 2 || rows < 2)
        fail(fmt::format("the terrain has {} x {} heights; it needs at least two columns and two rows", columns, rows));
    if (std::uint64_t(columns - 1) * (rows - 1) > Terrain::most_cells)
        fail(fmt::format("the terrain has {} x {} heights; at most {} cells are allowed", columns, rows,
                         Terrain::most_cells));
    if (std::uint64_t(columns) * rows != count) fail(fmt::format("{} heights for {} x {}", count, columns, rows));
    if (!grid_.falling.empty() && grid_.falling.size() != std::uint64_t(columns - 1) * (rows - 1))
        fail(fmt::format("{} diagonals for {} x {} cells", grid_.falling.size(), columns - 1, rows - 1));
    if (grid_.bytes < 0 || grid_.bytes > 8 || (grid_.bytes & (grid_.bytes - 1)))
        throw Error(ErrorKind::usage,
                    fmt::format("{}: heights of {} bytes; must be 1, 2, 4 or 8, or 0 for the fewest that are exact",
                                name_, grid_.bytes));
    if (!(grid_.error >= 0 && grid_.error <= largest_coordinate))
        fail(fmt::format("the error of heights is {}; must be 0 or more", grid_.error));
    if (!(grid_.unit >= 0 && grid_.unit <= largest_coordinate))
        fail(fmt::format("the unit of heights is {}; must be 0 or more", grid_.unit));
    for (int i = 0; i < 2; ++i) {
        const double from = grid_.origin[i], to = from + grid_.spacing[i] * (i ? rows - 1 : columns - 1);
        const double far = std::max(std::abs(from), std::abs(to));
        if (!(grid_.spacing[i] > 0)) fail(fmt::format("the spacing is {}; must be above 0", grid_.spacing[i]));
        if (!(far <= largest_coordinate))
            fail(fmt::format("the grid is from {} to {}, at most {:g} m from the origin are allowed", from, to,
                             largest_coordinate));
        if (grid_.spacing[i] < 0x1p-30 * far)
            fail(
                fmt::format("the spacing of {} m is too small for a grid from {} to {} m", grid_.spacing[i], from, to));
    }
    if (!(std::abs(grid_.origin.z()) <= largest_coordinate)) fail("the origin is not finite, or too far");
}

template <class Height>
void TerrainBuilder::look_at(std::span<const Height> heights)
{
    const double per_unit = grid_.unit > 0 ? 1 / grid_.unit : 0;
    double per_lowest = 0; // 2^-lowest_, kept between heights: most heights are multiples of the same power
    for (const Height& given : heights) {
        const double height = given;
        if (hole(height)) {
            holes_ = true;
            continue;
        }
        if (!(std::abs(height) <= largest_coordinate)) {
            const auto number = static_cast<std::size_t>(&given - heights.data());
            refuse_height(name_, number % grid_.columns, number / grid_.columns, height);
        }
        least_ = std::min(least_, height), greatest_ = std::max(greatest_, height);
        const double multiple = height * per_lowest;
        if (per_lowest == 0 || nearest(multiple) != multiple) {
            lowest_ = std::min(lowest_, lowest_bit(height));
            per_lowest = std::ldexp(1, -std::clamp(lowest_, -1000, 1000));
        }
        floats_ &= static_cast<float>(height) == height;
        if (grid_.unit > 0) units_ &= grid_.unit * nearest(height * per_unit) == height;
    }
    if (least_ > greatest_) fail("every height is a hole");
    largest_ = std::max(std::abs(least_), std::abs(greatest_));
}

/// Chooses the unit: the largest that divides all heights, if there is one; else a power of two that is fine enough.
void TerrainBuilder::choose_unit()
{
    constexpr double most = 0x1p30;
    whole_ = true;
    if (grid_.unit > 0 && units_ && largest_ <= most * grid_.unit) {
        unit_ = grid_.unit;
    } else if (lowest_ >= -1022 && largest_ <= std::ldexp(most, std::min(lowest_, 900))) {
        unit_ = std::ldexp(1, std::min(lowest_, 900));
    } else {
        whole_ = false;
        unit_ = std::ldexp(1, std::max(std::ilogb(largest_) - 29, -1000));
    }
    per_unit_ = 1 / unit_, terrain_.unit_ = unit_;
}

template <class Height>
int TerrainBuilder::fewest_bytes(std::span<const Height> heights) const
{
    if (whole_) {
        std::int64_t widest = 0;
        each_tile([&](std::size_t, std::uint32_t x0, std::uint32_t x1, std::uint32_t y0, std::uint32_t y1) {
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (std::uint32_t y = y0; y < y1; ++y)
                for (std::uint32_t x = x0; x < x1; ++x) {
                    const double height = heights[at(x, y)];
                    if (holes_ && hole(height)) continue;
                    low = height < low ? height : low, high = height > high ? height : high;
                }
            if (low > high) return;
            const Range range{whole(low), whole(high)};
            widest = std::max(widest, range.size());
        });
        if (widest < 0xff) return 1;
        if (widest < 0xffff) return 2;
    }
    return floats_ ? 4 : 8;
}

template <class Sample, class Height>
LargeVector<Sample> TerrainBuilder::keep_whole(std::span<const Height> heights)
{
    constexpr Sample no_height = std::numeric_limits<Sample>::max();
    LargeVector<Sample> samples(tiles() * Terrain::tile * Terrain::tile, no_height);
    heights_->tiles.resize(tiles());
    each_tile([&](std::size_t number, std::uint32_t x0, std::uint32_t x1, std::uint32_t y0, std::uint32_t y1) {
        Range range;
        std::int32_t units[Terrain::tile * Terrain::tile];
        bool holes[Terrain::tile * Terrain::tile];
        for (std::uint32_t y = y0; y < y1; ++y)
            for (std::uint32_t x = x0; x < x1; ++x) {
                const std::uint32_t k = (y - y0) * Terrain::tile + x - x0;
                const double height = heights[at(x, y)];
                if ((holes[k] = holes_ && hole(height))) continue;
                range.add(units[k] = whole(height));
            }
        TerrainTile& of = heights_->tiles[number];
        if (range.size() < 0) return;
        of.base = range.low;
        const auto rounded = [&](std::int64_t n) { return (n + (std::int64_t{1} << of.shift >> 1)) >> of.shift; };
        while (rounded(range.size()) >= no_height) ++of.shift;
        for (std::uint32_t y = y0; y < y1; ++y)
            for (std::uint32_t x = x0; x < x1; ++x) {
                const std::uint32_t k = (y - y0) * Terrain::tile + x - x0;
                if (holes[k]) continue;
                const auto q = static_cast<Sample>(rounded(std::int64_t(units[k]) - range.low));
                samples[number * (Terrain::tile * Terrain::tile) + k] = q;
                if (whole_ && of.shift == 0) continue;
                const double kept = unit_ * static_cast<double>(of.at(q));
                terrain_.error_ = std::max(terrain_.error_, std::abs(kept - double(heights[at(x, y)])));
            }
    });
    return samples;
}

template <class Sample, class Height>
LargeVector<Sample> TerrainBuilder::keep_real(std::span<const Height> heights)
{
    constexpr Sample no_height = std::numeric_limits<Sample>::quiet_NaN();
    LargeVector<Sample> samples(tiles() * Terrain::tile * Terrain::tile, no_height);
    each_tile([&](std::size_t number, std::uint32_t x0, std::uint32_t x1, std::uint32_t y0, std::uint32_t y1) {
        for (std::uint32_t y = y0; y < y1; ++y)
            for (std::uint32_t x = x0; x < x1; ++x) {
                const double height = heights[at(x, y)];
                if (hole(height)) continue;
                const auto kept = static_cast<Sample>(height);
                samples[number * (Terrain::tile * Terrain::tile) + (y - y0) * Terrain::tile + x - x0] = kept;
                terrain_.error_ = std::max(terrain_.error_, std::abs(double(kept) - height));
            }
    });
    return samples;
}

void TerrainBuilder::keep_diagonals()
{
    terrain_.mixed_ = !grid_.falling.empty();
    heights_->falling.resize((grid_.falling.size() + 63) / 64);
    for (std::size_t i = 0; i < grid_.falling.size(); ++i)
        heights_->falling[i / 64] |= std::uint64_t{grid_.falling[i]} << i % 64;
}

void TerrainBuilder::find_cells()
{
    Terrain& t = terrain_;
    const std::uint32_t nx = t.cells_x(), ny = t.cells_y();
    if (!holes_) {
        t.cells_ = std::uint64_t(nx) * ny;
        t.least_ = {0, 0}, t.greatest_ = {nx, ny}, t.low_ = least_, t.high_ = greatest_;
    } else {
        t.least_ = {nx, ny}, t.greatest_ = {0, 0}, t.low_ = greatest_, t.high_ = least_;
        std::vector<double> low(t.columns_), high(t.columns_); // heights of the rows below and above the cells
        t.read_row(0, 0, low.data());
        for (std::uint32_t y = 0; y < ny; ++y, low.swap(high)) {
            t.read_row(y + 1, 0, high.data());
            for (std::uint32_t x = 0; x < nx; ++x) {
                if (std::isnan(low[x] + low[x + 1] + high[x] + high[x + 1])) continue;
                const auto [least, greatest] = std::minmax({low[x], low[x + 1], high[x], high[x + 1]});
                ++t.cells_;
                t.low_ = std::min(t.low_, least), t.high_ = std::max(t.high_, greatest);
                t.least_ = {std::min(t.least_.column, x), std::min(t.least_.row, y)};
                t.greatest_ = {std::max(t.greatest_.column, x + 1), std::max(t.greatest_.row, y + 1)};
            }
        }
    }
    if (t.cells_ == 0) fail("the terrain has no cell: each touches a hole");
    t.holes_ = t.cells_ < std::uint64_t(nx) * ny;
    t.find_bounds();
    ONCOLLIDE_ASSERT(!t.bounds_.empty() && t.cells_ <= Terrain::most_cells);
}

Terrain make_terrain(const std::string& name, const TerrainGrid& grid, std::span<const double> heights)
{
    return TerrainBuilder(name, grid, heights.size()).build(heights);
}

Terrain make_terrain(const std::string& name, const TerrainGrid& grid, std::span<const float> heights)
{
    return TerrainBuilder(name, grid, heights.size()).build(heights);
}

} // namespace oncollide
