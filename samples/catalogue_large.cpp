// Worlds as found in practice: a scanned campus, a mountain, a game's ground in pieces, and very many bodies.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/samples/bodies_above.hpp>
#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

namespace {

/// The file of the data folder or, if it is missing, a generated environment of the same size, with a warning.
GeometryId add_environment(SceneBuilder& scene, const CatalogueOptions& options, const std::string& name,
                           const char* kind, const std::string& file, Json stand_in)
{
    const std::filesystem::path path = options.data / file;
    std::error_code ignored;
    if (!options.data.empty() && std::filesystem::is_regular_file(path, ignored))
        stand_in = {{"file", path.string()}};
    else
        scene.warnings().push_back(fmt::format("{}: no data folder with {}; uses a generated one instead", name, file));
    return add_geometry(scene, name, {{kind, std::move(stand_in)}});
}

/// Follows the edges of a terrain's cells, a little above the ground; turns at the end of the ground.
Keyed route(const Terrain& ground, double height, int frames, Dice& dice)
{
    constexpr double speed = 0.5; // metres per frame
    constexpr int tries = 100;
    constexpr std::array<std::array<int, 2>, 4> steps{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    const auto columns = static_cast<int>(ground.columns()), rows = static_cast<int>(ground.rows());
    const auto point = [&](int column, int row) -> Eigen::Vector3d {
        if (column < 0 || row < 0 || column >= columns || row >= rows)
            return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
        return ground.point(static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row)) +
               height * Eigen::Vector3d::UnitZ();
    };
    int column = 0, row = 0;
    for (int k = 0; k < tries && (k == 0 || !point(column, row).allFinite()); ++k)
        column = static_cast<int>(dice.next() * columns), row = static_cast<int>(dice.next() * rows);
    Keyed path;
    double time = 0;
    auto heading = static_cast<std::size_t>(dice.next() * 4);
    for (int turns = 0; turns < 4 && (path.keys.size() < 2 || time < frames);) {
        const Eigen::Vector3d from = point(column, row),
                              to = point(column + steps[heading][0], row + steps[heading][1]);
        if (!to.allFinite()) {
            heading = (heading + 1) % 4, ++turns;
            continue;
        }
        turns = 0;
        const Eigen::Vector3d way = to - from;
        const Eigen::Quaterniond forward(
            Eigen::AngleAxisd(std::atan2(way.y(), way.x()), Eigen::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(-std::atan2(way.z(), std::hypot(way.x(), way.y())), Eigen::Vector3d::UnitY()));
        if (path.keys.empty()) path.keys.push_back({0, from, forward});
        time += way.norm() / speed;
        path.keys.push_back({time, to, forward});
        column += steps[heading][0], row += steps[heading][1];
        if (dice.next() < 0.2) heading = (heading + (dice.next() < 0.5 ? 1 : 3)) % 4;
    }
    if (path.keys.empty()) path.keys.push_back({0, point(column, row), Eigen::Quaterniond::Identity()});
    return path;
}

} // namespace

void make_campus_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const GeometryId campus =
        add_environment(scene, options, "campus", "octomap", "octomap/fr_campus.bt",
                        {{"building", {{"rooms", 34}, {"resolution", 0.2}, {"seed", options.seed}}}});
    scene.add_body({.name = "campus", .geometry = campus, .is_static = true});
    std::vector<GeometryId> kinds = add_meshes_of_a_metre(scene);
    kinds.push_back(scene.add("sphere", Sphere{0.5})), kinds.push_back(scene.add("box", Box{{0.4, 0.7, 1}}));
    kinds.push_back(scene.add("capsule", Capsule{0.3, 1.2}));
    const GeometryData& map = scene.geometries()[index(campus)].data;
    add_bodies_above(scene, surface_points(map), bounds_of(map), kinds, *options.bodies, options.seed);
}

