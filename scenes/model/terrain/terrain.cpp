#include <oncollide/scenes/model/terrain.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/memory/large_vector.hpp>
#include <oncollide/scenes/model/terrain/terrain_chunks.hpp>

namespace oncollide {

void Terrain::find_bounds()
{
    ONCOLLIDE_ASSERT(least_.column < greatest_.column && least_.row < greatest_.row && greatest_.column < columns_ &&
                     greatest_.row < rows_);
    ONCOLLIDE_ASSERT(low_ <= high_ && error_ >= 0);
    bounds_ = {};
    bounds_.add(Eigen::Vector3d(x(least_.column), y(least_.row), origin_.z() + low_ - error_));
    bounds_.add(Eigen::Vector3d(x(greatest_.column), y(greatest_.row), origin_.z() + high_ + error_));
}

double Terrain::height(std::uint32_t column, std::uint32_t row) const
{
    return TerrainAccess::height(*this, column, row);
}

double Terrain::x(std::uint32_t column) const
{
    return TerrainAccess::x(*this, column);
}

double Terrain::y(std::uint32_t row) const
{
    return TerrainAccess::y(*this, row);
}

Eigen::Vector3d Terrain::point(std::uint32_t column, std::uint32_t row) const
{
    return TerrainAccess::point(*this, column, row);
}

CellDiagonal Terrain::diagonal(std::uint32_t x, std::uint32_t y) const
{
    return TerrainAccess::diagonal(*this, x, y);
}

double TerrainAccess::height_in_chunk(const Terrain& t, std::uint32_t column, std::uint32_t row)
{
    return t.chunks_->height(column, row);
}

CellDiagonal TerrainAccess::diagonal_in_chunk(const Terrain& t, std::uint32_t x, std::uint32_t y)
{
    return t.chunks_->diagonal(x, y);
}

Terrain centred(Terrain terrain)
{
    terrain.origin_ -= terrain.bounds_.centre();
    terrain.find_bounds();
    return terrain;
}

std::size_t Terrain::bytes() const
{
    if (chunks_) return chunks_->bytes();
    return std::visit([](const auto& samples) { return samples.size() * sizeof(samples[0]); }, heights_->samples) +
           heights_->tiles.size() * sizeof(TerrainTile) + heights_->falling.size() * 8;
}

template <class Number>
void Terrain::read_row(std::uint32_t row, double zero, Number* out) const
{
    ONCOLLIDE_ASSERT(row < rows_);
    if (chunks_) {
        std::vector<double> heights(columns_);
        chunks_->read_row(row, 0, columns_, heights.data());
        std::ranges::transform(heights, out, [&](double height) { return static_cast<Number>(height - zero); });
        return;
    }
    std::visit(
        [&](const auto& samples) {
            using Sample = typename std::decay_t<decltype(samples)>::value_type;
            std::size_t number = std::size_t(row / tile) * tiles_x_;
            for (std::uint32_t column = 0; column < columns_; column += tile, ++number) {
                const Sample* const from = &samples[number * (tile * tile) + row % tile * tile];
                Number eight[tile];
                if constexpr (std::is_floating_point_v<Sample>) {
                    for (std::uint32_t i = 0; i < tile; ++i) eight[i] = static_cast<Number>(from[i] - zero);
                } else {
                    const TerrainTile t = heights_->tiles[number];
                    constexpr Number none = std::numeric_limits<Number>::quiet_NaN();
                    for (std::uint32_t i = 0; i < tile; ++i) {
                        const auto height = static_cast<Number>(unit_ * static_cast<double>(t.at(from[i])) - zero);
                        eight[i] = from[i] == std::numeric_limits<Sample>::max() ? none : height;
                    }
                }
                std::copy_n(eight, std::min(tile, columns_ - column), out + column);
            }
        },
        heights_->samples);
}
template void Terrain::read_row(std::uint32_t, double, float*) const;
template void Terrain::read_row(std::uint32_t, double, double*) const;

void Terrain::read_cells(std::uint32_t y, std::vector<bool>& there) const
{
    there.assign(cells_x(), true);
    if (!holes_) return;
    std::vector<float> low(columns_), high(columns_);
    read_row(y, 0, low.data()), read_row(y + 1, 0, high.data());
    for (std::uint32_t x = 0; x < cells_x(); ++x) there[x] = !std::isnan(low[x] + low[x + 1] + high[x] + high[x + 1]);
}

bool Terrain::has_cell(std::uint32_t x, std::uint32_t y) const
{
    ONCOLLIDE_ASSERT(x < cells_x() && y < cells_y());
    return !holes_ || !std::isnan(height(x, y) + height(x + 1, y) + height(x, y + 1) + height(x + 1, y + 1));
}

std::array<Terrain::Place, 3> Terrain::corners(std::uint32_t triangle) const
{
    ONCOLLIDE_ASSERT(triangle / 2 < std::uint64_t(cells_x()) * cells_y());
    const std::uint32_t x = triangle / 2 % cells_x(), y = triangle / 2 / cells_x();
    const Place least{x, y}, right{x + 1, y}, up{x, y + 1}, greatest{x + 1, y + 1};
    if (TerrainAccess::diagonal(*this, x, y) == CellDiagonal::rising)
        return triangle % 2 ? std::array{least, greatest, up} : std::array{least, right, greatest};
    return triangle % 2 ? std::array{right, greatest, up} : std::array{least, right, up};
}

Mesh mesh_of(const Terrain& terrain)
{
    if (terrain.cells() > std::numeric_limits<std::uint32_t>::max() / 2)
        refuse("terrain", fmt::format("a mesh cannot have the triangles of {} cells", terrain.cells()));
    std::vector<Eigen::Vector3d> points;
    std::vector<Triangle> triangles;
    reserve_large(points, std::size_t(terrain.columns()) * terrain.rows()),
        reserve_large(triangles, 2 * terrain.cells());
    for (std::uint32_t r = 0; r < terrain.rows(); ++r)
        for (std::uint32_t c = 0; c < terrain.columns(); ++c) {
            Eigen::Vector3d point = terrain.point(c, r);
            if (std::isnan(point.z())) point.z() = 0; // no triangle uses the point
            points.push_back(point);
        }
    for (std::uint32_t y = 0; y < terrain.cells_y(); ++y)
        for (std::uint32_t x = 0; x < terrain.cells_x(); ++x) {
            if (!terrain.has_cell(x, y)) continue;
            for (std::uint32_t half = 0; half < 2; ++half) {
                const auto corners = terrain.corners(2 * (y * terrain.cells_x() + x) + half);
                Triangle& t = triangles.emplace_back();
                for (std::size_t k = 0; k < 3; ++k) t[k] = corners[k].row * terrain.columns() + corners[k].column;
            }
        }
    return make_mesh("terrain", std::move(points), std::move(triangles));
}

} // namespace oncollide
