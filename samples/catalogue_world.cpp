// Large static environments with a few moving bodies: a city, and a scanned building.
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <oncollide/samples/catalogue_scenes.hpp>

namespace oncollide {

namespace {

// The city: square blocks of four lots with streets between them, all in metres; z is up.
//
//      street |  lot  lot  | street       crossings are at multiples of `pitch`
//             |  lot  lot  |
constexpr double pitch = 60, street = 16, lot = (pitch - street) / 2;

constexpr std::uint32_t scenery = 1, traffic = 2, drones = 4; // layers

const double half_root = std::sqrt(0.5);

/// Rotation by `quarters` right angles about z.
Eigen::Quaterniond facing(int quarters)
{
    const std::array<Eigen::Quaterniond, 4> turns{
        Eigen::Quaterniond{1, 0, 0, 0}, {half_root, 0, 0, half_root}, {0, 0, 0, 1}, {half_root, 0, 0, -half_root}};
    return turns[static_cast<std::size_t>(quarters & 3)];
}

/// Ten kinds of buildings; most fit their lot, the last two extend into the street.
std::vector<GeometryId> add_building_kinds(SceneBuilder& scene)
{
    const auto generated = [&](const char* name, Json generator, double diagonal) {
        return add_geometry(
            scene, name,
            {{"mesh", {{"generate", std::move(generator)}, {"fit_diagonal", diagonal}, {"centre", true}}}});
    };
    return {
        scene.add("house", Box{{6, 7, 4}}),
        scene.add("block", Box{{8.5, 8.5, 12}}),
        scene.add("slab", Box{{5, 9, 25}}),
        scene.add("tower", Box{{7, 7, 60}}),
        scene.add("tank", Cylinder{.radius = 7, .length = 14}),
        scene.add("chimney", Cylinder{.radius = 2, .length = 50}),
        generated("dome", {{"kind", "sphere"}, {"radius", 8}, {"triangles", 2048}}, 28),
        generated("arena", {{"kind", "torus"}, {"major", 7}, {"minor", 2}, {"triangles", 1800}}, 26),
        scene.add("hall", Box{{12.5, 8, 5}}),
        generated("works",
                  {{"kind", "gear"},
                   {"teeth", 12},
                   {"root_radius", 9},
                   {"tip_radius", 12},
                   {"thickness", 9},
                   {"bore_radius", 4}},
                  36),
    };
}

void add_buildings(SceneBuilder& scene, int count, int blocks, std::uint64_t seed)
{
    const std::vector<GeometryId> kinds = add_building_kinds(scene);
    for (int i = 0; i < count; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(seed, static_cast<std::uint64_t>(i));
        const int block = i / 4, corner = i % 4;
        const auto kind = kinds[static_cast<std::size_t>(dice.next() * double(kinds.size()))];
        const int quarters = static_cast<int>(dice.next() * 4);
        const Eigen::Vector3d shift = dice.within({1, 1, 0});
        const double x = block % blocks * pitch + street / 2 + (corner % 2 + 0.5) * lot;
        const double y = block / blocks * pitch + street / 2 + (corner / 2 + 0.5) * lot;
        const Aabb bounds = bounds_of(scene.geometries()[index(kind)]);
        scene.add_body({.name = fmt::format("{}-{}", scene.geometries()[index(kind)].name, i),
                        .geometry = kind,
                        .pose = placed(Eigen::Vector3d(x, y, -bounds.min.z()) + shift, facing(quarters)),
                        .is_static = true,
                        .layer = scenery});
    }
}

/// From crossing to crossing, straight on, left or right, never out of the city.
Keyed route(int blocks, int frames, double height, Dice& dice)
{
    constexpr double speed = 0.5, corner = 5; // metres per frame, metres before and after a crossing
    constexpr std::array<std::array<int, 2>, 4> steps{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    const auto inside = [&](int x, int y) { return x >= 0 && y >= 0 && x <= blocks && y <= blocks; };
    int x = static_cast<int>(dice.next() * (blocks + 1)), y = static_cast<int>(dice.next() * (blocks + 1));
    int heading = x < blocks ? 0 : 2;
    Keyed path;
    const auto add_key = [&](double time, double ahead) {
        const auto& step = steps[static_cast<std::size_t>(heading)];
        path.keys.push_back(
            {time, {x * pitch + ahead * step[0], y * pitch + ahead * step[1], height}, facing(heading)});
    };
    add_key(0, corner);
    for (double time = (pitch - 2 * corner) / speed; time < frames + 2 * pitch / speed; time += pitch / speed) {
        x += steps[static_cast<std::size_t>(heading)][0], y += steps[static_cast<std::size_t>(heading)][1];
        add_key(time, -corner);
        const int turn = static_cast<int>(dice.next() * 3) - 1;
        for (const int way : {turn, 0, 1, -1}) {
            const auto& step = steps[static_cast<std::size_t>((heading + way) & 3)];
            if (!inside(x + step[0], y + step[1])) continue;
            heading = (heading + way) & 3;
            break;
        }
        add_key(time + 2 * corner / speed, corner);
    }
    return path;
}

struct MoverKinds {
    GeometryId car, bus, roller, drone;
};

MoverKinds add_mover_kinds(SceneBuilder& scene)
{
    return {
        add_geometry(scene, "car", {{"mesh", {{"generate", {{"kind", "box"}, {"half", {2.2, 0.9, 0.7}}}}}}}),
        scene.add("bus", Capsule{.radius = 1.4, .length = 8}),
        add_geometry(scene, "roller",
                     {{"mesh",
                       {{"generate",
                         {{"kind", "gear"},
                          {"teeth", 16},
                          {"root_radius", 1.6},
                          {"tip_radius", 2},
                          {"thickness", 1.2},
                          {"bore_radius", 0.5}}}}}}),
        add_drone(scene),
    };
}

/// Buses drive back and forth along a street, rollers across them.
Drift shuttle(int blocks, int street_number, bool along_x, double height, double speed)
{
    const double line = street_number * pitch, end = blocks * pitch;
    Drift drift;
    drift.velocity = along_x ? Eigen::Vector3d(speed, 0, 0) : Eigen::Vector3d(0, speed, 0);
    drift.walls.min = along_x ? Eigen::Vector3d(0, line, height) : Eigen::Vector3d(line, 0, height);
    drift.walls.max = along_x ? Eigen::Vector3d(end, line, height) : Eigen::Vector3d(line, end, height);
    return drift;
}

void add_movers(SceneBuilder& scene, int count, int blocks, const CatalogueOptions& options)
{
    const MoverKinds kinds = add_mover_kinds(scene);
    const double end = blocks * pitch;
    const Eigen::Quaterniond lying_x(half_root, 0, half_root, 0), standing(half_root, half_root, 0, 0);
    for (int i = 0; i < count; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(options.seed + 1, static_cast<std::uint64_t>(i));
        const int line = static_cast<int>(dice.next() * (blocks + 1));
        const double along = dice.between(0, end), speed = dice.between(0.3, 0.6);
        BodyInit body;
        body.layer = traffic, body.mask = scenery | traffic;
        if (i % 4 == 0) {
            body.geometry = kinds.car;
            body.motion = route(blocks, std::max(600, std::min(*options.frames, 1'000'000)), 1, dice);
            body.pose = pose_at(body.motion, body.pose, 0);
        } else if (i % 4 == 1) {
            body.geometry = kinds.bus;
            body.pose = placed({along, line * pitch, 1.8}, lying_x);
            body.motion = shuttle(blocks, line, true, 1.8, speed);
        } else if (i % 4 == 2) {
            Drift drift = shuttle(blocks, line, false, 2.2, 0.5 * speed);
            drift.spin = {0, 0, 0.05};
            body.geometry = kinds.roller;
            body.pose = placed({line * pitch, along, 2.2}, standing);
            body.motion = drift;
        } else {
            Drift drift{.velocity = dice.within({0.5, 0.5, 0.1}), .spin = 0.05 * dice.direction(), .walls = {}};
            drift.walls.min = {0, 0, 4}, drift.walls.max = {end, end, 40};
            body.geometry = kinds.drone;
            body.layer = drones, body.mask = scenery | drones;
            const Eigen::Quaterniond rotation = dice.rotation(); // drawn first: compilers order arguments differently
            body.pose = placed({dice.between(0, end), dice.between(0, end), dice.between(4, 40)}, rotation);
            body.motion = drift;
        }
        body.name = fmt::format("{}-{}", scene.geometries()[index(body.geometry)].name, i);
        scene.add_body(std::move(body));
    }
}

} // namespace

void make_city_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const int bodies = *options.bodies, movers = std::min(20, bodies - bodies / 2);
    const int buildings = std::max(0, bodies - movers - 1);
    int blocks = 1;
    while (4 * blocks * blocks < buildings) ++blocks;
    const double end = blocks * pitch;
    if (bodies > movers) {
        const GeometryId terrain = add_geometry(
            scene, "terrain",
            {{"mesh",
              {{"generate",
                {{"kind", "terrain"}, {"size", end + 200}, {"height", 6}, {"cells", 160}, {"seed", options.seed}}}}}});
        // The ground oscillates around z = 0; its highest hills touch the traffic.
        scene.add_body({.name = "terrain",
                        .geometry = terrain,
                        .pose = placed({end / 2, end / 2, -3.2}),
                        .is_static = true,
                        .layer = scenery});
    }
    add_buildings(scene, buildings, blocks, options.seed);
    add_movers(scene, movers, blocks, options);
}

void make_octomap_scene(SceneBuilder& scene, const CatalogueOptions& options)
{
    const std::filesystem::path file = options.data / "octomap" / "geb079.bt";
    std::error_code ignored;
    Json map = {{"building", {{"rooms", 4}, {"resolution", 0.1}, {"seed", options.seed}}}};
    if (!options.data.empty() && std::filesystem::is_regular_file(file, ignored))
        map = {{"file", file.string()}};
    else
        scene.warnings().push_back(
            "building: no data folder with octomap/geb079.bt; uses a generated building instead");
    const GeometryId building = add_geometry(scene, "building", {{"octomap", std::move(map)}});
    scene.add_body({.name = "building", .geometry = building, .is_static = true});

    const GeometryId kinds[] = {
        scene.add("ball", Sphere{0.3}),
        add_knot(scene, "knot", 1, 1500),
        scene.add("rod", Capsule{.radius = 0.1, .length = 0.8}),
        add_geometry(
            scene, "ring",
            {{"mesh", {{"generate", {{"kind", "torus"}, {"major", 0.4}, {"minor", 0.1}, {"triangles", 600}}}}}}),
    };
    const Aabb walls = bounds_of(scene.geometries()[index(building)]);
    for (int i = 0; i < *options.bodies; ++i) {
        if (scene.skip_body()) continue;
        Dice dice(options.seed, static_cast<std::uint64_t>(i));
        const GeometryId kind = kinds[i % 4];
        const Eigen::Vector3d position = walls.centre() + dice.within(walls.half_extent());
        const Eigen::Quaterniond rotation = dice.rotation();
        Drift drift{.velocity = dice.within({0.08, 0.08, 0.02}), .spin = 0.03 * dice.direction(), .walls = walls};
        scene.add_body({.name = fmt::format("{}-{}", scene.geometries()[index(kind)].name, i),
                        .geometry = kind,
                        .pose = placed(position, rotation),
                        .motion = drift});
    }
}

} // namespace oncollide
