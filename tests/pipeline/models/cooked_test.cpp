// Meshes in cooked files, compared with the meshes that they were cooked from.
#include <chrono>
#include <filesystem>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/broadphase/bounds/pose_bounds.hpp>
#include <oncollide/narrowphase/cook_mesh.hpp>
#include <oncollide/pipeline/mesh_queries.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/cooked/cooked_map.hpp>
#include <oncollide/scenes/cooked/cooked_mesh.hpp>
#include <oncollide/scenes/cooked/cooked_terrain.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

#include "cooked_bytes.hpp"
#include "random_pose.hpp"
#include "scenes/test_files.hpp"

namespace oncollide {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

std::string read(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The mesh has vertices that no triangle uses, duplicate triangles, and triangles without area.
Mesh odd_mesh(std::size_t triangles)
{
    std::vector<Eigen::Vector3d> vertices;
    std::vector<Triangle> all;
    for (std::uint64_t i = 0; i < triangles; ++i) {
        const Eigen::Vector3d at(4 * u01(5, i, 0), 4 * u01(5, i, 1), u01(5, i, 2));
        for (std::uint64_t k = 0; k < 4; ++k)
            vertices.push_back(at +
                               0.1 * Eigen::Vector3d(u01(6, i, 3 * k), u01(6, i, 3 * k + 1), u01(6, i, 3 * k + 2)));
        const auto v = static_cast<std::uint32_t>(4 * i);
        all.push_back({v, v + 1, v + 2});
        if (i % 7 == 0) all.push_back({v + 1, v + 2, v});
        if (i % 11 == 0) all.push_back({v, v, v + 1});
    }
    return make_mesh("odd", std::move(vertices), std::move(all));
}

Mesh in_floats(const Mesh& mesh)
{
    std::vector<Eigen::Vector3d> vertices;
    for (const Eigen::Vector3d& v : mesh.vertices) vertices.push_back(v.cast<float>().cast<double>());
    return make_mesh("floats", std::move(vertices), mesh.triangles);
}

struct Sample {
    const char* name;
    Mesh mesh;
};

/// / From one triangle to more than the size from which trees use grids (the terrain), of one chunk and of many.
const std::vector<Sample>& samples()
{
    static const std::vector<Sample> all{
        {"one triangle", make_mesh("one", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}}, {{0, 1, 2}})},
        {"box", make_box_mesh({0.5, 0.4, 0.3})},
        {"odd", odd_mesh(400)},
        {"many odd", odd_mesh(12'000)},
        {"knot", make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.1, 30'000)},
        {"terrain", in_floats(make_terrain_mesh(20, 2, 300, 3))},
    };
    return all;
}

fs::path cooked(const TemporaryFolder& folder, const Mesh& mesh, const std::string& name = "mesh")
{
    const fs::path file = folder.path() / (name + ".cooked");
    cook_mesh(mesh, file);
    return file;
}

std::shared_ptr<const CookedMesh> opened(const fs::path& file)
{
    return std::make_shared<const CookedMesh>(file);
}

TEST(Cooked, GivesTheMeshBackBitForBit)
{
    const TemporaryFolder folder;
    for (const Sample& sample : samples()) {
        SCOPED_TRACE(sample.name);
        const fs::path file = cooked(folder, sample.mesh);
        const auto mesh = opened(file);
        const Mesh back = mesh->whole();
        ASSERT_EQ(back.vertices.size(), sample.mesh.vertices.size());
        for (std::size_t v = 0; v < back.vertices.size(); ++v)
            ASSERT_EQ(std::memcmp(back.vertices[v].data(), sample.mesh.vertices[v].data(), 24), 0) << v;
        EXPECT_EQ(back.triangles, sample.mesh.triangles);
        EXPECT_EQ(mesh->closed(), std::optional(is_closed(sample.mesh)));
        EXPECT_EQ(check_cooked(file).chunks, mesh->chunks());
        const double bytes = double(fs::file_size(file)) / double(back.triangles.size());
        EXPECT_TRUE(bytes < 40 || back.triangles.size() < 1000 || back.vertices.size() > back.triangles.size())
            << bytes;
        cook_mesh(back, folder.path() / "again.cooked");
        EXPECT_TRUE(read(file) == read(folder.path() / "again.cooked"));
    }
}

/// Bodies of the sample's mesh and a few others, which move through each other and apart.
Scene scene_of(const GeometryData& mesh, double size, bool turning)
{
    Scene scene;
    const GeometryId one = scene.add("one", mesh);
    const GeometryId ball = scene.add("ball", Shape(Sphere{0.2 * size})),
                     crate = scene.add("crate", Shape(Box{{0.1 * size, 0.2 * size, 0.1 * size}}));
    const GeometryId knot = scene.add("knot", make_torus_knot_mesh(2, 3, 0.2 * size, 0.1 * size, 0.05 * size, 600));
    scene.add_body({.name = "ground", .geometry = one, .is_static = true});
    std::uint64_t i = 0;
    for (const GeometryId geometry : {one, ball, crate, knot, ball, knot, crate, one}) {
        ++i;
        Drift drift;
        drift.velocity =
            size * (Eigen::Vector3d(u01(1, i, 0), u01(1, i, 1), u01(1, i, 2)) - Eigen::Vector3d::Constant(0.5)) * 0.3;
        if (turning) drift.spin = {0.3, 0.2 * double(i % 3), 0.1};
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() =
            size * (Eigen::Vector3d(u01(2, i, 0), u01(2, i, 1), u01(2, i, 2)) - Eigen::Vector3d::Constant(0.5));
        scene.add_body({.name = fmt::format("body {}", i), .geometry = geometry, .pose = pose, .motion = drift});
    }
    return scene;
}

struct Played {
    std::vector<std::vector<PairResult>> frames;
    std::uint64_t hash = 0;
    std::vector<std::string> faults;
    std::size_t bytes = 0;
};

Played play(Scene scene, const Settings& settings, int frames = 4)
{
    Played played;
    Pipeline pipeline(scene, settings);
    Mover mover;
    for (int frame = 0; frame < frames; ++frame) {
        mover.move(scene, frame);
        const FrameView view = pipeline.step(scene);
        played.frames.emplace_back(view.pairs.begin(), view.pairs.end());
        played.bytes = std::max(played.bytes, view.trees.bytes);
    }
    played.hash = pipeline.hash(), played.faults = pipeline.world().inspect().file_faults;
    return played;
}

void expect_same(const Played& a, const Played& b)
{
    EXPECT_EQ(a.hash, b.hash);
    ASSERT_EQ(a.frames.size(), b.frames.size());
    for (std::size_t f = 0; f < a.frames.size(); ++f) {
        ASSERT_EQ(a.frames[f].size(), b.frames[f].size()) << "frame " << f;
        for (std::size_t i = 0; i < a.frames[f].size(); ++i) {
            const PairResult &x = a.frames[f][i], &y = b.frames[f][i];
            EXPECT_TRUE(index(x.a) == index(y.a) && index(x.b) == index(y.b) && x.verdict == y.verdict &&
                        x.kind == y.kind && x.bound == y.bound)
                << "frame " << f << ", pair " << x.a.slot << " " << x.b.slot << ": " << int(x.verdict) << " " << x.bound
                << ", cooked " << int(y.verdict) << " " << y.bound;
        }
    }
}

TEST(Cooked, GivesTheSameResultsInEveryMode)
{
    const TemporaryFolder folder;
    const std::vector<std::pair<const char*, Settings>> settings{
        {"exact", {.exact = ExactLevel::predicates}},
        {"threads", {.exact = ExactLevel::predicates, .threads = 3}},
        {"without coherence", {.exact = ExactLevel::predicates, .coherence = false}},
        {"default error", {}},
        {"error", {.max_error = 0.05}},
        {"clearance", {.clearance = 0.1, .exact = ExactLevel::predicates}},
        {"clearance, error", {.max_error = 0.02, .clearance = 0.1}},
        {"spheres", {.depth = 4}},
        {"kinds", {.exact = ExactLevel::predicates, .contact_kinds = true}},
        {"solid", {.exact = ExactLevel::predicates, .mode = Mode::solid, .open_as_surface = true}},
        {"budget", {.exact = ExactLevel::predicates, .memory_budget = 1'000'000}},
        {"old trees go", {.exact = ExactLevel::predicates, .age_limit = 1}},
    };
    for (const Sample& sample : samples()) {
        const auto mesh = opened(cooked(folder, sample.mesh));
        const double size = sample.mesh.bounds.diagonal() / 2;
        for (const auto& [name, of] : settings) {
            if (std::string(name) == "spheres" && sample.mesh.triangles.size() > 100'000)
                continue; // slow, and no different
            SCOPED_TRACE(fmt::format("{}, {}", sample.name, name));
            const bool turning = sample.mesh.triangles.size() < 100'000;
            const Played played = play(scene_of(mesh, size, turning), of);
            expect_same(play(scene_of(sample.mesh, size, turning), of), played);
            EXPECT_TRUE(played.faults.empty());
        }
    }
}

TEST(Cooked, GivesTheSameContactsAndDistances)
{
    const TemporaryFolder folder;
    for (const Sample& sample : samples()) {
        SCOPED_TRACE(sample.name);
        const auto mesh = opened(cooked(folder, sample.mesh));
        const double size = sample.mesh.bounds.diagonal() / 2;
        Settings settings{.exact = ExactLevel::predicates};
        Scene a = scene_of(sample.mesh, size, true), b = scene_of(mesh, size, true);
        Pipeline of_a(a, settings), of_b(b, settings);
        of_a.step(a), of_b.step(b);
        std::size_t contacts = 0;
        for (std::uint32_t i = 1; i < a.size(); ++i) {
            const auto found_a = of_a.world().contacts(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i})),
                       found_b = of_b.world().contacts(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}));
            ASSERT_EQ(found_a.size(), found_b.size());
            contacts += found_a.size();
            for (std::size_t k = 0; k < found_a.size(); ++k)
                EXPECT_TRUE(found_a[k].a == found_b[k].a && found_a[k].b == found_b[k].b &&
                            found_a[k].ends == found_b[k].ends && found_a[k].normal_a == found_b[k].normal_a);
            const Distance d = of_a.world().distance(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i}), 1e-3),
                           e = of_b.world().distance(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}), 1e-3);
            EXPECT_EQ(d.lower, e.lower);
            EXPECT_EQ(d.upper, e.upper);
            EXPECT_TRUE(d.a == e.a && d.b == e.b);
        }
        EXPECT_TRUE(contacts > 0 || sample.mesh.triangles.size() < 1000);
    }
}

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
            const auto found_a = of_a.world().contacts(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i})),
                       found_b = of_b.world().contacts(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}));
            ASSERT_EQ(found_a.size(), found_b.size());
            for (std::size_t k = 0; k < found_a.size(); ++k)
                EXPECT_TRUE(found_a[k].a == found_b[k].a && found_a[k].b == found_b[k].b);
            EXPECT_EQ(of_a.world().distance(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i}), 1e-3).lower,
                      of_b.world().distance(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}), 1e-3).lower);
        }
    }
}

