#include <oncollide/pipeline/refine/gpu_refiner.hpp>

#include <algorithm>
#include <cmath>

#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/walks/walk_frame.hpp>
#include <oncollide/pipeline/settings_rules.hpp>

namespace oncollide {

namespace {

/// Trees on the GPU that no pair needed for this many frames are dropped.
constexpr std::uint32_t kept_frames = 60;
/// For WalkFrame: no distance ends it early.
constexpr double any_distance = std::numeric_limits<double>::quiet_NaN();

bool on_gpu(const Model& model)
{
    return model.kind() == Kind::mesh && !model.file() && model.obb_tree() && !model.obb_tree()->deformed();
}

constexpr std::size_t pairs_at_once = 512;
constexpr std::size_t prefetched_ahead = 8; ///< pairs whose memory is prefetched

float rounded_up(double x)
{
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

} // namespace

void GpuRefiner::refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                        std::span<Finding> results)
{
    if (!gpu_ || !gpu_->walks() || wants_kinds(context.settings) || context.stopped())
        return cpu_.refine(context, tasks, cache, results);
    sort(context, tasks, cache);
    if (mine_.size() < gpu_->worth_pairs()) return cpu_.refine(context, tasks, cache, results);
    run_batches(context, tasks, cache, results);
}

/// Divides the tasks between the GPU and the CPU.
void GpuRefiner::sort(const RefineContext& context, std::span<const PairTask> tasks, PairCache* cache)
{
    walks_.resize(tasks.size());
    parallel_chunks(tasks.size(), pairs_at_once, context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (cache && i + prefetched_ahead < end) prefetch_all_of((*cache)[tasks[i + prefetched_ahead].number]);
            const PairTask& task = tasks[i];
            walks_[i] = on_gpu(*task.a) && on_gpu(*task.b) &&
                        cpu_.needs_walk(context, task, cache ? &(*cache)[task.number] : nullptr);
        }
    });
    mine_.clear(), rest_.clear();
    for (std::uint32_t i = 0; i < tasks.size(); ++i) (walks_[i] ? mine_ : rest_).push_back(i);
}

void GpuRefiner::run_batches(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                             std::span<Finding> results)
{
    std::size_t next = 0; // of mine_; the pairs before it are decided or in open_
    open_.clear();
    try {
        gpu_->walks()->drop_unused(context.frame > kept_frames ? context.frame - kept_frames : 0);
        while (next < mine_.size() && !context.stopped()) batch(context, tasks, cache, results, next);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu) throw;
        gpu_->lose(error.what());
    }
    if (!context.stopped())
        for (; next < mine_.size(); ++next) open_.push_back(mine_[next]);
    if (!rest_.empty()) refine_on_cpu(context, tasks, cache, results, rest_);
    std::ranges::sort(open_);
    refine_on_cpu(context, tasks, cache, results, open_);
}

/// Runs the pairs from `next` on, up to the size of a batch, and moves `next` behind them once they are decided or
/// open.
void GpuRefiner::batch(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                       std::span<Finding> results, std::size_t& next)
{
    MeshWalks& walks = *gpu_->walks();
    const std::size_t end = std::min(next + MeshWalks::most_pairs, mine_.size());
    poses_.clear(2 * (end - next)), pairs_.clear(), in_batch_.clear(), trees_.clear(), held_.fill({});
    std::vector<std::uint32_t> without_tree;
    for (std::size_t k = next; k < end; ++k) {
        const PairTask& task = tasks[mine_[k]];
        const std::size_t before = pairs_.size();
        add(context, task, cache ? &(*cache)[task.number] : nullptr, mine_[k]);
        if (pairs_.size() == before) without_tree.push_back(mine_[k]);
    }
    Round round;
    const MeshWalkCounts before = walks.counts();
    round.submitted_ms = context.clock_ms();
    walks.submit(poses_.poses(), pairs_, context.settings.clearance > 0);
    if (!rest_.empty()) { // meanwhile
        refine_on_cpu(context, tasks, cache, results, rest_);
        rest_.clear();
    }
    round.waited_ms = context.clock_ms();
    const std::span<const MeshWalkResult> found = walks.collect();
    round.done_ms = context.clock_ms();
    unsure_.assign(walks.unsure().begin(), walks.unsure().end());
    const MeshWalkCounts now = walks.counts();
    parallel_chunks(found.size(), pairs_at_once, context.threads, [&](std::size_t from, std::size_t to, int) {
        for (std::size_t i = from; i < to; ++i) {
            if (cache && i + prefetched_ahead < to)
                prefetch_all_of((*cache)[tasks[in_batch_[i + prefetched_ahead]].number]);
            const PairTask& task = tasks[in_batch_[i]];
            take(context, task, cache ? &(*cache)[task.number] : nullptr, found[i], results[in_batch_[i]]);
        }
    });
    for (std::size_t i = 0; i < found.size(); ++i)
        if (found[i].verdict == MeshWalkVerdict::open) open_.push_back(in_batch_[i]);
    decide_unsure(context, tasks, cache, found, results);
    grow_wanted();
    open_.insert(open_.end(), without_tree.begin(), without_tree.end());
    next = end;

    round.rows = pairs_.size(), round.gpu_ms = now.gpu_ms() - before.gpu_ms(),
    round.wait_ms = now.wait_ms - before.wait_ms;
    round.bytes =
        now.bytes_up + now.bytes_down + now.tree_bytes - before.bytes_up - before.bytes_down - before.tree_bytes;
    context.rounds.push_back(round);
    TreeStats& trees = context.trees;
    trees.narrowed += static_cast<std::uint64_t>(
        std::ranges::count_if(found, [](const MeshWalkResult& r) { return r.verdict != MeshWalkVerdict::open; }));
    trees.gpu_bytes += round.bytes;
    trees.node_pairs += now.box_rows - before.box_rows,
        trees.triangle_pairs += now.triangle_pairs - before.triangle_pairs;
}

