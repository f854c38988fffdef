// Meshes in cooked files, compared with the meshes that they were cooked from.
#include <oncollide/broadphase/bounds/pose_bounds.hpp>
#include <oncollide/pipeline/world.hpp>

#include "pipeline/models/cooked_scenes.hpp"
#include "random_pose.hpp"

namespace oncollide::cooked_scenes {
namespace {

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
            const auto found_a = of_a.world().pairs().contacts(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i})),
                       found_b = of_b.world().pairs().contacts(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}));
            ASSERT_EQ(found_a.size(), found_b.size());
            contacts += found_a.size();
            for (std::size_t k = 0; k < found_a.size(); ++k)
                EXPECT_TRUE(found_a[k].a == found_b[k].a && found_a[k].b == found_b[k].b &&
                            found_a[k].ends == found_b[k].ends && found_a[k].normal_a == found_b[k].normal_a);
            const Distance d = of_a.world().pairs().distance(of_a.body(SceneBodyId{0}), of_a.body(SceneBodyId{i}),
                                                             {.tolerance = 1e-3}),
                           e = of_b.world().pairs().distance(of_b.body(SceneBodyId{0}), of_b.body(SceneBodyId{i}),
                                                             {.tolerance = 1e-3});
            EXPECT_EQ(d.lower, e.lower);
            EXPECT_EQ(d.upper, e.upper);
            EXPECT_TRUE(d.a == e.a && d.b == e.b);
        }
        EXPECT_TRUE(contacts > 0 || sample.mesh.triangles.size() < 1000);
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

} // namespace
} // namespace oncollide::cooked_scenes
