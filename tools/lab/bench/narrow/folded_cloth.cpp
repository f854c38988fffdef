#include "bench/narrow/folded_cloth.hpp"

#include <algorithm>
#include <cmath>

namespace oncollide::tools {
namespace {

constexpr int layers = 10;
constexpr double apart = 0.01; ///< distance of two layers: the diameter of the bends between them

/// The point `s` along a line of length 1 that runs to and fro, x and z.
Eigen::Vector2d along_folds(double s)
{
    constexpr double bend = M_PI / 2 * apart, run = (1 - (layers - 1) * bend) / layers;
    const int layer = std::min(int(s / (run + bend)), layers - 1);
    const bool back = layer % 2;
    const double in_layer = s - layer * (run + bend), z = layer * apart;
    if (in_layer <= run) return {back ? run - in_layer : in_layer, z};
    const double turn = (in_layer - run) / (apart / 2), out = apart / 2 * std::sin(turn);
    return {back ? -out : run + out, z + apart / 2 * (1 - std::cos(turn))};
}

} // namespace

Mesh make_folded_cloth(int triangles, double ripples)
{
    const auto cells = static_cast<std::uint32_t>(std::max(1.0, std::round(std::sqrt(triangles / 2.0))));
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> all;
    for (std::uint32_t j = 0; j <= cells; ++j)
        for (std::uint32_t i = 0; i <= cells; ++i) {
            const double s = double(i) / cells, y = double(j) / cells;
            const Eigen::Vector2d at = along_folds(s);
            const double ripple = std::sin(61 * s + 13 * y) * std::cos(47 * y - 5 * s) + 0.3 * std::sin(160 * s * y);
            vertices.push_back({at[0], y, at[1] + ripples * apart * ripple});
        }
    const std::uint32_t up = cells + 1;
    for (std::uint32_t j = 0; j < cells; ++j)
        for (std::uint32_t i = 0; i < cells; ++i) {
            const std::uint32_t at = j * up + i;
            all.push_back({at, at + 1, at + up + 1}), all.push_back({at, at + up + 1, at + up});
        }
    return make_mesh("folded cloth", std::move(vertices), std::move(all));
}

} // namespace oncollide::tools
