// Bodies of all shapes above a hill that becomes flat.
#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/samples/bodies_above.hpp>
#include <oncollide/samples/catalogue_scenes.hpp>
#include <oncollide/samples/varied_shapes.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr double cell = 0.1;   ///< metres between heights
constexpr double apart = 0.7;  ///< metres between bodies at the start
constexpr double start = 0.06; ///< of the hill, as a share of its length

/// A slope of 42 degrees that becomes flat, between walls; x and y from 0 to 1.
double slope(double x, double y)
{
    const double above = std::max(0.0, 0.6 - x), aside = 2 * y - 1, end = std::max(0.0, (x - 0.7) / 0.3);
    return 0.75 * above * above + 0.1 * std::pow(aside, 6) + 0.1 * std::pow(end, 4);
}

Terrain make_slope(std::uint32_t cells, std::uint64_t seed)
{
    const auto bumps = [&](std::uint32_t c, std::uint32_t r, std::uint32_t wide) {
        const std::uint64_t x = c / wide, y = r / wide;
        const auto eased = [](double t) { return t * t * (3 - 2 * t); };
        const double u = eased(double(c % wide) / wide), v = eased(double(r % wide) / wide);
        return (1 - v) * ((1 - u) * u01(seed, x, y) + u * u01(seed, x + 1, y)) +
               v * ((1 - u) * u01(seed, x, y + 1) + u * u01(seed, x + 1, y + 1));
    };
    std::vector<float> heights;
    for (std::uint32_t r = 0; r <= cells; ++r)
        for (std::uint32_t c = 0; c <= cells; ++c)
            heights.push_back(float(cells * cell * slope(double(c) / cells, double(r) / cells) +
                                    0.25 * bumps(c, r, 24) + 0.1 * bumps(c, r, 8)));
    TerrainGrid grid{.columns = cells + 1, .rows = cells + 1};
    grid.spacing = {cell, cell};
    return make_terrain("hill", grid, heights);
}

/// Falls onto the hill and rolls down along x, ten frames a key, as if the body were alone.
Keyed way_down(const Terrain& hill, const Vector3d& from, const Eigen::Quaterniond& rotation)
{
    constexpr double seconds = 0.4, gravity = 9.81, radius = 0.15, braked = 0.3;
    const double most = hill.bounds().max.x() - 1;
    Keyed way;
    Vector3d at = from;
    double fallen = 0, speed = 0, turn = 0;
    for (int k = 0; k <= 40; ++k) {
        const Eigen::Quaterniond turned(Eigen::AngleAxisd(turn, Vector3d::UnitY()) * rotation);
        way.keys.push_back({10.0 * k, at, turned.normalized()});
        const double ground = height_at(hill, at.x(), at.y()) + radius;
        fallen += gravity * seconds;
        if (at.z() - fallen * seconds > ground) {
            at.z() -= fallen * seconds;
            continue;
        }
        const double steep = (ground - radius - height_at(hill, at.x() + 0.5, at.y())) / 0.5;
        speed = std::max(0.0, speed + seconds * gravity * (steep - braked));
        const double next = std::min(most, at.x() + speed * seconds);
        turn += (next - at.x()) / radius / 8; // a key is less than half a turn from the next
        at = {next, at.y(), height_at(hill, next, at.y()) + radius};
    }
    return way;
}

/// Shapes of all kinds in turns, then two concave meshes.
std::vector<GeometryId> add_varied_geometries(SceneBuilder& scene, std::uint64_t seed)
{
    using enum ShapeKind;
    constexpr ShapeKind kinds[] = {box, sphere, capsule, hull, cylinder, cone, ellipsoid};
    std::vector<GeometryId> all;
    for (std::uint64_t i = 0; i < 32 * std::size(kinds); ++i) {
        ShapeDice dice(seed + 1, i);
        const ShapeKind kind = kinds[i % std::size(kinds)];
        all.push_back(scene.add(fmt::format("{}-{}", name_of(kind), i / std::size(kinds)), draw_shape(kind, dice)));
    }
    all.push_back(add_geometry(scene, "gear",
                               {{"mesh",
                                 {{"generate",
                                   {{"kind", "gear"},
                                    {"teeth", 8},
                                    {"root_radius", 0.15},
                                    {"tip_radius", 0.22},
                                    {"thickness", 0.12},
                                    {"bore_radius", 0.06}}}}}}));
    all.push_back(add_geometry(scene, "knot",
                               {{"mesh",
                                 {{"generate",
                                   {{"kind", "torus_knot"},
                                    {"p", 2},
                                    {"q", 3},
                                    {"major", 0.15},
                                    {"minor", 0.08},
                                    {"tube", 0.04},
                                    {"triangles", 600}}}}}}));
    return all;
}

} // namespace

void make_avalanche_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const auto count = static_cast<std::uint64_t>(*options.bodies);
    const auto cells = static_cast<std::uint32_t>(std::ceil(7 * std::sqrt(std::max(*options.bodies, 60))));
    const double size = cells * cell;
    const GeometryId land = scene.add("hill", make_slope(cells, options.seed));
    const std::vector<GeometryId> geometries = add_varied_geometries(scene, options.seed);
    const auto& hill = std::get<Terrain>(scene.geometries()[index(land)].data);
    scene.add_body({.name = "hill", .geometry = land, .is_static = true});
    const std::size_t meshes = 2, shapes = geometries.size() - meshes;
    // Layers of rows above the upper part of the hill; one body in 21 is a mesh.
    const auto long_ = std::max<std::uint64_t>(2, std::uint64_t(0.25 * size / apart));
    const auto wide = std::max<std::uint64_t>(2, std::uint64_t(0.6 * size / apart));
    for (std::uint64_t i = 0; i < count; ++i) {
        if (scene.skip_body()) continue;
        ShapeDice dice(options.seed + 2, i);
        const Eigen::Quaterniond rotation = dice.rotation();
        const double x = start * size + apart * double(i / wide % long_) + dice.between(-0.1, 0.1);
        const double y = 0.2 * size + apart * double(i % wide) + dice.between(-0.1, 0.1);
        const Vector3d at(x, y, height_at(hill, x, y) + 0.6 + apart * double(i / (wide * long_)));
        const std::uint64_t turn = i / 21;
        const GeometryId kind =
            i % 21 == 20 ? geometries[shapes + turn % meshes] : geometries[(20 * turn + i % 21) % shapes];
        scene.add_body({.name = fmt::format("{}-{}", scene.geometries()[index(kind)].name, i),
                        .geometry = kind,
                        .pose = placed(at, rotation),
                        .motion = way_down(hill, at, rotation)});
    }
}

} // namespace oncollide
