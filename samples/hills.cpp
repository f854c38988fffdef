#include <oncollide/samples/generators.hpp>

#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/samples/noise.hpp>

namespace oncollide {

namespace {

/// Heights that are integer multiples of a power of two and fit into 16 bits.
class Hills {
public:
    Hills(std::uint32_t cells_x, std::uint32_t cells_y, double spacing, double height, std::uint64_t seed)
        : scale_(1.0 / std::max(cells_x, cells_y)), seed_(seed)
    {
        constexpr std::uint32_t most = 20'000;
        const auto wrong = [](const char* what, double value, double limit) {
            throw Error(ErrorKind::usage,
                        fmt::format("hills: {} is {}; it must be above 0 and at most {}", what, value, limit));
        };
        for (const std::uint32_t cells : {cells_x, cells_y})
            if (cells < 1 || cells > most) wrong("the number of cells", cells, most);
        for (const double size : {spacing, height})
            if (!(size > 0 && size <= 1e9)) wrong(size == height ? "the height" : "the spacing", size, 1e9);
        const int step = std::ilogb(height) - 15;
        whole_ = std::ldexp(height, -step), unit_ = std::ldexp(1, step);
    }

    float operator()(std::uint32_t column, std::uint32_t row) const
    {
        return static_cast<float>(unit_ * std::floor(whole_ * fractal_noise(column * scale_, row * scale_, seed_)));
    }

private:
    double scale_, whole_, unit_;
    std::uint64_t seed_;
};

} // namespace

Terrain make_hills(std::uint32_t cells_x, std::uint32_t cells_y, double spacing, double height, std::uint64_t seed)
{
    const Hills hills(cells_x, cells_y, spacing, height, seed);
    std::vector<float> heights;
    heights.reserve(std::size_t(cells_x + 1) * (cells_y + 1));
    for (std::uint32_t r = 0; r <= cells_y; ++r)
        for (std::uint32_t c = 0; c <= cells_x; ++c) heights.push_back(hills(c, r));
    TerrainGrid grid{.columns = cells_x + 1, .rows = cells_y + 1};
    grid.spacing = {spacing, spacing};
    return make_terrain("hills", grid, heights);
}

Mesh make_hills_mesh(std::uint32_t cells, double spacing, double height, std::uint64_t seed, std::uint32_t x,
                     std::uint32_t y, std::uint32_t size)
{
    const Hills hills(cells, cells, spacing, height, seed);
    if (size < 1 || size > cells || x > cells - size || y > cells - size)
        throw Error(
            ErrorKind::usage,
            fmt::format("hills: a part of {0} x {0} cells from ({1}, {2}) is not in {3} x {3}", size, x, y, cells));
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> triangles;
    vertices.reserve(std::size_t(size + 1) * (size + 1)), triangles.reserve(2 * std::size_t(size) * size);
    for (std::uint32_t r = y; r <= y + size; ++r)
        for (std::uint32_t c = x; c <= x + size; ++c) vertices.push_back({c * spacing, r * spacing, hills(c, r)});
    for (std::uint32_t r = 0; r < size; ++r)
        for (std::uint32_t c = 0; c < size; ++c) {
            const std::uint32_t v = r * (size + 1) + c, above = v + size + 1;
            triangles.push_back({v, v + 1, above + 1}), triangles.push_back({v, above + 1, above});
        }
    return make_mesh("hills", std::move(vertices), std::move(triangles));
}

} // namespace oncollide
