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

constexpr std::size_t pairs_at_once = 256;
constexpr std::size_t prefetched_ahead = 8; ///< pairs whose memory is prefetched

float rounded_up(double x)
{
    return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

} // namespace

void GpuRefiner::refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                        std::span<Finding> results)
{
    const Call call{context, tasks, cache, results};
    if (!gpu_ || !gpu_->walks() || wants_kinds(context.settings) || context.stopped() ||
        find_walks(call) < gpu_->worth_pairs())
        return cpu_.refine(context, tasks, cache, results);
    try {
        divide(call);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu) throw;
        gpu_->lose(error.what());
        return cpu_.refine(context, tasks, cache, results);
    }
    run_batches(call);
}

/// Sets walks_ and trees_. Returns the number of pairs that the GPU would decide.
std::size_t GpuRefiner::find_walks(const Call& call)
{
    const GpuStage stage(gpu_->host().sort_ms);
    walks_.resize(call.tasks.size()), trees_.resize(call.tasks.size());
    parallel_chunks(call.tasks.size(), pairs_at_once, call.context.threads,
                    [&](std::size_t begin, std::size_t end, int) {
                        for (std::size_t i = begin; i < end; ++i) {
                            if (call.cache && i + prefetched_ahead < end)
                                prefetch_all_of(*call.memory_of(call.tasks[i + prefetched_ahead]));
                            const PairTask& task = call.tasks[i];
                            walks_[i] = on_gpu(*task.a) && on_gpu(*task.b) &&
                                        cpu_.needs_walk(call.context, task, call.memory_of(task));
                            trees_[i] = {task.a->number(), task.b->number()};
                        }
                    });
    return static_cast<std::size_t>(std::ranges::count(walks_, 1));
}

/// Brings trees to the GPU, and divides the tasks between the GPU and the CPU.
void GpuRefiner::divide(const Call& call)
{
    const GpuStage stage(gpu_->host().trees_ms);
    MeshWalks& walks = *gpu_->walks();
    const std::uint32_t frame = call.context.frame;
    walks.drop_unused(frame > kept_frames ? frame - kept_frames : 0);
    held_.begin();
    mine_.clear(), rest_.clear(), open_.clear();
    for (std::uint32_t i = 0; i < call.tasks.size(); ++i) {
        if (!walks_[i]) {
            rest_.push_back(i);
            continue;
        }
        const std::uint32_t a = held_.hold(walks, trees_[i][0], call.tasks[i].a, frame),
                            b = held_.hold(walks, trees_[i][1], call.tasks[i].b, frame);
        trees_[i] = {a, b};
        (a != GpuTrees::none && b != GpuTrees::none ? mine_ : rest_).push_back(i);
    }
}

/// Keeps two batches under way while there are pairs.
void GpuRefiner::run_batches(const Call& call)
{
    RefineContext& context = call.context;
    GpuHostTimes& host = gpu_->host();
    std::size_t submitted = 0, taken = 0; // of mine_; the pairs before `taken` are decided or in open_
    const auto next = [&](std::size_t from) {
        return std::span(mine_).subspan(from, std::min(MeshWalks::most_pairs, mine_.size() - from));
    };
    std::vector<Round> rounds;
    try {
        MeshWalks& walks = *gpu_->walks();
        for (;;) {
            while (submitted < mine_.size() && submitted - taken <= MeshWalks::most_pairs && !context.stopped()) {
                const auto which = next(submitted);
                fill(call, which, walks.begin(which.size()));
                const GpuStage stage(host.submit_ms);
                rounds.push_back({});
                rounds.back().submitted_ms = context.clock_ms();
                walks.submit(context.settings.clearance > 0);
                submitted += which.size();
            }
            if (taken == submitted) break;
            {
                const GpuStage stage(host.meanwhile_ms);
                refine_on_cpu(call, rest_);
                rest_.clear();
                held_.grow_missed(context.threads);
            }
            const auto which = next(taken);
            take_batch(call, which, rounds[taken / MeshWalks::most_pairs]);
            taken += which.size();
        }
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::no_gpu) throw;
        gpu_->lose(error.what());
    }
    rounds.resize((taken + MeshWalks::most_pairs - 1) / MeshWalks::most_pairs);
    context.rounds.insert(context.rounds.end(), rounds.begin(), rounds.end());
    if (!context.stopped()) open_.insert(open_.end(), mine_.begin() + std::ptrdiff_t(taken), mine_.end());
    const GpuStage stage(host.rest_ms);
    refine_on_cpu(call, rest_);
    refine_on_cpu(call, open_);
}

