#include "bench/gpu/paper_methods.hpp"

#include <algorithm>
#include <set>

#include <oncollide/narrowphase/gl/gpu.hpp>
#include <oncollide/pipeline/world/stage.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

#include "common/statistics.hpp"
#include "truth/scene_truth.hpp"

namespace oncollide::tools {
namespace {

/// A comparator in the place of the refine stage: it drops pairs of meshes, and all others stay undecided.
class CullingStage final : public Stage {
public:
    CullingStage(std::unique_ptr<Stage> refine, std::unique_ptr<PairCulling> culling)
        : refine_(std::move(refine)), culling_(std::move(culling))
    {
    }
    StageId id() const override { return refine_->id(); }
    std::string_view unit() const override { return refine_->unit(); }
    std::string_view reason_to_skip(const BodyTable& bodies, const Frame& frame) const override
    {
        return refine_->reason_to_skip(bodies, frame);
    }

    void run(BodyTable& bodies, Frame& frame, StageStats& stats) override
    {
        refine_->skip(bodies, frame, stats); // lists every pair as undecided
        rows_.clear(), pairs_.clear(), culled_.resize(bodies.slots());
        for (std::uint32_t i = 0; i < frame.results.size(); ++i) {
            const std::uint32_t a = frame.results[i].a.slot, b = frame.results[i].b.slot;
            if (!take(bodies, a) || !take(bodies, b)) continue;
            rows_.push_back(i), pairs_.push_back({a, b});
        }
        left_.resize(pairs_.size());
        const CullingWork work = culling_->cull(culled_, pairs_, left_);
        for (std::size_t k = 0; k < rows_.size(); ++k) {
            if (left_[k]) continue;
            static_cast<Finding&>(frame.results[rows_[k]]) = {Verdict::separate, ContactKind::unknown, 0};
            --stats.out, --stats.undecided;
        }
        frame.context.trees.queries += work.queries, stats.gpu_ms += work.gpu_ms;
    }
    void skip(BodyTable& bodies, Frame& frame, StageStats& stats) override { refine_->skip(bodies, frame, stats); }

private:
    /// False if the body is no mesh.
    bool take(const BodyTable& bodies, std::uint32_t slot)
    {
        const Model& model = bodies.model(slot);
        if (!model.is_mesh()) return false;
        if (attached_.insert(model.number()).second) culling_->attach(model.number(), *model.mesh());
        culled_[slot] = {model.number(), bodies.pose(slot)};
        return true;
    }

