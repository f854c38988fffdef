#include <functional>
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

/// Called before each step of shared_walks().
std::function<void(MeshWalkStep)> before_step;

/// Compiling the shaders takes longer than most tests, so that the Worlds of one process share a MeshWalks.
MeshWalks& shared_walks()
{
    static const std::unique_ptr<MeshWalks> walks = make_mesh_walks({.before = [](MeshWalkStep step) {
        if (before_step) before_step(step);
    }});
    return *walks;
}

/// The boxes that each batch of a LentWalks missed.
std::vector<std::size_t> boxes_missed;

/// Lends the shared MeshWalks to one World.
class LentWalks final : public MeshWalks {
public:
    ~LentWalks() override // the next World finds no batch under way, even if this one lost its GPU
    {
        before_step = {};
        for (; under_way_ > 0; --under_way_) walks_.collect();
    }
    const GpuInfo& info() const override { return walks_.info(); }
    bool is_owner() const override { return walks_.is_owner(); }
    std::optional<std::uint32_t> hold(const ObbTree& tree, std::uint32_t frame) override
    {
        return walks_.hold(tree, frame);
    }
    void drop_unused(std::uint32_t frame) override { walks_.drop_unused(frame); }
    std::span<MeshWalkPair> begin(std::size_t pairs) override { return walks_.begin(pairs); }
    void submit(bool by_distance) override { walks_.submit(by_distance), ++under_way_; }
    std::span<const MeshWalkResult> collect() override
    {
        --under_way_;
        const auto results = walks_.collect();
        counts_ += walks_.batch();
        boxes_missed.push_back(walks_.wanted().size());
        return results;
    }
    std::span<const UnsureTriangles> unsure() const override { return walks_.unsure(); }
    std::span<const WantedNode> wanted() const override { return walks_.wanted(); }
    const MeshWalkCounts& batch() const override { return walks_.batch(); }
    const MeshWalkCounts& counts() const override { return counts_; }
    std::size_t bytes() const override { return walks_.bytes(); }

private:
    MeshWalks& walks_ = shared_walks();
    int under_way_ = 0; ///< batches
    MeshWalkCounts counts_;
};

MeshWalkOptions lent()
{
    return {.make = [] { return std::make_unique<LentWalks>(); }};
}

/// Every pair that can go to the GPU does.
constexpr std::uint32_t all_pairs = 1;

Played play(Scene scene, Settings settings, int frames, MeshWalkOptions gpu = lent())
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
    const auto expect_fall_back = [&](MeshWalkStep step, int after, MeshWalkOptions options) {
        const auto die = [&](MeshWalkStep now) {
            if (now == step && after-- == 0) throw GpuLost("it died");
        };
        (options.make ? before_step : options.before) = die;
        const Played gpu = play(scene, {.backend = BackendKind::gl}, 6, options);
        before_step = {};
        EXPECT_EQ(gpu.hashes, cpu.hashes) << int(step);
        EXPECT_NE(gpu.note.find("it died"), std::string::npos) << gpu.note;
    };
    for (const MeshWalkStep step :
         {MeshWalkStep::context, MeshWalkStep::doubles, MeshWalkStep::shaders, MeshWalkStep::self_test})
        expect_fall_back(step, 0, {});
    for (const MeshWalkStep step :
         {MeshWalkStep::trees, MeshWalkStep::upload, MeshWalkStep::dispatch, MeshWalkStep::readback})
        for (const int after : {0, 2}) expect_fall_back(step, after, lent());
    MeshWalkOptions floats;
    floats.hidden_extension = "GL_ARB_gpu_shader_fp64";
    const Played without_doubles = play(scene, {.backend = BackendKind::gl}, 6, floats);
    EXPECT_EQ(without_doubles.hashes, cpu.hashes);
    EXPECT_NE(without_doubles.note.find("no doubles"), std::string::npos) << without_doubles.note;
    const Played none = play(scene, {.backend = BackendKind::gl, .gpu = 63}, 6, {});
    EXPECT_EQ(none.hashes, cpu.hashes);
    EXPECT_NE(none.note.find("no GPU 63"), std::string::npos) << none.note;
    const Played small = play(scene, {.backend = BackendKind::gl}, 6, {.most_buffer_bytes = 1 << 19});
    EXPECT_EQ(small.hashes, cpu.hashes);
    EXPECT_NE(small.note, "");
    const Played full = play(scene, {.backend = BackendKind::gl}, 6, {.first_items = 64});
    EXPECT_EQ(full.hashes, cpu.hashes);
    EXPECT_GT(full.counts.full, 0u);
}

/// Random poses as a column: 16 numbers for each, row by row.
std::vector<double> random_column(std::size_t count, std::uint64_t seed, double reach)
{
    std::vector<double> column(16 * count);
    for (std::size_t i = 0; i < count; ++i) {
        Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> row(&column[16 * i]);
        row = random_pose(seed + i, reach).matrix();
    }
    return column;
}

std::size_t differences(const std::vector<Finding>& a, const std::vector<Finding>& b)
{
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i].verdict != b[i].verdict;
    return count;
}