/// A small body over one position of the terrain.
Scene one_body_on(const GeometryData& ground, const Eigen::Vector3d& at = {0, 0, 0})
{
    Scene scene;
    scene.add_body({.name = "ground", .geometry = scene.add("ground", ground), .is_static = true});
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = at;
    scene.add_body({.name = "crate", .geometry = scene.add("crate", make_box_mesh({0.2, 0.2, 5})), .pose = pose});
    return scene;
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
                        world.add_body(
                            {.model = world.add(std::make_shared<const Geometry>(Geometry{"g", opened, {}}))});
                    },
                    "checksum");
            }
        }
        EXPECT_GT(undecided, 0u);
        EXPECT_GT(decided, undecided);
    }
}

TEST(Cooked, ReadsWhatPairsComeNear)
{
    const TemporaryFolder folder;
    const Mesh& terrain = samples().back().mesh;
    const fs::path file = cooked(folder, terrain);
    const auto mesh = opened(file);
    ASSERT_GT(mesh->chunks(), 20u);
    const Settings settings{.exact = ExactLevel::predicates};
    const Played of_source = play(one_body_on(terrain), settings, 1), played = play(one_body_on(mesh), settings, 1);
    expect_same(of_source, played);
    EXPECT_EQ(played.frames[0].at(0).verdict, Verdict::colliding);
    EXPECT_LT(played.bytes, fs::file_size(file) / 8);
}

