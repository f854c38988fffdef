#include <oncollide/scenes/model/surface_grid.hpp>

#include <cmath>
#include <map>
#include <numbers>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

/// Cosine and sine of at most an eighth of a turn, by their series; the first omitted term is below 1e-17.
Circle first_octant(double turns)
{
    const double x = 2 * std::numbers::pi * turns, x2 = x * x;
    double cosine = 1, sine = 1;
    for (int k = 9; k >= 1; --k) {
        cosine = 1 - cosine * x2 / ((2 * k - 1) * (2 * k));
        sine = 1 - sine * x2 / ((2 * k) * (2 * k + 1));
    }
    return {cosine, sine * x};
}

} // namespace

Circle circle(double turns)
{
    double t = turns - std::floor(turns);
    const bool below = t > 0.5;
    if (below) t = 1 - t;
    const bool left = t > 0.25;
    if (left) t = 0.5 - t;
    const bool steep = t > 0.125;
    Circle c = first_octant(steep ? 0.25 - t : t);
    if (steep) std::swap(c.cosine, c.sine);
    return {left ? -c.cosine : c.cosine, below ? -c.sine : c.sine};
}

void octasphere(int frequency, std::vector<Eigen::Vector3d>& points, std::vector<Triangle>& triangles)
{
    ONCOLLIDE_ASSERT(frequency >= 1);
    const int n = frequency;
    std::map<std::array<int, 3>, std::uint32_t> known; // integer coordinates on |x| + |y| + |z| == n
    const auto vertex = [&](int x, int y, int z) {
        const auto [place, added] = known.try_emplace({x, y, z}, static_cast<std::uint32_t>(points.size()));
        if (added)
            points.push_back(Eigen::Vector3d(x, y, z) / std::sqrt(double(x) * x + double(y) * y + double(z) * z));
        return place->second;
    };
    for (int face = 0; face < 8; ++face) {
        const int sx = face & 1 ? -1 : 1, sy = face & 2 ? -1 : 1, sz = face & 4 ? -1 : 1;
        const bool mirrored = sx * sy * sz < 0;
        const auto corner = [&](int i, int j) { return vertex(sx * (n - i - j), sy * i, sz * j); };
        const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            triangles.push_back(mirrored ? Triangle{a, c, b} : Triangle{a, b, c});
        };
        for (int j = 0; j < n; ++j)
            for (int i = 0; i + j < n; ++i) {
                add(corner(i, j), corner(i + 1, j), corner(i, j + 1));
                if (i + j + 1 < n) add(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
            }
    }
}

Mesh box_mesh(const Eigen::Vector3d& half)
{
    std::vector<Eigen::Vector3d> points;
    for (int corner = 0; corner < 8; ++corner)
        points.push_back(
            half.cwiseProduct(Eigen::Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
    return make_mesh("box", std::move(points),
                     {{0, 4, 6},
                      {0, 6, 2},
                      {1, 3, 7},
                      {1, 7, 5},
                      {0, 1, 5},
                      {0, 5, 4},
                      {2, 6, 7},
                      {2, 7, 3},
                      {0, 2, 3},
                      {0, 3, 1},
                      {4, 5, 7},
                      {4, 7, 6}});
}

Mesh make_prism(const std::string& name, double radius, double half, int sides)
{
    GridBuilder grid(sides, 1, false);
    grid.build(0, [&](double u, double v) -> Eigen::Vector3d {
        const Circle turn = circle(u / sides);
        return {radius * turn.cosine, radius * turn.sine, v > 0 ? half : -half};
    });
    const auto bottom = static_cast<std::uint32_t>(grid.points.size()), top = bottom + 1;
    grid.points.push_back({0, 0, -half}), grid.points.push_back({0, 0, half});
    for (int i = 0; i < sides; ++i) {
        grid.triangles.push_back({bottom, grid.at(i + 1, 0), grid.at(i, 0)});
        grid.triangles.push_back({top, grid.at(i, 1), grid.at(i + 1, 1)});
    }
    return make_mesh(name, std::move(grid.points), std::move(grid.triangles));
}

} // namespace oncollide