    std::unique_ptr<Stage> refine_;
    std::unique_ptr<PairCulling> culling_;
    std::set<std::uint32_t> attached_; ///< numbers of models
    std::vector<CulledBody> culled_;   ///< by slot
    std::vector<std::uint32_t> rows_;  ///< of the pairs of meshes in the frame's results
    std::vector<BodyPair> pairs_;
    std::vector<std::uint8_t> left_;
};

} // namespace

World Method::make(Settings settings) const
{
    if (backend) return WorldAccess::make(settings, backend());
    settings.coherence = false; // a result may depend on all bodies
    World world = WorldAccess::make(settings, make_cpu_backend());
    WorldAccess::replace(world, StageId::refine, [&](std::unique_ptr<Stage> refine) {
        return std::make_unique<CullingStage>(std::move(refine), culling());
    });
    return world;
}

std::vector<Method> tree_methods(int gpu, int viewport)
{
    using Query = GlQueryOptions;
    const auto query = [&](Query::Primitives primitives, Query::Draw draw) {
        return [=] {
            return make_gl_query_backend({.gpu = gpu,
                                          .viewport = viewport,
                                          .primitives = primitives,
                                          .samples = Query::Samples::passed,
                                          .draw = draw});
        };
    };
    return {{"cpu", make_cpu_backend, {}, true},
            {"gl-query, soup", query(Query::Primitives::soup, Query::Draw::mesh), {}, false},
            {"gl-query, strips", query(Query::Primitives::strips, Query::Draw::mesh), {}, false},
            {"gl-query, inherited", query(Query::Primitives::indexed, Query::Draw::inherited), {}, false},
            {"gl-compute", [gpu] { return make_gl_compute_backend({.gpu = gpu}); }, {}, true}};
}

std::vector<Method> comparators(int gpu, int viewport)
{
    const auto cullide = [=](bool fattened) {
        return [=] { return make_cullide({.gpu = gpu, .viewport = viewport, .fattened = fattened}); };
    };
    return {{"viewing volumes", {}, [gpu] { return make_viewing_volumes({.gpu = gpu}); }, false},
            {"CULLIDE", {}, cullide(false), false},
            {"CULLIDE, fattened", {}, cullide(true), true}};
}

Window Played::total() const
{
    Window sum;
    for (const Window& w : windows)
        sum.ms += w.ms, sum.frames += w.frames, sum.queries += w.queries, sum.cells += w.cells;
    return sum;
}

std::pair<double, double> Played::least_and_most_per_s() const
{
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (const Window& w : windows)
        if (w.frames)
            least = std::min(least, 1e3 * double(w.frames) / w.ms),
            most = std::max(most, 1e3 * double(w.frames) / w.ms);
    return {least, most};
}

std::uint64_t Played::left_over() const
{
    return count_pairs(left);
}

Played play(Scene scene, const Settings& settings, const Method& method, int windows, int every,
            const std::function<bool()>& stop)
{
    Played played;
    played.windows.resize(static_cast<std::size_t>(windows));
    Pipeline pipeline(scene, method.make(settings));
    Mover mover;
    for (int frame = 0; frame < scene.frames; frame += every) {
        played.stopped = stop && stop();
        if (played.stopped) break;
        mover.move(scene, frame);
        const FrameView view = pipeline.step(scene);
        Window& window = played.windows[static_cast<std::size_t>(frame * windows / scene.frames)];
        window.ms += view.ms, window.frames += 1, window.queries += view.trees.queries, window.cells += view.trees.rows;
        played.candidates += view.pairs.size();
        std::vector<BodyPair>& left = played.left.emplace_back();
        for (const PairResult& pair : view.pairs)
            if (pair.verdict != Verdict::separate) left.push_back({index(pair.a), index(pair.b)});
    }
    played.hash = pipeline.hash();
    return played;
}

std::span<const std::pair<const char*, int>> level_models()
{
    static constexpr std::pair<const char*, int> models[] = {
        {"paper/lamp.obj", 600}, {"woody.obj", 1267},  {"paper/dragon.obj", 1496}, {"paper/bunny.obj", 1500},
        {"paper/cow.obj", 1500}, {"beetle.obj", 2053}, {"spot.obj", 5856}};
    return models;
}

std::pair<double, BatchWork> one_level(const OctantLevels& levels, const Method& method)
{
    const std::unique_ptr<OcclusionBackend> backend = method.backend();
    backend->attach(0, levels.surface());
    const std::vector<OctantRow> rows{{0, root_cell, all_triangles, false}};
    std::vector<OctantResult> results(1);
    std::pair<double, BatchWork> best{1e300, {}};
    for (int repeat = 0; repeat < 10; ++repeat) {
        const Clock::time_point from = Clock::now();
        const BatchWork work = backend->run(rows, 1, results);
        const double ms = milliseconds_since(from);
        if (ms < best.first) best = {ms, work};
    }
    return best;
}

PairsByFrame true_pairs(Scene scene, int every)
{
    PairsByFrame pairs;
    SceneTruth truth(scene, {.mode = Mode::surface});
    Mover mover;
    for (int frame = 0; frame < scene.frames; frame += every) {
        mover.move(scene, frame);
        truth.step();
        pairs.push_back(truth.colliding());
    }
    return pairs;
}

std::uint64_t missed(const PairsByFrame& truth, const PairsByFrame& pairs)
{
    std::uint64_t count = 0;
    for (std::size_t frame = 0; frame < truth.size(); ++frame)
        for (const BodyPair pair : truth[frame]) count += !std::ranges::binary_search(pairs[frame], pair);
    return count;
}

std::uint64_t count_pairs(const PairsByFrame& pairs)
{
    std::uint64_t count = 0;
    for (const std::vector<BodyPair>& frame : pairs) count += frame.size();
    return count;
}

} // namespace oncollide::tools
