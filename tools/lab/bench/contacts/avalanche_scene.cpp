#include "bench/contacts/avalanche_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>

#include "bench/contacts/shape_bodies.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double spacing = 0.25;

/// A slope of 40 degrees that becomes flat, between walls, with bumps of up to 0.3 m. x and y from 0 to 1.
double slope(double x, double y, double size)
{
    const double aside = 2 * y - 1, rest = std::max(0.0, x - 0.8);
    return size * (0.28 * std::pow(1 - x, 3) + 0.3 * std::pow(aside, 6) + 2 * rest * rest);
}

Terrain make_hill(std::uint32_t cells, std::uint64_t seed)
{
    const double size = cells * spacing;
    // Bumps as wide as two cells and more.
    const auto bump = [&](std::uint64_t c, std::uint64_t r) { return u01(seed, c, r); };
    const auto smooth = [&](std::uint32_t c, std::uint32_t r, std::uint32_t wide) {
        const std::uint64_t x = c / wide, y = r / wide;
        const double u = double(c % wide) / wide, v = double(r % wide) / wide;
        return (1 - v) * ((1 - u) * bump(x, y) + u * bump(x + 1, y)) +
               v * ((1 - u) * bump(x, y + 1) + u * bump(x + 1, y + 1));
    };
    std::vector<float> heights;
    for (std::uint32_t r = 0; r <= cells; ++r)
        for (std::uint32_t c = 0; c <= cells; ++c)
            heights.push_back(float(slope(double(c) / cells, double(r) / cells, size) + 0.2 * smooth(c, r, 12) +
                                    0.1 * smooth(c, r, 4)));
    TerrainGrid grid{.columns = cells + 1, .rows = cells + 1};
    grid.spacing = {spacing, spacing};
    return make_terrain("hill", grid, heights);
}

Vector3d half_size(const Geometry& geometry)
{
    const Aabb box = bounds_of(geometry);
    return 0.5 * (box.max - box.min);
}

} // namespace

double height_at(const Terrain& hill, double x, double y)
{
    const double c = (x - hill.x(0)) / hill.spacing().x(), r = (y - hill.y(0)) / hill.spacing().y();
    if (!(c >= 0 && r >= 0 && c < hill.cells_x() && r < hill.cells_y())) return std::numeric_limits<double>::infinity();
    const auto column = std::uint32_t(c), row = std::uint32_t(r);
    const double u = c - column, v = r - row;
    const auto z = [&](std::uint32_t dc, std::uint32_t dr) { return hill.point(column + dc, row + dr).z(); };
    // The lower triangle's corners, or the upper one's, of a rising diagonal.
    return u >= v ? z(0, 0) + u * (z(1, 0) - z(0, 0)) + v * (z(1, 1) - z(1, 0))
                  : z(0, 0) + v * (z(0, 1) - z(0, 0)) + u * (z(1, 1) - z(0, 1));
}

AvalancheScene make_avalanche(int bodies, int meshes, std::uint64_t seed)
{
    const int count = bodies + meshes;
    const auto cells = std::uint32_t(std::ceil(7 * std::sqrt(std::max(count, 60))));
    const double size = cells * spacing;
    AvalancheScene scene;
    Terrain hill = make_hill(cells, seed);
    using enum ShapeKind;
    constexpr ShapeKind kinds[] = {box, sphere, capsule, hull, cylinder, cone, ellipsoid};
    std::vector<std::shared_ptr<const Geometry>> shapes, concave;
    for (std::uint64_t i = 0; i < 32 * std::size(kinds); ++i) {
        ShapeDice dice(seed + 1, i);
        shapes.push_back(
            std::make_shared<const Geometry>(Geometry{"", draw_shape(kinds[i % std::size(kinds)], dice), {}}));
    }
    for (GeometryData& data : std::array<GeometryData, 2>{make_gear_mesh(8, 0.15, 0.22, 0.12, 0.06),
                                                          make_torus_knot_mesh(2, 3, 0.15, 0.08, 0.04, 600)})
        concave.push_back(std::make_shared<const Geometry>(Geometry{"", std::move(data), {}}));
    // Layers above the upper part of the hill.
    constexpr double apart = 0.7;
    const int wide = std::max(2, int(0.4 * size / apart)), long_ = std::max(2, int(0.15 * size / apart));
    for (int i = 0; i < count; ++i) {
        ShapeDice dice(seed + 2, std::uint64_t(i));
        const double x = 0.1 * size + apart * (i / wide % long_) + dice.between(-0.1, 0.1);
        const double y = 0.3 * size + apart * (i % wide) + dice.between(-0.1, 0.1);
        Isometry3d pose(dice.rotation());
        pose.translation() = Vector3d(x, y, height_at(hill, x, y) + 0.6 + apart * (i / (wide * long_)));
        const auto k = std::size_t(i);
        const bool is_mesh = std::int64_t(i + 1) * meshes / count > std::int64_t(i) * meshes / count;
        const auto& geometry = is_mesh ? concave[k % concave.size()] : shapes[k % shapes.size()];
        scene.bodies.push_back({.geometry = geometry, .pose = pose, .half = half_size(*geometry)});
    }
    scene.hill = std::make_shared<const Geometry>(Geometry{"hill", std::move(hill), {}});
    return scene;
}

} // namespace oncollide::tools