/// Writes the pairs of tasks, each at its place in the batch.
void GpuRefiner::fill(const Call& call, std::span<const std::uint32_t> which, std::span<MeshWalkPair> pairs) const
{
    const GpuStage stage(gpu_->host().fill_ms);
    parallel_chunks(which.size(), pairs_at_once, call.context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (i + prefetched_ahead < end) {
                const PairTask& later = call.tasks[which[i + prefetched_ahead]];
                prefetch_all_of(*later.pose_a), prefetch_all_of(*later.pose_b);
                if (call.cache) prefetch(&call.memory_of(later)->met, sizeof(bool) + sizeof(TrianglePair));
            }
            pairs[i] = pair_of(call, which[i]);
        }
    });
}

MeshWalkPair GpuRefiner::pair_of(const Call& call, std::uint32_t number) const
{
    const PairTask& task = call.tasks[number];
    MeshWalkPair pair(RelativePose(*task.pose_a, *task.pose_b), trees_[number][0], trees_[number][1]);
    if (const double enough = cpu_.open_within(call.context, task); enough > 0) pair.enough = rounded_up(enough);
    const PairMemory* const memory = call.memory_of(task);
    if (memory && memory->met && call.context.settings.coherence) {
        const auto& [of_a, of_b] = memory->triangles;
        if (of_a < task.a->triangles() && of_b < task.b->triangles()) pair.hint_a = of_a, pair.hint_b = of_b;
    }
    return pair;
}

/// Waits for a batch of these tasks, and sets their results or adds them to open_.
void GpuRefiner::take_batch(const Call& call, std::span<const std::uint32_t> which, Round& round)
{
    RefineContext& context = call.context;
    MeshWalks& walks = *gpu_->walks();
    round.waited_ms = context.clock_ms();
    const std::span<const MeshWalkResult> found = walks.collect();
    round.done_ms = context.clock_ms();
    const GpuStage stage(gpu_->host().take_ms);
    held_.miss(walks.wanted());
    parallel_chunks(found.size(), pairs_at_once, context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (call.cache && i + prefetched_ahead < end)
                prefetch_all_of(*call.memory_of(call.tasks[which[i + prefetched_ahead]]));
            take(call, which[i], found[i]);
        }
    });
    decide_unsure(call, which, found);
    std::uint64_t decided = found.size();
    std::size_t listed = 0; // in begins_
    for (std::uint32_t i = 0; i < found.size(); ++i) {
        if (found[i].verdict() != MeshWalkVerdict::open) continue;
        --decided;
        while (listed < settled_.size() && unsure_[begins_[listed]].pair < i) ++listed;
        const bool settled = listed < settled_.size() && unsure_[begins_[listed]].pair == i && settled_[listed];
        if (!settled) open_.push_back(which[i]);
    }
    const MeshWalkCounts& counts = walks.batch();
    round.rows = found.size(), round.gpu_ms = counts.gpu_ms(), round.wait_ms = counts.wait_ms;
    round.bytes = counts.bytes_up + counts.bytes_down + counts.tree_bytes;
    context.trees.narrowed += decided, context.trees.gpu_bytes += round.bytes;
    context.trees.node_pairs += counts.box_rows, context.trees.triangle_pairs += counts.triangle_pairs;
}

