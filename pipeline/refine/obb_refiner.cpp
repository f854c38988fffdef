#include <oncollide/pipeline/refine/obb_refiner.hpp>

#include <algorithm>

#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/hulls/outer_hull.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/pipeline/settings_rules.hpp>

namespace oncollide {

namespace {

constexpr std::size_t pairs_per_chunk = 64;
constexpr std::size_t pairs_per_look = 16; // per check whether the call should stop; chunks begin with a check

/// Tests of hulls or inner spheres without result are skipped for a while, longer after each such test in a row.
bool rests(PairMemory::Rest& rest)
{
    return rest.walks > 0 && (--rest.walks, true);
}
void let_rest(PairMemory::Rest& rest)
{
    rest.in_vain = std::min<std::uint8_t>(rest.in_vain + 1, 7);
    rest.walks = static_cast<std::uint8_t>((1u << rest.in_vain) - 1);
}

/// True if the hulls prove that two bodies are separate; stores the gap. Skips bodies that have not moved: the result
/// would be the same.
bool hulls_part(const PairTask& task, double beyond, PairMemory& memory, double& gap)
{
    const OuterHull *const a = task.a->hull(), *const b = task.b->hull();
    if (!a || !b || task.travel == memory.walked_at || rests(memory.hulls)) return false;
    const double needed = surely_separate(task, beyond);
    // A gap that will last half as long as the time since the last test is usually found along the stored direction;
    // finding the largest gap takes four times as long.
    const double enough = std::max(2 * needed, 0.5 * (task.travel - memory.walked_at));
    const HullGap found = hull_gap(*a, *b, RelativePose(*task.pose_a, *task.pose_b), memory.across, enough);
    memory.across = found.across;
    if (!(found.gap > needed)) return let_rest(memory.hulls), false;
    memory.hulls.in_vain = 0;
    memory.walked_at = task.travel;
    memory.part(found.gap, task.travel);
    gap = found.gap;
    return true;
}

/// Two boxes are tested as fast as their hulls would be.
bool are_boxes(const PairTask& task)
{
    const auto box = [](const Model& m) { return m.kind() == Kind::polytope && m.convex().core == Convex::Core::box; };
    return box(*task.a) && box(*task.b);
}

bool is_certain(const PairTask& task, double depth)
{
    return depth > 0 && depth > rounding_of(task);
}

/// True if the inner spheres overlap so deeply that the surfaces certainly meet; stores how far the bodies must move to
/// separate.
bool inner_spheres_meet(const PairTask& task, PairMemory& memory)
{
    const InnerSpheres *const a = task.a->inner_spheres(), *const b = task.b->inner_spheres();
    if (!a || !b || !memory.near || task.travel == memory.walked_at || rests(memory.inner_spheres)) return false;
    const double depth = meeting_depth(*a, *b, RelativePose(*task.pose_a, *task.pose_b));
    if (!is_certain(task, depth)) return let_rest(memory.inner_spheres), false;
    memory.inner_spheres.in_vain = 0;
    memory.meet(depth, task.travel);
    return true;
}

/// Makes the hulls and inner spheres of frequently traversed models, a few per frame, in the order of tasks.
void prepare_solids(std::span<const PairTask> tasks, PairCache& cache)
{
    constexpr int most = 4;
    int made = 0;
    for (const PairTask& task : tasks) {
        if (made == most) return;
        if ((task.a->has_solids() && task.b->has_solids()) || !task.a->has_triangles() || !task.b->has_triangles())
            continue;
        const bool near = cache[task.number].near;
        for (Model* model : {task.a, task.b}) made += model->prepare_solids(near);
    }
}

/// The position where two meshes met last, if both nodes still exist.
const MeetingHint<ObbTree, ObbTree>* place_of(const PairTask& task, const PairMemory& memory)
{
    const auto* place = std::get_if<MeetingHint<ObbTree, ObbTree>>(&memory.place);
    const bool stored = place && task.a->obb_tree() && task.b->obb_tree() && !task.a->file() && !task.b->file();
    return stored && place->holds_in(*task.a->obb_tree(), *task.b->obb_tree()) ? place : nullptr;
}

/// Calls visit(tree, triangle) for the triangles at which the traversal of a pair that met will start.
void each_hint(const PairTask& task, const PairMemory& memory, auto visit)
{
    const ObbTree *const a = task.a->obb_tree(), *const b = task.b->obb_tree();
    if (a && b) {
        if (place_of(task, memory)) visit(*a, memory.triangles.a), visit(*b, memory.triangles.b);
    } else if (const ObbTree* one = a ? a : b; one && one->is_large()) {
        const std::uint32_t triangle = memory.triangles.b; // in traversals, the body without triangles comes first
        if (triangle < one->mesh().triangles.size()) visit(*one, triangle);
    }
}

/// Prefetches data of the pairs that follow, one level of pointers per step, because they are scattered in memory.
class FetchAhead {
public:
    /// @param begin  the first pair that will be tested
    FetchAhead(std::span<const PairTask> tasks, PairCache* cache, std::size_t begin) : tasks_(tasks), cache_(cache)
    {
        for (std::size_t i = begin; i < begin + noted_ahead; ++i) note(i);
    }
    /// Fetches for the pairs after number i. Calls ascend by 1.
    void after_pair(std::size_t i);

private:
    static constexpr std::size_t pairs_a_step = 4, noted_ahead = 4 * pairs_a_step;
    const PairMemory* memory_of(std::size_t i) const { return cache_ ? &(*cache_)[tasks_[i].number] : nullptr; }
    /// Notes whether the bodies' data will be read: a remembered gap or depth usually decides.
    void note(std::size_t i)
    {
        if (i >= tasks_.size()) return;
        const PairMemory* const memory = memory_of(i);
        const double travel = tasks_[i].travel;
        const bool reads = !memory || !(std::max(memory->gap(travel), memory->depth(travel)) > 0);
        reads_ = (reads_ & ~(std::uint64_t{1} << i % 64)) | std::uint64_t{reads} << i % 64;
    }