TEST(Cooked, ResultsDoNotDependOnWhatMayBeHeld)
{
    const TemporaryFolder folder;
    const auto mesh = opened(cooked(folder, samples().back().mesh));
    Scene scene = one_body_on(mesh);
    for (std::uint64_t i = 0; i < 30; ++i) {
        Drift drift;
        drift.velocity = {u01(8, i, 0) - 0.5, u01(8, i, 1) - 0.5, 0};
        const Eigen::Translation3d at(18 * u01(7, i, 0) - 9, 18 * u01(7, i, 1) - 9, i % 2 ? 6 : 0);
        scene.add_body({.name = fmt::format("body {}", i),
                        .geometry = GeometryId{1},
                        .pose = Eigen::Isometry3d(at),
                        .motion = drift});
    }
    for (const Settings& settings :
         {Settings{.exact = ExactLevel::predicates}, Settings{.max_error = 0.05, .threads = 3}}) {
        const Played all = play(scene, settings);
        Settings little = settings;
        little.resident_budget = 1'000'000;
        const Played some = play(scene, little);
        expect_same(all, some);
        EXPECT_TRUE(some.faults.empty());
        EXPECT_GT(all.bytes, 2 * little.resident_budget);
        EXPECT_LT(some.bytes, 2 * little.resident_budget); // including the crates' trees
    }
}

