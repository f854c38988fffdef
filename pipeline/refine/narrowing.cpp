#include <oncollide/pipeline/refine/narrowing.hpp>

#include <algorithm>
#include <atomic>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/pipeline/settings_rules.hpp>

namespace oncollide {

namespace {

constexpr std::size_t tasks_at_once = 1024;

} // namespace

Narrowing::Narrowing(const Settings& settings, ModelStore& models, Level level, GpuPairs* gpu)
    : models_(models), level_(level), dispatch_(settings), spheres_(models), boxes_(models, ObbRefiner::Goal::near),
      exact_(models, ObbRefiner::Goal::exact), gpu_boxes_(boxes_, gpu), gpu_exact_(exact_, gpu), fcl_(exact_),
      containment_(models)
{
}

/// Queries whose trees exist run concurrently.
bool Narrowing::sort_if_there(const RefineContext& context, std::span<const PairTask> tasks)
{
    const auto lock = context.walking();
    std::atomic<bool> there{true};
    parallel_chunks(tasks.size(), tasks_at_once, context.threads, [&](std::size_t begin, std::size_t end, int) {
        if (there && !std::ranges::all_of(tasks.subspan(begin, end - begin), [&](const PairTask& t) {
                return dispatch_.there(level_, models_, *t.a, *t.b);
            }))
            there = false;
    });
    if (there) give_out(context, tasks, context.threads);
    return there;
}

void Narrowing::sort_out(const RefineContext& context, std::span<const PairTask> tasks)
{
    if ((context.guard || context.threads > 1) && sort_if_there(context, tasks)) return;
    const auto alone = context.changing();
    give_out(context, tasks, 1);
}

/// @param threads  1 unless all trees exist
void Narrowing::give_out(const RefineContext& context, std::span<const PairTask> tasks, int threads)
{
    refiners_.resize(tasks.size());
    parallel_chunks(tasks.size(), tasks_at_once, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i)
            refiners_[i] = dispatch_.of(level_, models_, *tasks[i].a, *tasks[i].b, context.frame);
    });
    for (auto& list : taken_) list.clear();
    for (std::uint32_t i = 0; i < tasks.size(); ++i) taken_[static_cast<std::size_t>(refiners_[i])].push_back(i);
}

void Narrowing::refine(Refiner which, PairRefiner& refiner, RefineContext& context, std::span<const PairTask> tasks,
                       PairCache* cache, std::span<Finding> results)
{
    const std::vector<std::uint32_t>& mine = taken_[static_cast<std::size_t>(which)];
    if (mine.empty()) return;
    if (mine.size() == tasks.size()) return refiner.refine(context, tasks, cache, results);
    tasks_.clear(), results_.clear();
    for (std::uint32_t i : mine) tasks_.push_back(tasks[i]), results_.push_back(results[i]);
    refiner.refine(context, tasks_, cache, results_);
    for (std::size_t k = 0; k < mine.size(); ++k) results[mine[k]] = results_[k];
}

/// Reports files that cannot be read. If the file contradicts its own outline, even the box is unreliable, so the bound
/// becomes the largest possible distance.
void Narrowing::tell_unreadable(const Settings& settings, const PairTask& task, Finding& result) const
{
    constexpr double beyond_all = 1e16; // coordinates and poses are within 1e15 m
    for (const Model* model : {task.a, task.b}) {
        if (model->unreadable().empty()) continue;
        if (level_ == Level::exact || !exact_runs(settings)) models_.note(model->unreadable());
        if (model->cooked()->contradicts_outline()) result.bound = beyond_all;
    }
}

bool Narrowing::run_if_there(RefineContext& context, std::span<const PairTask> tasks, std::span<Finding> results)
{
    if (!sort_if_there(context, tasks)) return false;
    run_sorted(context, tasks, nullptr, results);
    return true;
}

void Narrowing::run_sorted(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                           std::span<Finding> results)
{
    refine(Refiner::spheres, spheres_, context, tasks, cache, results);
    refine(Refiner::obbs, gpu_boxes_, context, tasks, cache, results);
    refine(Refiner::exact, gpu_exact_, context, tasks, cache, results);
    refine(Refiner::fcl, fcl_, context, tasks, cache, results);
    for (std::uint32_t i : taken_[static_cast<std::size_t>(Refiner::no_room)]) {
        if (results[i].verdict == Verdict::within) results[i].verdict = Verdict::undecided;
        tell_unreadable(context.settings, tasks[i], results[i]);
    }
    if (level_ == Level::exact && context.stopped()) // pairs not tested before the stop
        for (Finding& result : results)
            if (result.verdict == Verdict::within && result.kind == ContactKind::unknown)
                result.verdict = Verdict::undecided;

    if (context.settings.mode != Mode::solid) return;
    apart_.resize(tasks.size());
    for (std::size_t i = 0; i < tasks.size(); ++i)
        apart_[i] = decided(i) && (results[i].verdict == Verdict::separate || results[i].kind == ContactKind::near);
    containment_.find(context, tasks, apart_, results);
}

void BothLevels::run(RefineContext& context, std::span<const PairTask> tasks, std::span<Finding> results)
{
    if (exact_alone_ && exact_.run_if_there(context, tasks, results)) return;
    if (!settings_.skip.contains(StageId::refine)) refine_.run(context, tasks, nullptr, results);
    if (!exact_runs(settings_)) return;
    open_.clear(), tasks_.clear(), results_.clear();
    for (std::uint32_t i = 0; i < tasks.size(); ++i)
        if (is_open(results[i].verdict)) open_.push_back(i), tasks_.push_back(tasks[i]), results_.push_back(results[i]);
    exact_.run(context, tasks_, nullptr, results_);
    for (std::size_t k = 0; k < open_.size(); ++k) results[open_[k]] = results_[k];
}

} // namespace oncollide
