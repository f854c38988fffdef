#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/pipeline.hpp>
#include <oncollide/samples/catalogue.hpp>

namespace oncollide::gpu_test {
namespace {

Scene many(int bodies)
{
    return make_scene("many", {.bodies = bodies, .frames = {}, .seed = 7, .data = {}});
}

/// The cpu backend, which fails at a given call.
class DyingBackend final : public OcclusionBackend {
public:
    /// @param coarse  added to the error bound of the cells, as a share of their half side
    explicit DyingBackend(int calls, double coarse = 0) : left_(calls), coarse_(coarse) {}
    std::string name() const override { return "dying"; }
    double error(double half) const override { return cpu_->error(half) + coarse_ * half; }
    void attach(std::uint32_t tree, Surface surface) override { count(), cpu_->attach(tree, std::move(surface)); }
    bool attached(std::uint32_t tree) const override { return cpu_->attached(tree); }
    void detach(std::uint32_t tree) override { cpu_->detach(tree); }
    void submit(std::span<const OctantRow> rows, int threads) override { count(), cpu_->submit(rows, threads); }
    BatchWork collect(std::span<OctantResult> answers) override { return count(), cpu_->collect(answers); }
    void release(std::uint32_t tree, ListId list) override { cpu_->release(tree, list); }
    void read(std::span<const ListRead> reads, std::vector<std::uint32_t>& triangles,
              std::vector<std::size_t>& ends) override
    {
        count(), cpu_->read(reads, triangles, ends);
    }
    std::size_t bytes() const override { return cpu_->bytes(); }

private:
    void count()
    {
        if (left_-- <= 0) throw GpuLost("it died");
    }
    std::unique_ptr<OcclusionBackend> cpu_ = make_cpu_backend();
    int left_;
    double coarse_;
};

struct Played {
    std::vector<std::uint64_t> hashes; ///< per frame
    std::string note, error;
};

Played play(Scene scene, const Settings& settings, int frames, std::unique_ptr<OcclusionBackend> backend = nullptr)
{
    Played played;
    Pipeline pipeline(scene, WorldAccess::make(settings, std::move(backend)));
    Mover mover;
    try {
        for (int frame = 0; frame < frames; ++frame) {
            mover.move(scene, frame);
            played.hashes.push_back(pipeline.step(scene).hash);
        }
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::no_gpu);
        played.error = error.what();
    }
    played.note = pipeline.inspect().backend_note;
    return played;
}

TEST(Gpu, GrowingAheadOfTheTraversalsChangesNoResultAndTakesFewerRounds)
{
    for (const bool on_gpu : {false, true}) {
        std::uint64_t hashes[2], rounds[2] = {};
        for (const bool ahead : {false, true}) {
            Scene scene = many(200);
            Pipeline pipeline(scene, WorldAccess::make({.depth = 6, .age_limit = 2},
                                                       on_gpu ? make_gl_compute_backend() : make_cpu_backend()));
            WorldAccess::grow_ahead(pipeline.world(), ahead);
            Mover mover;
            for (int frame = 0; frame < 6; ++frame) {
                mover.move(scene, frame);
                rounds[ahead] += pipeline.step(scene).rounds.size();
            }
            hashes[ahead] = pipeline.hash();
        }
        EXPECT_EQ(hashes[0], hashes[1]);
        EXPECT_LT(rounds[1], rounds[0]);
    }
}

TEST(Gpu, GlComputeGivesTheAnswersOfTheCpu)
{
    for (const ExactLevel exact : {ExactLevel::off, ExactLevel::fcl})
        for (const std::size_t node_budget : {0, 400}) {
            Settings settings{.depth = 5, .exact = exact, .age_limit = 2, .node_budget = node_budget};
            const Played cpu = play(many(400), settings, 6);
            settings.backend = BackendKind::gl_compute;
            for (const int threads : {1, 3}) {
                settings.threads = threads;
                EXPECT_EQ(play(many(400), settings, 6).hashes, cpu.hashes);
            }
        }
}

TEST(Gpu, RoundsTellWhatTheyCost)
{
    Scene scene = many(300);
    Pipeline pipeline(scene, {.depth = 4, .backend = BackendKind::gl_compute});
    const FrameView view = pipeline.step(scene);
    ASSERT_GT(view.rounds.size(), 3u);
    std::uint64_t rows = 0;
    double before = 0;
    for (const Round& round : view.rounds) {
        EXPECT_GT(round.gpu_ms, 0);
        EXPECT_GT(round.bytes, 0u);
        EXPECT_LE(before, round.submitted_ms);
        EXPECT_LE(round.submitted_ms, round.waited_ms);
        EXPECT_LE(round.waited_ms, round.done_ms);
        before = round.done_ms, rows += round.rows;
    }
    EXPECT_EQ(rows, view.trees.rows);
    EXPECT_GT(view.stages[3].gpu_ms, 0);
    EXPECT_LE(view.stages[3].wait_ms, view.stages[3].cpu_ms);
    EXPECT_NE(pipeline.inspect().renderer, "");
    EXPECT_NE(pipeline.inspect().backend.find(pipeline.inspect().renderer), std::string::npos);
}

TEST(Gpu, RoundsDoNotGrowWithThePairs)
{
    std::vector<std::size_t> rounds;
    for (const int bodies : {600, 6000}) {
        Scene scene = many(bodies);
        Pipeline pipeline(scene, {.depth = 5});
        rounds.push_back(pipeline.step(scene).rounds.size());
    }
    EXPECT_LE(rounds[1], rounds[0] + 8) << "for slices that start later";
}

TEST(Gpu, AFrameInWhichItIsLostIsFinishedOnTheCpu)
{
    const Settings settings{.depth = 5, .exact = ExactLevel::fcl, .backend = BackendKind::automatic, .age_limit = 2};
    const Played cpu = play(many(200), settings, 5, make_cpu_backend());
    EXPECT_EQ(cpu.note, "");
    int lost = 0;
    for (int calls = 0; calls < 60; calls += 3) { // at the upload, at a batch, at its result, at the exact level
        const Played played = play(many(200), settings, 5, std::make_unique<DyingBackend>(calls));
        EXPECT_EQ(played.hashes, cpu.hashes) << "lost at call " << calls;
        EXPECT_EQ(played.error, "");
        lost += played.note.find("it died") != std::string::npos;
    }
    EXPECT_GT(lost, 10);
}

/// Cells of a coarse backend, such as gl-query, keep its error bound after another backend takes over.
TEST(Gpu, CellsThatALostOneFoundKeepTheirError)
{
    constexpr int never = 1 << 30;
    const Scene scene = many(60);
    const Settings settings{.depth = 5, .backend = BackendKind::automatic};
    const auto coarse = play(scene, settings, 1, std::make_unique<DyingBackend>(never, 0.25)).hashes;
    EXPECT_NE(coarse, play(scene, settings, 1, std::make_unique<DyingBackend>(never)).hashes);
    int lost = 0;
    for (const int calls : {3, 8, 16}) {
        const Played played = play(scene, settings, 1, std::make_unique<DyingBackend>(calls, 0.25));
        lost += !played.note.empty();
        EXPECT_EQ(played.hashes, coarse) << calls;
    }
    EXPECT_EQ(lost, 3);
}

TEST(Gpu, TakesNoPartWhereExactTestsDecideAndSaysSo)
{
    try {
        Pipeline pipeline(many(5), {.exact = ExactLevel::predicates, .backend = BackendKind::gl_compute});
        EXPECT_NE(pipeline.inspect().backend_note.find("GPU is not used"), std::string::npos)
            << pipeline.inspect().backend_note;
        Pipeline spheres(many(5), {.backend = BackendKind::gl_compute});
        EXPECT_EQ(spheres.inspect().backend_note.find("GPU is not used"), std::string::npos)
            << spheres.inspect().backend_note;
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu) throw;
        GTEST_SKIP() << error.what();
    }
}

