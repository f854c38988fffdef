// Terrains and maps in cooked files, compared with the same grids in memory.
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

#include "pipeline/models/cooked_scenes.hpp"

namespace oncollide::cooked_scenes {
namespace {

/// A terrain or a map, and the functions that cook and open it.
struct Grid {
    std::string name;
    GeometryData data;

    GeometryData cooked(const TemporaryFolder& folder) const
    {
        const fs::path file = folder.path() / (name + ".cooked");
        if (const auto* terrain = std::get_if<Terrain>(&data)) return cook_terrain(*terrain, file), load_terrain(file);
        return cook_map(std::get<OccupancyMap>(data), file), load_octomap(file);
    }
};

/// Heights at 1, 2, 4 and 8 bytes, with holes, with an error, with a diagonal per cell; of one chunk, with a last
/// column in a separate chunk, of many chunks. Maps of one chunk and of many.
std::vector<Grid> grids()
{
    std::vector<Grid> all;
    const auto heights = [](std::uint32_t columns, std::uint32_t rows, double step) {
        std::vector<double> out;
        for (std::uint32_t r = 0; r < rows; ++r)
            for (std::uint32_t c = 0; c < columns; ++c) {
                const double h = 2 * std::sin(c * 0.11) * std::cos(r * 0.07) + 0.3 * u01(3, r, c);
                out.push_back(step > 0 ? step * std::round(h / step) : h);
            }
        return out;
    };
    const auto add = [&](const char* name, TerrainGrid grid, double step, double holes = 0) {
        std::vector<double> of = heights(grid.columns, grid.rows, step);
        for (std::size_t i = 0; i < of.size(); ++i)
            if (u01(4, i, 0) < holes || (holes > 0 && i % grid.columns < 70)) of[i] = NAN;
        if (holes > 0) grid.no_data = NAN;
        grid.spacing = {0.1, 0.125}, grid.origin = {-6.5, -5.25, 0.5};
        all.push_back({name, make_terrain(name, grid, of)});
    };
    add("least", {.columns = 2, .rows = 2}, 0);
    add("one chunk", {.columns = 40, .rows = 64}, 0.125);
    add("a column more", {.columns = 129, .rows = 65}, 0.03125);
    add("1 byte", {.columns = 150, .rows = 90, .bytes = 1}, 0);
    add("2 bytes", {.columns = 150, .rows = 90}, 0x1p-9);
    add("4 bytes", {.columns = 150, .rows = 90, .bytes = 4}, 0);
    add("8 bytes with holes", {.columns = 150, .rows = 90, .bytes = 8}, 0, 0.01);
    add("2 bytes with holes", {.columns = 150, .rows = 90}, 0x1p-8, 0.01);
    TerrainGrid mixed{.columns = 150, .rows = 90, .error = 0.01};
    for (std::uint64_t i = 0; i < 149 * 89; ++i) mixed.falling.push_back(u01(9, i, 0) < 0.5);
    add("diagonals", mixed, 0);
    all.push_back({"rooms", make_building_map(1, 0.25, 3)});
    all.push_back({"building", make_building_map(4, 0.1, 3)});
    const TemporaryFolder folder;
    save_octomap(make_building_map(2, 0.125, 4), folder.path() / "map.bt");
    all.push_back({"unknown", load_octomap(folder.path() / "map.bt", {.unknown_is_occupied = true})});
    return all;
}

TEST(Cooked, GridsGiveTheSameHeightsAndCells)
{
    const TemporaryFolder folder;
    for (const Grid& grid : grids()) {
        SCOPED_TRACE(grid.name);
        const GeometryData cooked = grid.cooked(folder);
        EXPECT_NO_THROW(check_cooked(folder.path() / (grid.name + ".cooked")));
        EXPECT_EQ(bounds_of(cooked).min, bounds_of(grid.data).min);
        EXPECT_EQ(bounds_of(cooked).max, bounds_of(grid.data).max);
        if (const auto* a = std::get_if<Terrain>(&grid.data)) {
            const auto& b = std::get<Terrain>(cooked);
            const Mesh of_a = mesh_of(*a), of_b = mesh_of(b);
            EXPECT_EQ(of_a.vertices, of_b.vertices);
            EXPECT_EQ(of_a.triangles, of_b.triangles);
            EXPECT_EQ(a->error(), b.error());
            EXPECT_EQ(a->bytes_per_height(), b.bytes_per_height());
            continue;
        }
        const auto leaves = [](const OccupancyMap& map) {
            std::vector<std::pair<MapCell, CellState>> all;
            MapAccess::cells(map).each_leaf([&](const MapCell& cube, CellState state) {
                all.push_back({cube, state});
            });
            return all;
        };
        const auto& a = std::get<OccupancyMap>(grid.data);
        auto b = std::get<OccupancyMap>(cooked);
        EXPECT_EQ(leaves(a), leaves(b));
        EXPECT_EQ(a.count(), b.count());
        b.set(a.bounds(), CellState::occupied); // reads it into memory
        EXPECT_EQ(MapAccess::cells(b).chunks(), nullptr);
        EXPECT_EQ(leaves(a), leaves(std::get<OccupancyMap>(cooked)));
    }
}

/// Grids below bodies of every kind, including other grids, which rotate and fall through them.
Scene over_grid(const GeometryData& grid)
{
    Scene scene;
    const Aabb bounds = bounds_of(grid);
    const double size = std::min(1.0, bounds.diagonal() / 4);
    const GeometryId ground = scene.add("ground", grid);
    const GeometryId bodies[] = {scene.add("ball", Shape(Sphere{0.3 * size})),
                                 scene.add("knot", make_torus_knot_mesh(2, 3, size, 0.4 * size, 0.2 * size, 600)),
                                 scene.add("crate", Shape(Box{{0.4 * size, 0.2 * size, 0.3 * size}})),
                                 scene.add("pipe", Shape(Cylinder{0.2 * size, size})),
                                 scene.add("map", make_building_map(1, 0.25, 8)),
                                 scene.add("terrain", make_hills(40, 30, 0.1, 1, 4)),
                                 ground};
    scene.add_body({.name = "ground", .geometry = ground, .is_static = true});
    for (std::uint64_t i = 0; i < 42; ++i) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        for (int k = 0; k < 3; ++k)
            pose.translation()[k] =
                bounds.min[k] + (1.2 * u01(6, i, std::uint64_t(k)) - 0.1) * (bounds.max[k] - bounds.min[k]);
        Drift drift{.velocity = {0.1 * size, 0, -0.2 * size}, .spin = {0, 0, 0}, .walls = {}};
        if (i % 3) drift.spin = {0.2, 0.1 * double(i % 5), 0.05};
        scene.add_body({.name = fmt::format("body {}", i), .geometry = bodies[i % 7], .pose = pose, .motion = drift});
    }
    return scene;
}

TEST(Cooked, GridsGiveTheSameResults)
{
    const TemporaryFolder folder;
    const std::vector<std::pair<const char*, Settings>> settings{
        {"exact", {.exact = ExactLevel::predicates}},
        {"little memory, threads", {.exact = ExactLevel::predicates, .threads = 3, .resident_budget = 250'000}},
        {"default error", {.coherence = false}},
        {"clearance, error", {.max_error = 0.02, .clearance = 0.1, .resident_budget = 250'000}},
        {"solid", {.exact = ExactLevel::predicates, .mode = Mode::solid, .open_as_surface = true}},
    };
    for (const Grid& grid : grids()) {
        const GeometryData cooked = grid.cooked(folder);
        for (const auto& [name, of] : settings) {
            SCOPED_TRACE(fmt::format("{}, {}", grid.name, name));
            const Played expected = play(over_grid(grid.data), of, 3), played = play(over_grid(cooked), of, 3);
            expect_same(expected, played);
            EXPECT_TRUE(played.faults.empty());
            EXPECT_GT(played.frames[0].size(), 10u);
        }
        Scene a = over_grid(grid.data), b = over_grid(cooked);
        Pipeline of_a(a, {.exact = ExactLevel::predicates}), of_b(b, {.exact = ExactLevel::predicates});
        of_a.step(a), of_b.step(b);
        for (std::uint32_t i = 1; i < 20; ++i) {
            const auto found_a = of_a.world().pairs().contacts(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i})),
                       found_b = of_b.world().pairs().contacts(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}));
            ASSERT_EQ(found_a.size(), found_b.size());
            for (std::size_t k = 0; k < found_a.size(); ++k)
                EXPECT_TRUE(found_a[k].a == found_b[k].a && found_a[k].b == found_b[k].b);
            EXPECT_EQ(of_a.world()
                          .pairs()
                          .distance(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i}), {.tolerance = 1e-3})
                          .lower,
                      of_b.world()
                          .pairs()
                          .distance(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}), {.tolerance = 1e-3})
                          .lower);
        }
    }
}