void make_st_helens_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const GeometryId mountain =
        add_environment(scene, options, "mountain", "terrain", "terrain/SainteHelens.dem",
                        {{"hills", {{"cells", 389}, {"spacing", 30}, {"height", 1861}, {"seed", options.seed}}}});
    scene.add_body({.name = "mountain", .geometry = mountain, .is_static = true});
    const auto& ground = std::get<Terrain>(scene.geometries()[index(mountain)].data);
    const std::vector<Eigen::Vector3d> points = surface_points(ground);
    const GeometryId car = scene.add("car", Box{{2.2, 0.9, 0.7}}), lorry = scene.add("lorry", Box{{5, 1.2, 1.6}}),
                     drone = add_drone(scene);
    Aabb air = bounds_of(ground);
    air.max.z() += 100;
    for (int i = 0; i < *options.bodies; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(options.seed, static_cast<std::uint64_t>(i));
        BodyInit body;
        if (i % 2 == 0) {
            const bool small = i % 4 == 0;
            body.geometry = small ? car : lorry;
            body.motion = route(ground, small ? 0.8 : 1.7, std::max(600, std::min(*options.frames, 1'000'000)), dice);
            body.pose = pose_at(body.motion, body.pose, 0);
        } else {
            body.geometry = drone;
            const Eigen::Vector3d at = points[static_cast<std::size_t>(dice.next() * double(points.size()))];
            const Eigen::Vector3d above(0, 0, dice.between(0, 20));
            body.pose = placed((at + above).cwiseMax(air.min).cwiseMin(air.max), dice.rotation());
            body.motion = Drift{.velocity = dice.within({1, 1, 0.2}), .spin = 0.05 * dice.direction(), .walls = air};
        }
        body.name = fmt::format("{}-{}", scene.geometries()[index(body.geometry)].name, i);
        scene.add_body(std::move(body));
    }
}

void make_chunks_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    constexpr int whole = 128 * 128 + 2000; // bodies of the world that the scene imitates
    constexpr double side = 16;             // of a chunk, metres
    const int bodies = *options.bodies, least_balls = static_cast<int>(bodies * std::int64_t{2000} / whole);
    const auto across = static_cast<int>(std::sqrt(double(bodies - least_balls)));
    scene.reserve(static_cast<std::size_t>(bodies));
    for (int i = 0; i < across * across; ++i) {
        const std::string name = fmt::format("chunk {} {}", i % across, i / across);
        const GeometryId chunk = add_geometry(scene, name,
                                              {{"mesh",
                                                {{"generate",
                                                  {{"kind", "terrain"},
                                                   {"size", side},
                                                   {"height", 2},
                                                   {"cells", 17},
                                                   {"seed", options.seed + static_cast<std::uint64_t>(i)}}}}}});
        scene.add_body({.geometry = chunk,
                        .pose = placed({(i % across + 0.5) * side, (i / across + 0.5) * side, 0}),
                        .is_static = true});
    }
    const GeometryId ball = scene.add("ball", Sphere{0.5});
    const Aabb room{{0, 0, -1}, {across * side, across * side, 3}};
    for (int i = across * across; i < bodies; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(options.seed, static_cast<std::uint64_t>(i));
        scene.add_body(
            {.geometry = ball,
             .pose = placed(room.centre() + dice.within(room.half_extent())),
             .motion = Drift{.velocity = dice.within({0.2, 0.2, 0.1}), .spin = {0.05, 0, 0}, .walls = room}});
    }
}

void make_swarm_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const int bodies = *options.bodies, every = 100; // one in `every` bodies moves
    const double side = 2.5 * std::cbrt(double(bodies));
    scene.reserve(static_cast<std::size_t>(bodies));
    const GeometryId ball = scene.add("ball", Sphere{0.5});
    const Aabb room{{0, 0, 0}, {side, side, side}};
    for (int i = 0; i < bodies; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(options.seed, static_cast<std::uint64_t>(i));
        BodyInit body{.geometry = ball, .pose = placed(room.centre() + dice.within(room.half_extent()))};
        if (i % every == 0)
            body.motion = Drift{.velocity = dice.within({0.1, 0.1, 0.1}), .spin = {0, 0, 0}, .walls = room};
        else
            body.is_static = true;
        scene.add_body(std::move(body));
    }
}

} // namespace oncollide