/// Adds a pair to the batch, if both trees are on the GPU.
void GpuRefiner::add(const RefineContext& context, const PairTask& task, PairMemory* memory, std::uint32_t number)
{
    const auto row = [&](unsigned side, const Model& model, const Eigen::Isometry3d& pose) {
        return poses_.row(side, &model, pose, [&] {
            HeldModel& held = held_[model.number() % held_.size()]; // of this batch
            if (held.model == &model) return held.tree;
            const auto tree = gpu_->walks()->hold(*model.obb_tree(), context.frame);
            if (tree && trees_.size() <= *tree) trees_.resize(*tree + std::size_t{1});
            if (tree) trees_[*tree] = model.obb_tree();
            held = {&model, tree};
            return tree;
        });
    };
    const PoseTable::Row a = row(0, *task.a, *task.pose_a), b = row(1, *task.b, *task.pose_b);
    if (!a.tree || !b.tree) return;
    MeshWalkPair added{a.pose, b.pose, *a.tree, *b.tree};
    if (const double enough = cpu_.open_within(context, task); enough > 0) added.enough = rounded_up(enough);
    if (memory && memory->met && context.settings.coherence) {
        const auto& [of_a, of_b] = memory->triangles;
        if (of_a < task.a->triangles() && of_b < task.b->triangles()) added.hint_a = of_a, added.hint_b = of_b;
    }
    pairs_.push_back(added), in_batch_.push_back(number);
}

/// Sets the result of a pair, unless it is open.
void GpuRefiner::take(const RefineContext& context, const PairTask& task, PairMemory* memory,
                      const MeshWalkResult& found, Finding& result) const
{
    switch (found.verdict) {
    case MeshWalkVerdict::open:
        return;
    case MeshWalkVerdict::unsure: // decide_unsure() ends it
        result = {Verdict::separate, ContactKind::unknown, double(found.bound)};
        return;
    case MeshWalkVerdict::meets:
        result = cpu_.end_walk(context, task, memory, TrianglePair{found.a, found.b}, 0);
        return;
    case MeshWalkVerdict::apart:
        result = cpu_.end_walk(context, task, memory, {}, double(found.bound));
        return;
    }
}

/// Decides the pairs of which only some pairs of triangles are left, by exact predicates.
void GpuRefiner::decide_unsure(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                               std::span<const MeshWalkResult> found, std::span<Finding> results)
{
    std::erase_if(unsure_, [&](const UnsureTriangles& u) { return found[u.pair].verdict != MeshWalkVerdict::unsure; });
    std::ranges::sort(unsure_, {}, [](const UnsureTriangles& u) { return std::array{u.pair, u.a, u.b}; });
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < unsure_.size(); ++i)
        if (i == 0 || unsure_[i].pair != unsure_[i - 1].pair) begins.push_back(i);
    begins.push_back(unsure_.size());
    parallel_chunks(begins.size() - 1, 8, context.threads, [&](std::size_t first, std::size_t last, int) {
        TriangleTests tests;
        std::vector<TrianglePair> triangles;
        for (std::size_t k = first; k < last; ++k) {
            const std::uint32_t number = in_batch_[unsure_[begins[k]].pair];
            const PairTask& task = tasks[number];
            triangles.clear();
            for (std::size_t i = begins[k]; i < begins[k + 1]; ++i) triangles.push_back({unsure_[i].a, unsure_[i].b});
            ObbTree &a = *task.a->obb_tree(), &b = *task.b->obb_tree();
            const RelativePose b_to_a(*task.pose_a, *task.pose_b);
            tests.start(a, b, b_to_a);
            std::optional<TrianglePair> met;
            tests.meeting(std::span<const TrianglePair>(triangles), [&](TrianglePair p) { return met = p, false; });
            double bound = results[number].bound;
            if (!met) {
                const WalkFrame frame(a, b, b_to_a, any_distance);
                bound = std::min(bound, frame.placed_at_least(tests.least_gap(frame.leaf_rounding)));
            }
            results[number] = cpu_.end_walk(context, task, cache ? &(*cache)[task.number] : nullptr, met, bound);
        }
    });
    context.trees.unsure_pairs += unsure_.size();
}

/// Grows the boxes that walks could not open.
void GpuRefiner::grow_wanted()
{
    for (const WantedNode& wanted : gpu_->walks()->wanted())
        if (wanted.tree < trees_.size() && trees_[wanted.tree]) trees_[wanted.tree]->child(wanted.node, wanted.box);
}

/// Refines these tasks on the CPU.
void GpuRefiner::refine_on_cpu(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                               std::span<Finding> results, std::vector<std::uint32_t>& which)
{
    if (which.empty()) return;
    tasks_.clear(), results_.clear();
    for (const std::uint32_t i : which) tasks_.push_back(tasks[i]), results_.push_back(results[i]);
    cpu_.refine(context, tasks_, cache, results_);
    for (std::size_t k = 0; k < which.size(); ++k) results[which[k]] = results_[k];
}

} // namespace oncollide