    std::span<const PairTask> tasks_;
    PairCache* cache_;
    std::uint64_t reads_ = 0; ///< bit i % 64: of pair i, for the pairs noted last
};

void FetchAhead::after_pair(std::size_t i)
{
    if (const std::size_t later = i + 6 * pairs_a_step; cache_ && later < tasks_.size())
        prefetch_all_of((*cache_)[tasks_[later].number]);
    note(i + noted_ahead);
    if (reads_ == 0) return;
    const auto after = [&](std::size_t steps, auto visit) {
        const std::size_t later = i + steps * pairs_a_step;
        if (later < tasks_.size() && reads_ >> later % 64 & 1) visit(tasks_[later], memory_of(later));
    };
    const auto trees = [](const PairTask& task, auto visit) {
        for (const Model* model : {task.a, task.b})
            if (model->obb_tree()) visit(*model->obb_tree());
    };
    after(4, [](const PairTask& task, const PairMemory*) {
        task.a->prefetch(), task.b->prefetch();
        prefetch_all_of(*task.pose_a), prefetch_all_of(*task.pose_b);
    });
    after(3, [&](const PairTask& task, const PairMemory*) {
        trees(task, [](const ObbTree& tree) { prefetch_all_of(tree); });
    });
    after(2, [&](const PairTask& task, const PairMemory* memory) {
        trees(task, [](const ObbTree& tree) { tree.prefetch_table(); });
        if (!memory || !memory->met) return;
        each_hint(task, *memory, [](const ObbTree& tree, std::uint32_t triangle) { tree.prefetch_triangle(triangle); });
    });
    after(1, [&](const PairTask& task, const PairMemory* memory) {
        const bool met = memory && memory->met;
        const auto* const place = met ? place_of(task, *memory) : nullptr;
        if (place)
            task.a->obb_tree()->prefetch_node(place->a), task.b->obb_tree()->prefetch_node(place->b);
        else
            trees(task, [](const ObbTree& tree) { tree.prefetch_root(); });
        if (!met) return;
        each_hint(task, *memory, [](const ObbTree& tree, std::uint32_t triangle) { tree.prefetch_corners(triangle); });
    });
}

} // namespace

/// Decides the pair by its remaining gap or depth, inner spheres, outer hulls, or a traversal, in this order.
Finding ObbRefiner::refine(const RefineContext& context, const PairTask& task, PairMemory* memory, Worker& worker) const
{
    const Settings& settings = context.settings;
    const double tolerance = tolerance_of(task);
    const auto walk = [&](PairMemory* hints) {
        const PairTests& tests = tests_for(task);
        if (goal_ == Goal::near) return tests.near(worker.pairs, task, settings.clearance, tolerance, hints);
        const PairOptions options{settings.clearance, wants_kinds(settings), settings.ignore_touching};
        return tests.decide(worker.pairs, task, options, hints);
    };
    if (!memory) return walk(nullptr);
    const double beyond = settings.clearance + tolerance;
    double gap = memory->gap(task.travel);
    const bool kept = gap > beyond && gap > surely_separate(task, beyond);
    const auto sure = [&] { return is_sure(context, task, tolerance); };
    const bool shapes = task.a->is_bounded_shape() && task.b->is_bounded_shape();
    const bool met = is_certain(task, memory->depth(task.travel));
    if (!kept && !wants_kinds(settings) && (shapes ? met : sure() && (met || inner_spheres_meet(task, *memory)))) {
        worker.by_inner_spheres += !shapes, memory->meets = true;
        if (!settings.coherence) return walk(nullptr);
        if (goal_ == Goal::exact) return {Verdict::colliding, ContactKind::unknown, 0};
        return shapes ? bodies_overlap : Finding{Verdict::within, ContactKind::unknown, beyond};
    }
    const bool parted = !kept && !are_boxes(task) && hulls_part(task, beyond, *memory, gap);
    if (kept || parted) {
        ++(kept ? worker.by_gap : worker.by_hull), memory->meets = false, memory->by_hulls = parted;
        // Without coherence, traverse anyway.
        if (settings.coherence) return {Verdict::separate, ContactKind::unknown, gap};
        const Finding again = walk(nullptr);
        return again.verdict == Verdict::separate ? Finding{Verdict::separate, ContactKind::unknown, gap} : again;
    }
    const Finding result = walk(settings.coherence ? memory : nullptr);
    remember(task, result, *memory);
    return result;
}

/// Whether near() returns the same for all bodies that meet: the error exceeds the effect of rounding.
bool ObbRefiner::is_sure(const RefineContext& context, const PairTask& task, double tolerance) const
{
    return goal_ == Goal::exact || tolerance >= 2 * rounding_of(task) + 0x1p-16 * context.settings.clearance;
}

/// Updates the memory after a traversal.
void ObbRefiner::remember(const PairTask& task, const Finding& result, PairMemory& memory) const
{
    memory.walked_at = task.travel, memory.by_hulls = false;
    memory.near = memory.meets = result.verdict != Verdict::separate;
    if (result.verdict == Verdict::separate)
        memory.part(result.bound, task.travel);
    else
        memory.hulls.walks = std::max<std::uint8_t>(memory.hulls.walks, 1);
}

bool ObbRefiner::needs_walk(const RefineContext& context, const PairTask& task, const PairMemory* memory) const
{
    const double tolerance = tolerance_of(task), beyond = context.settings.clearance + tolerance;
    if (!is_sure(context, task, tolerance)) return false;
    if (!memory) return true;
    const double gap = memory->gap(task.travel);
    return !(gap > beyond && gap > surely_separate(task, beyond)) && !is_certain(task, memory->depth(task.travel));
}

double ObbRefiner::open_within(const RefineContext& context, const PairTask& task) const
{
    const double beyond = context.settings.clearance + tolerance_of(task);
    return beyond > 0 ? surely_separate(task, beyond) * (1 + 0x1p-10) : 0;
}

Finding ObbRefiner::end_walk(const RefineContext& context, const PairTask& task, PairMemory* memory,
                             const std::optional<TrianglePair>& met, double bound) const
{
    Finding result{Verdict::separate, ContactKind::unknown, bound};
    if (met && goal_ == Goal::exact)
        result = {Verdict::colliding, ContactKind::unknown, 0};
    else if (met)
        result = {Verdict::within, ContactKind::unknown, context.settings.clearance + tolerance_of(task)};
    if (!memory) return result;
    if (context.settings.coherence) {
        memory->met = met.has_value();
        if (met) memory->triangles = *met;
    }
    remember(task, result, *memory);
    return result;
}

/// The same, but if a chunk of a cooked file is missing, the pair keeps its previous result, which is still true.
Finding ObbRefiner::refine_there(const RefineContext& context, const PairTask& task, const Finding& known,
                                 PairMemory* memory, Worker& worker) const
{
    if (!task.a->file() && !task.b->file()) return refine(context, task, memory, worker);
    const std::optional<PairMemory> before = memory ? std::optional(*memory) : std::nullopt;
    const auto begin_again = [&] {
        if (before) *memory = *before;
    };
    try {
        return models_.with_room([&] {
            begin_again();
            return refine(context, task, memory, worker);
        });
    } catch (const ChunkFault& fault) {
        begin_again();
        models_.note(fault.what());
        return known;
    }
}

void ObbRefiner::refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                        std::span<Finding> results)
{
    if (cache) prepare_solids(tasks, *cache);
    while (workers_.size() < static_cast<std::size_t>(std::max(context.threads, 1))) workers_.emplace_back();
    parallel_chunks(tasks.size(), pairs_per_chunk, context.threads,
                    [&](std::size_t begin, std::size_t end, int thread) {
                        Worker& worker = workers_[static_cast<std::size_t>(thread)];
                        FetchAhead ahead(tasks.first(end), cache, begin);
                        for (std::size_t i = begin; i < end; ++i) {
                            if (i % pairs_per_look == 0 && context.stopped()) return;
                            ahead.after_pair(i);
                            PairMemory* memory = cache ? &(*cache)[tasks[i].number] : nullptr;
                            results[i] = refine_there(context, tasks[i], results[i], memory, worker);
                        }
                    });
    context.trees.narrowed += tasks.size();
    for (Worker& worker : workers_) {
        const Traversal::Counts counts = worker.pairs.counts();
        context.trees.node_pairs += counts.box_rows, context.trees.triangle_pairs += counts.triangles;
        context.trees.unsure_pairs += counts.unsure, context.trees.by_witness += counts.hints_held;
        worker.pairs.reset_counts();
        context.trees.by_gap += worker.by_gap, worker.by_gap = 0;
        context.trees.by_hull += worker.by_hull, worker.by_hull = 0;
        context.trees.by_inner_spheres += worker.by_inner_spheres, worker.by_inner_spheres = 0;
    }
}

} // namespace oncollide