TEST(Cooked, APairThatNeedsMoreThanMayBeHeldStaysUndecided)
{
    const TemporaryFolder folder;
    const auto mesh = opened(cooked(folder, samples().back().mesh));
    Scene scene = one_body_on(mesh);
    const Played played = play(scene, {.exact = ExactLevel::predicates, .resident_budget = 10'000});
    EXPECT_EQ(played.frames[0].at(0).verdict, Verdict::undecided);
    ASSERT_EQ(played.faults.size(), 1u);
    EXPECT_NE(played.faults[0].find("10000 bytes"), std::string::npos) << played.faults[0];
}

TEST(Cooked, BoxesOfTurnedBodiesAreThoseOfTheMeshAndNeedItsEndsOnly)
{
    const TemporaryFolder folder;
    const Mesh knot = make_torus_knot_mesh(2, 3, 0.5, 0.2, 0.1, 140'000);
    for (const Mesh* mesh : {&samples().back().mesh, &knot}) {
        const fs::path file = cooked(folder, *mesh);
        const GeometryData of_mesh = *mesh, in_file = opened(file);
        const auto chunks = opened(file)->chunks();
        ASSERT_GT(chunks, 8u);
        PoseBounds a(of_mesh), b(in_file);
        for (std::uint64_t i = 0; i < 40; ++i) {
            const Eigen::Isometry3d pose = random_pose(i, 3), other = random_pose(i + 1000, 3); // an unpredictable
                                                                                                // motion
            a.expect(pose), b.expect(pose);
            EXPECT_EQ(a.box(pose).min, b.box(pose).min);
            EXPECT_EQ(a.box(pose).max, b.box(pose).max);
            const Aabb exact = a.box(other), wide = b.box(other);
            EXPECT_TRUE((wide.min.array() <= exact.min.array()).all() && (wide.max.array() >= exact.max.array()).all());
            if (i == 0 && mesh != &knot) {
                EXPECT_LT(b.bytes(), mesh->vertices.size() * 12 / 2);
            }
        }
        // A chunk that cannot be read makes boxes wider, and never smaller.
        std::string bytes = read(file);
        for (std::uint32_t c = 0; c < chunks; c += 3)
            if (const CookedChunkEntry entry = test::chunk_at(bytes, c); entry.triangles > 0)
                bytes[entry.offset + entry.bytes / 2] ^= 1;
        const GeometryData damaged = opened(folder.write("damaged.cooked", bytes));
        PoseBounds c(damaged);
        std::size_t wider = 0;
        for (std::uint64_t i = 0; i < 20; ++i) {
            const Eigen::Isometry3d pose = random_pose(i, 3);
            c.expect(pose);
            const Aabb exact = a.box(pose), wide = c.box(pose);
            EXPECT_TRUE((wide.min.array() <= exact.min.array()).all() && (wide.max.array() >= exact.max.array()).all());
            wider += wide.min != exact.min || wide.max != exact.max;
        }
        EXPECT_GT(wider, 0u);
        // A box with NaN coordinates has no worse effect.
        test::set_value(bytes, sizeof(CookedHeader) + offsetof(CookedNode, origin), std::nanf(""));
        std::string sealed = test::resealed(bytes);
        sealed.back() ^= 1;
        const GeometryData forged = opened(folder.write("forged.cooked", sealed));
        PoseBounds d(forged);
        for (std::uint64_t i = 0; i < 20; ++i) {
            const Eigen::Isometry3d pose = random_pose(i, 3);
            d.expect(pose);
            const Aabb exact = a.box(pose), wide = d.box(pose);
            EXPECT_TRUE((wide.min.array() <= exact.min.array()).all() && (wide.max.array() >= exact.max.array()).all());
            EXPECT_LT(wide.diagonal(), 4 * mesh->bounds.diagonal());
        }
    }
}

TEST(Cooked, ADamagedChunkCostsThePairsThatNeedIt)
{
    const TemporaryFolder folder;
    const Mesh& terrain = samples().back().mesh;
    const fs::path file = cooked(folder, terrain);
    const std::string bytes = read(file);
    const auto header = test::value_at<CookedHeader>(bytes, 0);
    const Settings settings{.exact = ExactLevel::predicates};
    std::size_t undecided = 0, decided = 0;
    for (std::uint32_t c = 0; c < header.chunks; c += 3) {
        std::string damaged = bytes;
        const auto entry =
            test::value_at<CookedChunkEntry>(bytes, test::table_of(bytes) + c * sizeof(CookedChunkEntry));
        damaged[entry.offset + entry.bytes / 2] ^= 1;
        Scene scene = one_body_on(opened(folder.write("damaged.cooked", damaged)));
        scene.add_body(
            {.name = "other", .geometry = GeometryId{1}, .pose = Eigen::Isometry3d(Eigen::Translation3d(6, 6, 0))});
        const Played played = play(scene, settings, 2);
        ASSERT_EQ(played.frames[0].size(), 2u);
        for (const PairResult& pair : played.frames[1]) ++(pair.verdict == Verdict::undecided ? undecided : decided);
        EXPECT_LE(played.faults.size(), 1u);
        for (const std::string& fault : played.faults)
            EXPECT_NE(fault.find(fmt::format("chunk {} of", c)), std::string::npos) << fault;
        EXPECT_EQ(played.faults.size(), std::size_t(played.frames[0][0].verdict == Verdict::undecided ||
                                                    played.frames[0][1].verdict == Verdict::undecided));
    }
    EXPECT_GT(undecided, 0u);
    EXPECT_GT(decided, undecided);
}

TEST(Cooked, AFileThatIsCutOffWhileItIsOpenIsNoCrash)
{
    const TemporaryFolder folder;
    const fs::path file = cooked(folder, samples().back().mesh);
    const auto mesh = opened(file);
    fs::resize_file(file, fs::file_size(file) / 50);
    const Played played = play(one_body_on(mesh), {.exact = ExactLevel::predicates}, 2);
    EXPECT_EQ(played.frames[1].at(0).verdict, Verdict::undecided);
    ASSERT_FALSE(played.faults.empty());
    EXPECT_NE(played.faults[0].find("the file ends before it; cook the file again (2 results undecided)"),
              std::string::npos)
        << played.faults[0];
}

TEST(Cooked, ChunksBeforeACutAreThereAndThoseBehindItAreNot)
{
    const TemporaryFolder folder;
    const std::string bytes = read(cooked(folder, samples()[4].mesh));
    const auto header = test::value_at<CookedHeader>(bytes, 0);
    ASSERT_GT(header.chunks, 4u);
    CookedMesh::Chunk chunk;
    for (std::uint32_t c = 0; c < header.chunks; ++c) {
        const auto entry =
            test::value_at<CookedChunkEntry>(bytes, test::table_of(bytes) + c * sizeof(CookedChunkEntry));
        for (const std::uint64_t size : {entry.offset, entry.offset + 1, entry.offset + entry.bytes - 1}) {
            const fs::path file = folder.write("cut.cooked", bytes);
            const auto mesh = opened(file);
            fs::resize_file(file, size);
            for (std::uint32_t k = 0; k < header.chunks; ++k) {
                if (k < c)
                    EXPECT_NO_THROW(mesh->read(k, chunk)) << k;
                else
                    EXPECT_THROW(mesh->read(k, chunk), ChunkFault) << k;
            }
            EXPECT_EQ(mesh->faults().size(), header.chunks - c);
            EXPECT_THROW(CookedMesh{file}, Error);
        }
    }
}

TEST(Cooked, AFileThatIsChangedUnderneathIsSeenAndOneThatIsRemovedStays)
{
    const TemporaryFolder folder;
    const fs::path file = cooked(folder, samples()[4].mesh);
    const auto mesh = opened(file);
    fs::remove(file);
    EXPECT_EQ(mesh->whole().triangles, samples()[4].mesh.triangles);
    const auto other = opened(cooked(folder, samples()[4].mesh));
    const fs::path moved = cooked(folder, transformed("moved", samples()[4].mesh, 1, {0, 0, 1}), "moved");
    ASSERT_EQ(fs::file_size(moved), fs::file_size(file));
    { // in place, as a careless program would
        std::ofstream(file, std::ios::binary | std::ios::in | std::ios::out) << read(moved);
    }
    EXPECT_THROW(other->whole(), ChunkFault);
}

TEST(Cooked, OneThatNeedsAllOfADamagedMeshIsRefusedAtOnce)
{
    const TemporaryFolder folder;
    std::string bytes = read(cooked(folder, samples()[4].mesh));
    bytes.back() ^= 1, bytes[bytes.size() - 20] ^= 1;
    const auto mesh = opened(folder.write("damaged.cooked", bytes));
    World world({.mode = Mode::solid});
    const ModelId model = world.add(mesh);
    test::expect_error(
        ErrorKind::bad_data, [&] { world.add_body({.model = model}); }, "damaged.cooked", "checksum");
}

/// Adjacent tiles, each of which is opened when a sphere approaches, and spheres that roll over them.
struct TiledWorld {
    std::vector<std::shared_ptr<const CookedMesh>> tiles;
    Scene scene;

    TiledWorld(const TemporaryFolder& folder, bool as_tiles, const Eigen::Vector3d& off = Eigen::Vector3d::Zero())
    {
        constexpr std::uint32_t across = 4, cells = 60;
        for (std::uint32_t i = 0; i < across * across; ++i) {
            const fs::path file = folder.path() / fmt::format("tile{}.cooked", i);
            const Mesh mesh = make_hills_mesh(across * cells, 0.5, 6, 1, i % across * cells, i / across * cells, cells);
            if (!fs::exists(file)) cook_mesh(mesh, file);
            CookedOutline outline = CookedMesh(file).outline();
            outline.bounds.min += off, outline.bounds.max += off;
            if (as_tiles) tiles.push_back(std::make_shared<const CookedMesh>(file, outline));
            const GeometryId tile = as_tiles ? scene.add(fmt::format("tile {}", i), tiles.back())
                                             : scene.add(fmt::format("tile {}", i), mesh);
            scene.add_body({.name = fmt::format("tile {}", i), .geometry = tile, .is_static = true});
        }
        const GeometryId ball = scene.add("ball", make_sphere_mesh(1, 200));
        for (std::uint64_t i = 0; i < 6; ++i)
            scene.add_body({.name = fmt::format("ball {}", i),
                            .geometry = ball,
                            .pose = Eigen::Isometry3d(Eigen::Translation3d(5, 5 + 1.5 * double(i), 3)),
                            .motion = Drift{.velocity = {1.5, 0.5, 0}, .spin = {0, 0.1, 0}, .walls = {}}});
    }
    std::ptrdiff_t open() const
    {
        return std::ranges::count_if(tiles, [](const auto& tile) { return tile->is_open(); });
    }
};

TEST(Cooked, TilesAreOpenedWhereBodiesComeAndGivenBack)
{
    const TemporaryFolder folder;
    const Settings settings{.exact = ExactLevel::predicates, .age_limit = 8};
    TiledWorld plain(folder, false), tiled(folder, true);
    EXPECT_EQ(tiled.open(), 0);
    Pipeline of_plain(plain.scene, settings), of_tiled(tiled.scene, settings);
    EXPECT_EQ(tiled.open(), 0);
    Mover mover_a, mover_b;
    std::ptrdiff_t most = 0;
    std::size_t met = 0;
    for (int frame = 0; frame < 70; ++frame) {
        mover_a.move(plain.scene, frame), mover_b.move(tiled.scene, frame);
        met += of_plain.step(plain.scene).pairs.size();
        of_tiled.step(tiled.scene);
        most = std::max(most, tiled.open());
    }
    EXPECT_EQ(of_plain.hash(), of_tiled.hash());
    EXPECT_GT(met, 100u);
    EXPECT_GT(most, 0);
    EXPECT_LE(most, 6);
    EXPECT_LT(tiled.open(), most + 1);
    EXPECT_TRUE(of_tiled.world().inspect().file_faults.empty());
}

TEST(Cooked, LookingAheadNeverChangesAResult)
{
    const TemporaryFolder folder;
    const Settings plain{.exact = ExactLevel::predicates};
    const Played expected = play(TiledWorld(folder, false).scene, plain, 40);
    for (const Settings& settings : {Settings{.exact = ExactLevel::predicates, .look_ahead = 10},
                                     Settings{.exact = ExactLevel::predicates, .age_limit = 2, .look_ahead = 5},
                                     Settings{.exact = ExactLevel::predicates,
                                     .threads = 3,
                                     .age_limit = 5,
                                     .resident_budget = 600'000,
                                     .look_ahead = 20}}) {
        const Played played = play(TiledWorld(folder, true).scene, settings, 40);
        expect_same(expected, played);
        EXPECT_TRUE(played.faults.empty());
    }
    EXPECT_THROW(World({.memory_budget = 1'000'000, .look_ahead = 1}), Error);
}

TEST(Cooked, LookingAheadOpensTilesBeforeBodiesMeetThem)
{
    const TemporaryFolder folder;
    TiledWorld world(folder, true);
    World bare({.exact = ExactLevel::predicates, .look_ahead = 60});
    std::vector<ModelId> models;
    for (std::size_t i = 0; i < world.tiles.size(); ++i)
        bare.add_body({.model = bare.add(world.tiles[i]), .is_static = true});
    const BodyId ball = bare.add_body({.model = bare.add(make_sphere_mesh(1, 200))});
    for (int frame = 0; frame < 90 && world.open() == 0; ++frame) { // towards them
        bare.set_pose(ball, Eigen::Isometry3d(Eigen::Translation3d(-30 + 0.3 * frame, 50, 3)));
        EXPECT_TRUE(bare.step().pairs.empty());
        std::this_thread::sleep_for(std::chrono::milliseconds(frame < 40 ? 0 : 5));
    }
    EXPECT_GT(world.open(), 0);
}

TEST(Cooked, NothingRestsOnBoundsThatATileContradicts)
{
    const TemporaryFolder folder;
    TiledWorld wrong(folder, true, {0, 0, 0.25});
    const Played played = play(wrong.scene, {.exact = ExactLevel::predicates}, 3);
    ASSERT_FALSE(played.frames[2].empty());
    std::size_t with_tiles = 0;
    for (const PairResult& pair : played.frames[2]) {
        if (pair.a.slot >= 16) continue; // two spheres
        ++with_tiles;
        EXPECT_EQ(pair.verdict, Verdict::undecided);
        EXPECT_GE(pair.bound, 1e15);
    }
    EXPECT_GT(with_tiles, 0u);
    ASSERT_FALSE(played.faults.empty());
    EXPECT_NE(played.faults[0].find("does not match the index"), std::string::npos) << played.faults[0];
    EXPECT_NE(played.faults[0].find("results undecided"), std::string::npos) << played.faults[0];
}

TEST(Cooked, ATileThatIsGoneCostsItsPairs)
{
    const TemporaryFolder folder;
    TiledWorld world(folder, true);
    fs::remove(folder.path() / "tile0.cooked");
    folder.write("tile1.cooked", "no tile");
    for (const Settings& settings : {Settings{.exact = ExactLevel::predicates}, Settings{},
                                     Settings{.exact = ExactLevel::predicates, .look_ahead = 10}}) {
        const Played played = play(world.scene, settings, 60);
        std::size_t undecided = 0, decided = 0;
        for (const auto& frame : played.frames)
            for (const PairResult& pair : frame) {
                if (pair.a.slot >= 16) continue;
                EXPECT_EQ(pair.verdict == Verdict::undecided, pair.a.slot < 2) << pair.a.slot;
                ++(pair.verdict == Verdict::undecided ? undecided : decided);
            }
        EXPECT_GT(undecided, 0u);
        EXPECT_GT(decided, 0u);
        EXPECT_EQ(played.faults.size(), 2u);
    }
}

/// Whether the file opens, and all of its contents are unchanged.
bool is_whole(const TemporaryFolder& folder, const std::string& bytes)
{
    const fs::path file = folder.write("changed.cooked", bytes);
    try {
        opened(file)->whole();
        return true;
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::bad_data);
        EXPECT_NE(std::string(error.what()).find("changed.cooked"), std::string::npos) << error.what();
        return false;
    }
}

TEST(Cooked, EveryByteThatChangesAndEveryCutIsSeen)
{
    const TemporaryFolder folder;
    const std::string bytes = read(cooked(folder, odd_mesh(12)));
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        std::string changed = bytes;
        changed[at] = static_cast<char>(changed[at] ^ 1 << at % 8);
        ASSERT_FALSE(is_whole(folder, changed)) << at;
    }
    for (std::size_t size = 1; size < bytes.size(); size += size < 200 ? 1 : 17)
        ASSERT_FALSE(is_whole(folder, bytes.substr(0, size))) << size;
    EXPECT_FALSE(is_whole(folder, bytes + '\0'));
    EXPECT_TRUE(is_whole(folder, bytes));
}

TEST(Cooked, OtherVersionsAndByteOrdersAreNamed)
{
    const TemporaryFolder folder;
    const std::string bytes = read(cooked(folder, make_box_mesh({1, 1, 1})));
    const auto expect = [&](std::size_t at, std::uint32_t value, const char* what) {
        std::string changed = bytes;
        test::set_value(changed, at, value);
        const fs::path file = folder.write("other.cooked", test::resealed(changed));
        test::expect_error(
            ErrorKind::bad_data, [&] { opened(file); }, "other.cooked", what);
    };
    expect(offsetof(CookedHeader, version), 2, "version 2");
    expect(offsetof(CookedHeader, byte_order), 0x04030201, "byte order");
    expect(offsetof(CookedHeader, magic), 7, "not a cooked file");
    expect(offsetof(CookedHeader, kind), 9, "unknown kind");
    test::expect_error(
        ErrorKind::no_input, [&] { opened(folder.path() / "none.cooked"); }, "none.cooked");
}

/// Checksums do not detect forged data; checks of the data must.
TEST(Cooked, BoxesThatTheirTrianglesContradictAreNotTrusted)
{
    const TemporaryFolder folder;
    const Mesh& terrain = samples().back().mesh;
    const std::string bytes = read(cooked(folder, terrain));
    const auto header = test::value_at<CookedHeader>(bytes, 0);
    ASSERT_GT(header.nodes, 2u);
    // Shrinks each node's boxes along z, in turn: a chunk below it needs only its top.
    for (std::uint32_t node = 0; node < header.nodes; ++node) {
        std::string forged = bytes;
        const std::size_t at =
            sizeof(CookedHeader) + node * cooked_node_bytes(CookedKind::mesh) + 8 * 9 * 2; // half-extents along z
        for (std::size_t k = 0; k < 8; ++k) {
            const auto half = test::value_at<std::uint16_t>(forged, at + 2 * k);
            test::set_value(forged, at + 2 * k, std::uint16_t(half - std::min<std::uint16_t>(half, 3)));
        }
        const fs::path file = folder.write("forged.cooked", test::resealed(forged));
        EXPECT_THROW(check_cooked(file), ChunkFault) << node;
    }
    // A chunk is checked before its triangles are used as its whole contents.
    std::string forged = bytes;
    const auto entry = test::value_at<CookedChunkEntry>(bytes, test::table_of(bytes));
    for (std::size_t v = 0; v < entry.vertices; ++v)
        test::set_value(forged, entry.offset + 12 * v + 8,
                        test::value_at<float>(forged, entry.offset + 12 * v + 8) + 1);
    const auto mesh = opened(folder.write("moved.cooked", test::resealed(forged)));
    CookedMesh::Chunk chunk;
    mesh->read(0, chunk);
    Scene scene = one_body_on(mesh, chunk.vertices[0]);
    const Played played = play(scene, {.exact = ExactLevel::predicates}, 1);
    EXPECT_EQ(played.frames[0].at(0).verdict, Verdict::undecided);
    ASSERT_EQ(played.faults.size(), 1u);
    EXPECT_NE(played.faults[0].find("outside"), std::string::npos) << played.faults[0];
}

} // namespace
} // namespace oncollide