TEST(Gpu, OneAskedForByNameThatIsLostEndsTheRunAfterTheFrame)
{
    Settings settings{.depth = 5, .backend = BackendKind::gl_compute};
    const Played cpu = play(many(200), settings, 5, make_cpu_backend());
    const Played played = play(many(200), settings, 5, std::make_unique<DyingBackend>(4));
    ASSERT_EQ(played.hashes.size(), 1u);
    EXPECT_EQ(played.hashes[0], cpu.hashes[0]);
    EXPECT_NE(played.error.find("it died"), std::string::npos) << played.error;
    EXPECT_NE(played.error.find("--backend auto or cpu"), std::string::npos) << played.error;
}

TEST(Gpu, AutoTakesTheCpuRatherThanASoftwareRendererAndSaysSo)
{
    const bool hardware = !describe_gpu(-1).software;
    const Scene scene = many(10);
    const Pipeline pipeline(scene, {.backend = BackendKind::automatic});
    EXPECT_EQ(pipeline.inspect().renderer.empty(), !hardware);
    EXPECT_EQ(pipeline.inspect().backend_note.empty(), hardware) << pipeline.inspect().backend_note;
    const Pipeline with_number(scene, {.backend = BackendKind::automatic, .gpu = 0});
    EXPECT_EQ(with_number.inspect().renderer.empty(), describe_gpu(0).software);
}

} // namespace
} // namespace oncollide::gpu_test