/// Sets the result of a pair, unless it is open.
void GpuRefiner::take(const Call& call, std::uint32_t number, const MeshWalkResult& found) const
{
    const PairTask& task = call.tasks[number];
    Finding& result = call.results[number];
    switch (found.verdict()) {
    case MeshWalkVerdict::open:
    case MeshWalkVerdict::unsure: // decide_unsure() ends it
        return;
    case MeshWalkVerdict::meets:
        result = cpu_.end_walk(call.context, task, call.memory_of(task), TrianglePair{found.a, found.b}, 0);
        return;
    case MeshWalkVerdict::apart:
        result = cpu_.end_walk(call.context, task, call.memory_of(task), {}, double(found.bound));
        return;
    }
}

/// Tests the triangles that are not certain by exact predicates. Decides the pairs of which only these are left, and
/// open pairs of which two of them meet.
void GpuRefiner::decide_unsure(const Call& call, std::span<const std::uint32_t> which,
                               std::span<const MeshWalkResult> found)
{
    const std::span<const UnsureTriangles> listed = gpu_->walks()->unsure();
    unsure_.clear(), begins_.clear();
    std::copy_if(listed.begin(), listed.end(), std::back_inserter(unsure_),
                 [&](const UnsureTriangles& u) { return found[u.pair].verdict() != MeshWalkVerdict::meets; });
    std::ranges::sort(unsure_, {}, [](const UnsureTriangles& u) { return std::array{u.pair, u.a, u.b}; });
    for (std::size_t i = 0; i < unsure_.size(); ++i)
        if (i == 0 || unsure_[i].pair != unsure_[i - 1].pair) begins_.push_back(i);
    settled_.assign(begins_.size(), 0);
    begins_.push_back(unsure_.size());
    parallel_chunks(settled_.size(), 8, call.context.threads, [&](std::size_t first, std::size_t last, int) {
        TriangleTests tests;
        for (std::size_t k = first; k < last; ++k) {
            const auto of_pair = std::span(unsure_).subspan(begins_[k], begins_[k + 1] - begins_[k]);
            const std::uint32_t pair = of_pair.front().pair;
            settled_[k] = decide_unsure(call, which[pair], of_pair, found[pair], tests);
        }
    });
    call.context.trees.unsure_pairs += unsure_.size();
}

/// Returns false if the pair stays open.
bool GpuRefiner::decide_unsure(const Call& call, std::uint32_t number, std::span<const UnsureTriangles> listed,
                               const MeshWalkResult& found, TriangleTests& tests) const
{
    const PairTask& task = call.tasks[number];
    std::vector<TrianglePair> triangles;
    for (const UnsureTriangles& u : listed) triangles.push_back({u.a, u.b});
    ObbTree &a = *task.a->obb_tree(), &b = *task.b->obb_tree();
    const RelativePose b_to_a(*task.pose_a, *task.pose_b);
    tests.start(a, b, b_to_a);
    std::optional<TrianglePair> met;
    tests.meeting(std::span<const TrianglePair>(triangles), [&](TrianglePair p) { return met = p, false; });
    if (!met && found.verdict() == MeshWalkVerdict::open) return false;
    double bound = double(found.bound);
    if (!met) {
        const WalkFrame frame(a, b, b_to_a, any_distance);
        bound = std::min(bound, frame.placed_at_least(tests.least_gap(frame.leaf_rounding)));
    }
    call.results[number] = cpu_.end_walk(call.context, task, call.memory_of(task), met, bound);
    return true;
}

/// Refines these tasks on the CPU, in their order.
void GpuRefiner::refine_on_cpu(const Call& call, std::vector<std::uint32_t>& which)
{
    if (which.empty()) return;
    std::ranges::sort(which);
    tasks_.clear(), results_.clear();
    for (const std::uint32_t i : which) tasks_.push_back(call.tasks[i]), results_.push_back(call.results[i]);
    cpu_.refine(call.context, tasks_, call.cache, results_);
    for (std::size_t k = 0; k < which.size(); ++k) call.results[which[k]] = results_[k];
}

} // namespace oncollide
