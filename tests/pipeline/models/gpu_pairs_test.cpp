#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/walk/mesh_walks.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/catalogue.hpp>
#include <oncollide/samples/generators.hpp>

#include "random_pose.hpp"
#include "verify/cases/body_case.hpp"

namespace oncollide::gpu_pairs_test {
namespace {

struct Played {
    std::vector<std::uint64_t> hashes; ///< per frame
    std::string note;
    MeshWalkCounts counts;
    std::uint64_t narrowed = 0;
};

/// Every pair that can go to the GPU does.
constexpr std::uint32_t all_pairs = 1;

Played play(Scene scene, Settings settings, int frames, MeshWalkOptions gpu = {})
{
    gpu.worth_pairs = all_pairs;
    Played played;
    Pipeline pipeline(scene, WorldAccess::make(settings, gpu));
    Mover mover;
    for (int frame = 0; frame < frames; ++frame) {
        mover.move(scene, frame);
        const FrameView view = pipeline.step(scene);
        played.hashes.push_back(view.hash);
        played.narrowed += view.trees.narrowed;
    }
    played.note = pipeline.inspect().backend_note;
    played.counts = WorldAccess::gpu_counts(pipeline.world());
    return played;
}

Scene scene_of(const std::string& name, int bodies)
{
    return make_scene(name, {.bodies = bodies, .frames = {}, .seed = 7, .data = {}});
}

/// Plays a scene with both backends and expects the same frames.
Played expect_same(const Scene& scene, Settings settings, int frames)
{
    const Played cpu = play(scene, settings, frames);
    settings.backend = BackendKind::gl;
    Played gpu = play(scene, settings, frames);
    EXPECT_EQ(gpu.hashes, cpu.hashes);
    EXPECT_EQ(gpu.note, "");
    return gpu;
}

TEST(GpuPairs, HaveTheHashesOfTheCpu)
{
    const Played many = expect_same(scene_of("many", 300), {}, 6);
    EXPECT_GT(many.counts.pairs,
              many.narrowed / 3); // the CPU decides the first frame, and pairs by their gaps
    expect_same(make_scene("paper"), {}, 6);
    expect_same(make_scene("hard"), {}, 4);
    expect_same(make_scene("random", {.bodies = 40, .frames = {}, .seed = 3, .data = {}}), {}, 4);
}

TEST(GpuPairs, HaveTheHashesOfTheCpuForAnySettings)
{
    const Scene scene = scene_of("many", 250);
    for (const Settings& settings :
         {Settings{.max_error = 0.02}, Settings{.clearance = 0.05, .exact = ExactLevel::predicates},
          Settings{.max_error = 0.01, .clearance = 0.03}, Settings{.contact_kinds = true},
          Settings{.mode = Mode::solid}, Settings{.threads = 3}, Settings{.coherence = false}, Settings{.age_limit = 1},
          Settings{.skip = {StageId::refine}}, Settings{.bounding_volume = BoundingVolume::sphere}})
        expect_same(scene, settings, 4);
}

TEST(GpuPairs, EndOnTheCpuIfAnyStepFails)
{
    const Scene scene = scene_of("many", 200);
    const Played cpu = play(scene, {}, 6);
    for (const MeshWalkStep step :
         {MeshWalkStep::context, MeshWalkStep::shaders, MeshWalkStep::self_test, MeshWalkStep::trees,
          MeshWalkStep::upload, MeshWalkStep::dispatch, MeshWalkStep::readback}) {
        const bool at_start = step <= MeshWalkStep::self_test;
        for (const int after : at_start ? std::vector{0} : std::vector{0, 2}) {
            int left = after;
            MeshWalkOptions options;
            options.before = [&](MeshWalkStep now) {
                if (now == step && left-- == 0) throw GpuLost("it died");
            };
            const Played gpu = play(scene, {.backend = BackendKind::gl}, 6, options);
            EXPECT_EQ(gpu.hashes, cpu.hashes) << int(step);
            EXPECT_NE(gpu.note.find("it died"), std::string::npos) << gpu.note;
        }
    }
    const Played none = play(scene, {.backend = BackendKind::gl, .gpu = 63}, 6);
    EXPECT_EQ(none.hashes, cpu.hashes);
    EXPECT_NE(none.note.find("no GPU 63"), std::string::npos) << none.note;
    const Played small = play(scene, {.backend = BackendKind::gl}, 6, {.most_buffer_bytes = 1 << 19});
    EXPECT_EQ(small.hashes, cpu.hashes);
    EXPECT_NE(small.note, "");
    const Played full = play(scene, {.backend = BackendKind::gl}, 6, {.first_items = 64});
    EXPECT_EQ(full.hashes, cpu.hashes);
    EXPECT_GT(full.counts.full, 0u);
}

TEST(GpuPairs, DecideColumnsOfPosesAsTheCpuDoes)
{
    constexpr std::size_t count = 2000;
    std::vector<double> at(16 * count), origin(16);
    const auto put = [](const Eigen::Isometry3d& pose, double* to) {
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> row(to);
        row = pose.matrix();
    };
    put(random_pose(1, 1), origin.data());
    for (std::size_t i = 0; i < count; ++i) put(random_pose(2 + i, 2.5), &at[16 * i]);
    const auto mesh =
        std::make_shared<const Geometry>(Geometry{"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 2000), {}});
    std::vector<Finding> found[2];
    for (const BackendKind backend : {BackendKind::cpu, BackendKind::gl}) {
        World world({.backend = backend});
        const ModelId model = world.models().add(mesh);
        const std::vector<ModelId> models{model};
        std::vector<Finding>& results = found[backend == BackendKind::gl];
        results.resize(count);
        for (int call = 0; call < 2; ++call) // the second one finds the trees on the GPU
            world.pairs().decide(PairOfColumns{{models, origin}, {models, at}}, results);
        if (backend == BackendKind::gl) {
            const MeshWalkCounts counts = WorldAccess::gpu_counts(world);
            EXPECT_GE(counts.pairs, count);
            EXPECT_LT(counts.bytes_up, 300 * counts.pairs);
        }
    }
    std::size_t met = 0;
    for (std::size_t i = 0; i < count; ++i) {
        EXPECT_EQ(found[1][i].verdict, found[0][i].verdict) << i;
        met += found[1][i].verdict == Verdict::colliding;
        if (found[1][i].verdict == Verdict::separate) {
            EXPECT_GT(found[1][i].bound, 0) << i;
        }
    }
    EXPECT_GT(met, count / 10);
    EXPECT_LT(met, count / 2);
}

TEST(GpuPairs, DecideTouchingBodiesInTheFrameOfTheFirst)
{
    // The faces of two boxes coincide, up to the rounding of their poses: it decides whether they meet.
    constexpr std::size_t count = 600;
    std::vector<double> poses[2] = {std::vector<double>(16 * count), std::vector<double>(16 * count)};
    const auto put = [](const Eigen::Isometry3d& pose, double* to) {
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> row(to);
        row = pose.matrix();
    };
    for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Isometry3d pose = random_pose(i, 3);
        put(pose, &poses[0][16 * i]);
        put(pose * Eigen::Translation3d(2, 0.4, 0.3) * Eigen::AngleAxisd(0.01 * double(i), Eigen::Vector3d::UnitX()),
            &poses[1][16 * i]);
    }
    std::vector<Finding> found[2][2];
    for (const bool gl : {false, true})
        for (const bool swapped : {false, true}) {
            World world({.backend = gl ? BackendKind::gl : BackendKind::cpu});
            const std::vector<ModelId> models{
                world.models().add(std::make_shared<const Geometry>(Geometry{"box", make_box_mesh({1, 1, 1}), {}}))};
            std::vector<Finding>& results = found[gl][swapped];
            results.resize(count);
            for (int call = 0; call < 2; ++call)
                world.pairs().decide(PairOfColumns{{models, poses[swapped]}, {models, poses[!swapped]}}, results);
        }
    std::size_t met = 0, by_order = 0;
    for (std::size_t i = 0; i < count; ++i) {
        for (const bool swapped : {false, true})
            EXPECT_EQ(found[1][swapped][i].verdict, found[0][swapped][i].verdict) << i;
        met += found[0][0][i].verdict == Verdict::colliding;
        by_order += found[0][0][i].verdict != found[0][1][i].verdict;
    }
    EXPECT_GT(met, count / 10);
    EXPECT_LT(met, count - count / 10);
    EXPECT_GT(by_order, 10u);
}

TEST(GpuPairs, DecideTheHardCasesAsTheCpuDoes)
{
    const std::vector<tools::BodyCase> cases = tools::body_cases();
    std::vector<Finding> found[2];
    std::vector<Distance> distances;
    for (const bool gl : {false, true}) {
        World world({.backend = gl ? BackendKind::gl : BackendKind::cpu});
        std::vector<PairOfModels> pairs;
        for (const tools::BodyCase& c : cases) {
            const ModelId a = world.models().add(c.a), b = world.models().add(c.b);
            for (const Eigen::Isometry3d& pose : c.poses_b) {
                pairs.push_back({{a, c.pose_a}, {b, pose}});
                pairs.push_back({{b, pose}, {a, c.pose_a}});
            }
        }
        found[gl].resize(pairs.size());
        for (int call = 0; call < 6; ++call) world.pairs().decide(std::span<const PairOfModels>(pairs), found[gl]);
        if (!gl) {
            distances.resize(pairs.size());
            world.pairs().distance(std::span<const PairOfModels>(pairs), {}, distances);
            continue;
        }
        const MeshWalkCounts counts = WorldAccess::gpu_counts(world);
        EXPECT_GT(counts.pairs, 4 * pairs.size());
        EXPECT_GT(counts.unsure_pairs, 1000u);
        EXPECT_EQ(world.inspect().backend_note, "");
    }
    ASSERT_GT(found[0].size(), 400u);
    for (std::size_t i = 0; i < found[0].size(); ++i) {
        EXPECT_EQ(found[1][i].verdict, found[0][i].verdict) << i;
        if (found[1][i].verdict != Verdict::separate) continue;
        EXPECT_EQ(found[1][i].bound > 0, found[0][i].bound > 0) << i; // 0: doubles cannot express the gap
        EXPECT_LE(found[1][i].bound, distances[i].upper) << i;
    }
}

TEST(GpuPairs, BelongToTheThreadThatMadeTheWorld)
{
    const Scene scene = scene_of("many", 200);
    const Played cpu = play(scene, {}, 3);
    Scene moved = scene;
    Pipeline pipeline(moved, WorldAccess::make({.backend = BackendKind::gl}, MeshWalkOptions{}));
    std::vector<std::uint64_t> hashes;
    std::thread([&] {
        Mover mover;
        for (int frame = 0; frame < 3; ++frame) {
            mover.move(moved, frame);
            hashes.push_back(pipeline.step(moved).hash);
        }
    }).join();
    EXPECT_EQ(hashes, cpu.hashes);
    EXPECT_EQ(WorldAccess::gpu_counts(pipeline.world()).batches, 1u); // the self-test
}

} // namespace
} // namespace oncollide::gpu_pairs_test