TEST(GpuPairs, DecideColumnsOfPosesAsTheCpuDoes)
{
    constexpr std::size_t count = 2000;
    const std::vector<double> origin = random_column(1, 1, 1), at = random_column(count, 2, 2.5);
    const auto mesh =
        std::make_shared<const Geometry>(Geometry{"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 2000), {}});
    std::vector<Finding> found[2];
    for (const BackendKind backend : {BackendKind::cpu, BackendKind::gl}) {
        World world = WorldAccess::make({.backend = backend}, lent());
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

TEST(GpuPairs, GrowTheBoxesThatTheGpuMissed)
{
    constexpr std::size_t count = 400;
    const std::vector<double> origin = random_column(1, 1, 1), at = random_column(count, 2, 0.8);
    const auto mesh =
        std::make_shared<const Geometry>(Geometry{"knot", make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 20000), {}});
    World world = WorldAccess::make({.backend = BackendKind::gl}, lent());
    const std::vector<ModelId> models{world.models().add(mesh)};
    std::vector<Finding> found(count);
    boxes_missed.clear();
    for (int call = 0; call < 12; ++call) world.pairs().decide(PairOfColumns{{models, origin}, {models, at}}, found);
    ASSERT_GT(boxes_missed.size(), 8u);
    EXPECT_GT(boxes_missed.front(), 50u);
    EXPECT_LT(boxes_missed.back(), boxes_missed.front() / 3); // each call shows the boxes below the new nodes
}

/// Boxes at random poses, for calls with many pairs.
struct ManyBoxes {
    World world;
    std::vector<ModelId> models;
    std::vector<double> origin = random_column(1, 1, 1), at;
    std::vector<Finding> found;

    ManyBoxes(const Settings& settings, std::size_t count)
        : world(WorldAccess::make(settings, lent())), models{world.models().add(std::make_shared<const Geometry>(
                                                          Geometry{"box", make_box_mesh({0.8, 0.5, 0.3}), {}}))},
          at(random_column(count, 2, 5)), found(count)
    {
    }
    const std::vector<Finding>& decide()
    {
        world.pairs().decide(PairOfColumns{{models, origin}, {models, at}}, found);
        return found;
    }
};

TEST(GpuPairs, DecideManyBatchesInOneCall)
{
    constexpr std::size_t count = 4 * MeshWalks::most_pairs + 100; // the working memory holds four batches
    const std::vector<Finding> cpu = ManyBoxes({.threads = 2}, count).decide();
    EXPECT_GT(std::ranges::count(cpu, Verdict::colliding, &Finding::verdict), std::ptrdiff_t{count / 100});
    ManyBoxes gpu({.backend = BackendKind::gl, .threads = 2}, count);
    gpu.decide(); // trees grow
    EXPECT_EQ(differences(gpu.decide(), cpu), 0u);
    EXPECT_GE(WorldAccess::gpu_counts(gpu.world).batches, 5u);

    int left = 2; // the GPU is lost while the third batch and the fourth one are under way
    before_step = [&](MeshWalkStep step) {
        if (step == MeshWalkStep::readback && left-- == 0) throw GpuLost("it died");
    };
    EXPECT_EQ(differences(gpu.decide(), cpu), 0u);
    before_step = {};
    EXPECT_NE(gpu.world.inspect().backend_note.find("it died"), std::string::npos);
}

TEST(GpuPairs, StopBetweenBatches)
{
    constexpr std::size_t count = 2 * MeshWalks::most_pairs + 1;
    const std::vector<Finding> cpu = ManyBoxes({}, count).decide();
    int left = -1; // checks until the call stops; negative: it does not
    ManyBoxes gpu(
        {.backend = BackendKind::gl, .stop = [&] { return left >= 0 && left-- == 0 ? (left = 0, true) : false; }},
        count);
    gpu.decide(); // trees grow
    for (const int checks : {1, 2}) {
        left = checks;
        const std::vector<Finding>& found = gpu.decide();
        EXPECT_GT(std::ranges::count(found, Verdict::undecided, &Finding::verdict), 0) << checks;
        for (std::size_t i = 0; i < count; ++i)
            if (found[i].verdict != Verdict::undecided) {
                ASSERT_EQ(found[i].verdict, cpu[i].verdict) << i;
            }
        left = -1;
        EXPECT_EQ(differences(gpu.decide(), cpu), 0u);
    }
    EXPECT_EQ(gpu.world.inspect().backend_note, "");
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
            World world = WorldAccess::make({.backend = gl ? BackendKind::gl : BackendKind::cpu}, lent());
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
        World world = WorldAccess::make({.backend = gl ? BackendKind::gl : BackendKind::cpu}, lent());
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
    Pipeline pipeline(moved, WorldAccess::make({.backend = BackendKind::gl}, lent()));
    std::vector<std::uint64_t> hashes;
    std::thread([&] {
        Mover mover;
        for (int frame = 0; frame < 3; ++frame) {
            mover.move(moved, frame);
            hashes.push_back(pipeline.step(moved).hash);
        }
    }).join();
    EXPECT_EQ(hashes, cpu.hashes);
    EXPECT_EQ(WorldAccess::gpu_counts(pipeline.world()).batches, 0u);
}

} // namespace
} // namespace oncollide::gpu_pairs_test
