#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/noise.hpp>
#include <oncollide/scenes/model/terrain.hpp>

namespace oncollide {

Terrain make_hills(std::uint32_t cells_x, std::uint32_t cells_y, double spacing, double height, std::uint64_t seed)
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

    // Whole multiples of a power of two, of which 16 bits hold all.
    const int step = std::ilogb(height) - 15;
    const double whole = std::ldexp(height, -step), unit = std::ldexp(1, step);
    const double scale = 1.0 / std::max(cells_x, cells_y);
    std::vector<float> heights;
    heights.reserve(std::size_t(cells_x + 1) * (cells_y + 1));
    for (std::uint32_t r = 0; r <= cells_y; ++r)
        for (std::uint32_t c = 0; c <= cells_x; ++c)
            heights.push_back(static_cast<float>(unit * std::floor(whole * fractal_noise(c * scale, r * scale, seed))));
    TerrainGrid grid{.columns = cells_x + 1, .rows = cells_y + 1};
    grid.spacing = {spacing, spacing};
    return make_terrain("hills", grid, heights);
}

} // namespace oncollide
