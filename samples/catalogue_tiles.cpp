// Convoys that cross a ground of many tiles.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/files/checksum.hpp>
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/catalogue_scenes.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/samples/noise.hpp>
#include <oncollide/scenes/files/tile_index.hpp>

namespace oncollide {

namespace {

constexpr std::uint32_t tile_cells = 71; ///< per side, of a metre each: 10,082 triangles
constexpr int convoy_width = 10, convoy_bodies = convoy_width * convoy_width;

template <class Value>
std::string_view bytes_of(const std::vector<Value>& values)
{
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

/// The ground: `across` x `across` tiles of one range of hills.
struct Ground {
    std::uint32_t across;
    std::uint64_t seed;

    std::uint32_t cells() const { return across * tile_cells; }
    Json generator(std::size_t tile) const
    {
        return {{"kind", "hills"},
                {"cells", cells()},
                {"spacing", 1},
                {"height", height()},
                {"seed", seed},
                {"x", std::uint32_t(tile % across) * tile_cells},
                {"y", std::uint32_t(tile / across) * tile_cells},
                {"size", tile_cells}};
    }
    Mesh tile(std::size_t tile) const
    {
        return make_hills_mesh(cells(), 1, height(), seed, std::uint32_t(tile % across) * tile_cells,
                               std::uint32_t(tile / across) * tile_cells, tile_cells);
    }
    /// Hash of some generated tiles, so that tiles of another version of the generator have another name.
    std::uint64_t content() const
    {
        std::uint64_t sum = splitmix(tile_cells);
        for (const std::size_t number : {0u, across / 2 * (across + 1), across * across - 1}) {
            const Mesh mesh = tile(number);
            for (const std::string_view bytes : {bytes_of(mesh.vertices), bytes_of(mesh.triangles)})
                sum = splitmix(sum ^ checksum(bytes));
        }
        return sum;
    }
    /// Approximate height of the surface there.
    double height(double x, double y) const { return height() * fractal_noise(x / cells(), y / cells(), seed); }
    double height() const { return 0.03 * cells(); }
};

void add_ground(SceneBuilder& scene, const Ground& ground, const CatalogueOptions& options)
{
    const std::size_t tiles = std::size_t(ground.across) * ground.across;
    if (options.tiles) {
        const std::string name = fmt::format("tiles-{}-{}-{:016x}", ground.across, ground.seed, ground.content());
        const auto index = options.tiles(name, tiles, [&](std::size_t tile) { return ground.tile(tile); });
        return add_tiles(scene, "ground", index, {}, {.on_demand = true});
    }
    for (std::size_t i = 0; i < tiles; ++i) {
        const std::string name = fmt::format("ground/{}", i);
        const GeometryId tile = add_geometry(scene, name, {{"mesh", {{"generate", ground.generator(i)}}}});
        scene.add_body({.name = name, .geometry = tile, .is_static = true});
    }
}

/// A path to the end of the ground and back.
double folded(double at, double length)
{
    const double phase = std::fmod(std::abs(at), 2 * length);
    return phase < length ? phase : 2 * length - phase;
}

} // namespace

void make_tiles_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    constexpr std::int64_t whole = 12'000; // tiles and vehicles of the scene at its full size
    const int bodies = *options.bodies, least_vehicles = static_cast<int>(bodies * std::int64_t{2000} / whole);
    const Ground ground{std::max(1u, static_cast<std::uint32_t>(std::sqrt(double(bodies - least_vehicles)))),
                        options.seed};
    scene.reserve(static_cast<std::size_t>(bodies));
    add_ground(scene, ground, options);
    const auto mesh = [&](const char* name, Json generator) {
        return add_geometry(scene, name, {{"mesh", {{"generate", std::move(generator)}}}});
    };
    const GeometryId kinds[] = {
        mesh("lorry", {{"kind", "box"}, {"half", {2.2, 0.9, 0.7}}}),
        mesh("tank", {{"kind", "sphere"}, {"radius", 0.8}, {"triangles", 600}}),
        mesh("digger", {{"kind", "gear"},
                        {"teeth", 16},
                        {"root_radius", 0.8},
                        {"tip_radius", 1},
                        {"thickness", 1.2},
                        {"bore_radius", 0.3}}),
    };
    constexpr double gap = 6, key_step = 4, speed = 1; // metres, frames, metres per frame
    const double margin = 5, length = ground.cells() - 2 * margin;
    const int frames = std::clamp(*options.frames, 300, 100'000);
    const int vehicles = std::max(0, bodies - static_cast<int>(ground.across * ground.across));
    for (int i = 0; i < vehicles; ++i) {
        const int convoy = i / convoy_bodies, place = i % convoy_bodies;
        Dice dice(options.seed, static_cast<std::uint64_t>(convoy));
        const double turn = dice.between(0, 2 * M_PI), start_x = dice.between(0, length),
                     start_y = dice.between(0, length);
        const Eigen::Vector2d ahead(std::cos(turn), std::sin(turn)), aside(-ahead.y(), ahead.x());
        // Every second vehicle touches the ground, as wheels do, and the others hover above it.
        const double above = place % 2 ? 0.5 : 1.6;
        const auto at = [&](double time) -> Eigen::Vector3d {
            const Eigen::Vector2d way = (speed * time + gap * (place / convoy_width)) * ahead +
                                        gap * (place % convoy_width) * aside + Eigen::Vector2d(start_x, start_y);
            const double x = margin + folded(way.x(), length), y = margin + folded(way.y(), length);
            return {x, y, ground.height(x, y) + above};
        };
        Keyed path;
        const Eigen::Quaterniond forward(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
        for (double time = 0; time < frames + key_step; time += key_step)
            path.keys.push_back({time, at(time), forward});
        BodyInit body{.name = fmt::format("vehicle {}", i), .geometry = kinds[i % 3], .motion = std::move(path)};
        body.pose = pose_at(body.motion, body.pose, 0);
        scene.add_body(std::move(body));
    }
}

} // namespace oncollide