TEST(Cooked, GridsAreReadWherePairsComeNear)
{
    const TemporaryFolder folder;
    const Settings settings{.exact = ExactLevel::predicates};
    const std::vector<Grid> large{{"hills", make_hills(1000, 800, 0.1, 4, 3)},
                                  {"building", make_building_map(12, 0.1, 3)}};
    for (const Grid& grid : large) {
        SCOPED_TRACE(grid.name);
        const GeometryData cooked = grid.cooked(folder);
        const fs::path file = folder.path() / (grid.name + ".cooked");
        const Eigen::Vector3d at = bounds_of(grid.data).centre();
        const Played played = play(one_body_on(cooked, at), settings, 1);
        expect_same(play(one_body_on(grid.data, at), settings, 1), played);
        EXPECT_EQ(played.frames[0].at(0).verdict, Verdict::colliding);
        EXPECT_LT(played.bytes, fs::file_size(file) / 4);

        Scene many = one_body_on(cooked, at);
        for (std::uint64_t i = 0; i < 60; ++i) {
            Eigen::Vector3d place = bounds_of(grid.data).min;
            for (int k = 0; k < 3; ++k)
                place[k] += u01(7, i, std::uint64_t(k)) * 2 * bounds_of(grid.data).half_extent()[k];
            many.add_body({.name = fmt::format("crate {}", i),
                           .geometry = GeometryId{1},
                           .pose = Eigen::Isometry3d(Eigen::Translation3d(place))});
        }
        Settings little = settings;
        little.resident_budget = 150'000;
        const Played all = play(many, settings, 2), some = play(many, little, 2);
        expect_same(all, some);
        EXPECT_TRUE(some.faults.empty());
        EXPECT_GT(all.bytes, 3 * little.resident_budget / 2);
        EXPECT_LT(some.bytes, all.bytes - little.resident_budget / 2);

        const std::string bytes = read(file);
        const auto header = test::value_at<CookedHeader>(bytes, 0);
        ASSERT_GT(header.chunks, 20u);
        std::size_t undecided = 0, decided = 0;
        for (std::uint32_t c = 0; c < header.chunks; ++c) {
            std::string damaged = bytes;
            damaged[test::chunk_at(bytes, c).offset + 100] ^= 1;
            folder.write(grid.name + ".cooked", damaged);
            const GeometryData opened = std::holds_alternative<Terrain>(cooked) ? GeometryData(load_terrain(file))
                                                                                : GeometryData(load_octomap(file));
            const Played now = play(one_body_on(opened, at), settings, 1);
            const bool lost = now.frames[0].at(0).verdict == Verdict::undecided;
            ++(lost ? undecided : decided);
            EXPECT_EQ(now.faults.size(), std::size_t(lost));
            if (lost) {
                EXPECT_NE(now.faults[0].find(fmt::format("chunk {} of", c)), std::string::npos) << now.faults[0];
                test::expect_error(
                    ErrorKind::bad_data,
                    [&] {
                        World world({.mode = Mode::solid});
                        world.bodies().add(
                            {.model = world.models().add(std::make_shared<const Geometry>(Geometry{"g", opened, {}}))});
                    },
                    "checksum");
            }
        }
        EXPECT_GT(undecided, 0u);
        EXPECT_GT(decided, undecided);
    }
}

} // namespace
} // namespace oncollide::cooked_scenes
