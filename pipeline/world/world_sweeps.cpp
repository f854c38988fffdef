// World: when moving models first meet, safe from many threads at once.
#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>
#include <oncollide/pipeline/world/sweep_pairs.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

void WorldImpl::check_sweep(const char* call, const SweepOptions& options)
{
    constexpr double least = 1e-12;
    const auto check = [&](const char* name, double value) {
        if (!(value >= least))
            throw Error(ErrorKind::usage, fmt::format("{}: {} {}: must be at least {:g}", call, name, value, least));
    };
    check("time_tolerance", options.time_tolerance), check("gap_tolerance", options.gap_tolerance);
    if (options.most_steps < 1)
        throw Error(ErrorKind::usage, fmt::format("{}: most_steps {}: must be at least 1", call, options.most_steps));
    if (options.stop > SweepStop::press)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: stop {}: must be contact, touch or press", call, static_cast<int>(options.stop)));
}

SweepTask WorldImpl::task_of(const MovingModel& a, const MovingModel& b, const SweepOptions& options)
{
    return {&check_model(a.model), &check_model(b.model),       &a.motion, &b.motion, options,
            settings.clearance,    settings.mode == Mode::solid};
}

SweepResult WorldImpl::sweep(QueryWorker& worker, const SweepTask& task)
{
    if (worker.context.stopped()) return {};
    return sweep_pair(models, worker.pairs, task);
}

SweepResult Pairs::sweep(const MovingModel& a, const MovingModel& b, const SweepOptions& options) const
{
    WorldImpl& p = *world_;
    p.check_sweep("sweep", options);
    const SweepTask task = p.task_of(a, b, options);
    const PairTask of_trees{0, task.a, task.b, nullptr, nullptr};
    p.need_trees({&of_trees, 1});
    WorldImpl::Lease worker(p);
    return p.sweep(*worker, task);
}

/// The pairs, checked, with their trees.
std::vector<SweepTask> WorldImpl::ready_tasks(std::span<const PairOf<MovingModel>> pairs, const SweepOptions& options)
{
    std::vector<SweepTask> tasks;
    std::vector<PairTask> of_trees;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        naming("pair", i, nullptr, [&] { tasks.push_back(task_of(pairs[i].a, pairs[i].b, options)); });
        of_trees.push_back({0, tasks.back().a, tasks.back().b, nullptr, nullptr});
    }
    need_trees(of_trees);
    return tasks;
}

void Pairs::sweep(std::span<const PairOf<MovingModel>> pairs, const SweepOptions& options,
                  std::span<SweepResult> found) const
{
    WorldImpl& p = *world_;
    same_room("sweep", "pairs", pairs.size(), "results", found.size());
    p.check_sweep("sweep", options);
    const std::vector<SweepTask> tasks = p.ready_tasks(pairs, options);
    p.each(tasks.size(), 4, [&](auto& worker, std::size_t i) { found[i] = p.sweep(worker, tasks[i]); });
}

void WorldAccess::clear_until(const World& world, std::span<const PairOf<MovingModel>> pairs,
                              std::span<const double> margins, std::span<double> until)
{
    WorldImpl& p = world.impl();
    same_room("clear_until", "pairs", pairs.size(), "margins", margins.size());
    same_room("clear_until", "pairs", pairs.size(), "results", until.size());
    check_reaches("clear_until: margin", margins);
    std::vector<SweepTask> tasks = p.ready_tasks(pairs, {});
    for (std::size_t i = 0; i < pairs.size(); ++i) tasks[i].clearance += margins[i], tasks[i].bound_only = true;
    p.each(tasks.size(), 16, [&](auto& worker, std::size_t i) { until[i] = p.sweep(worker, tasks[i]).clear_until; });
}

namespace {

/// True if a sweep certainly ends there.
bool ends_there(const SweepResult& r, const SweepOptions& options)
{
    const bool certain =
        r.verdict == Verdict::colliding || (r.verdict == Verdict::within && r.kind == ContactKind::near);
    return certain || (options.stop == SweepStop::touch && r.verdict == Verdict::within);
}

} // namespace

/// Overwrites `hits` with the contacts of a moving model: all of them, or only the contacts that may be the first.
/// Contacts that never press are not hits if the options ignore them. Returns a time until which these are free.
double WorldImpl::find_casts(QueryWorker& w, const MovingModel& model, const CollisionFilter& filter,
                             const SweepOptions& options, bool all, std::vector<SweepHit>& hits)
{
    Model& mine = check_model(model.model);
    w.boxes.assign(1, grown(mine.bounds().box(model.motion), settings.clearance));
    broad->query(bodies.columns(), w.boxes, w.hits);
    w.tasks.clear(), hits.clear();
    for (const AabbHit& hit : w.hits)
        if (allows(filter, hit.body)) w.tasks.push_back({hit.body, &mine, &bodies.model(hit.body), nullptr, nullptr});
    need_trees(w.tasks);
    double until = 1, free = 1;
    for (const PairTask& pair : w.tasks) {
        const RigidMotion rest(bodies.pose(pair.number));
        SweepTask task{&mine, pair.b, &model.motion, &rest, options, settings.clearance, settings.mode == Mode::solid};
        task.until = until;
        const SweepResult found = sweep(w, task);
        if (found.verdict == Verdict::separate) continue;
        const bool ends = ends_there(found, options);
        if (!ends && options.stop == SweepStop::press && found.verdict == Verdict::within &&
            found.grazes_until >= until) {
            free = std::min(free, found.clear_until);
            continue;
        }
        hits.push_back({found, bodies.id(pair.number)});
        if (!all && ends) until = std::min(until, found.contact_by);
    }
    std::ranges::sort(hits, {}, [](const SweepHit& hit) { return std::pair(hit.clear_until, hit.body.slot); });
    return free;
}

SweepHit WorldImpl::first_cast(QueryWorker& w, const MovingModel& model, const CollisionFilter& filter,
                               const SweepOptions& options)
{
    const double free = find_casts(w, model, filter, options, false, w.sweeps);
    SweepHit first;
    if (w.sweeps.empty()) {
        first.verdict = Verdict::separate, first.clear_until = free, first.grazes_until = 1;
        return first;
    }
    // The first contact that ends a sweep comes before gaps that rounding hides; an undecided pair may come first.
    const auto rank = [&](const SweepHit& hit) { return std::pair(!ends_there(hit, options), hit.contact_by); };
    first = *std::ranges::min_element(w.sweeps, {}, rank);
    const auto open = std::ranges::find(w.sweeps, Verdict::undecided, &SweepHit::verdict);
    if (open != w.sweeps.end() && open->clear_until < first.grazes_until) first = *open;
    const SweepHit& earliest = w.sweeps.front();
    if (earliest.clear_until < first.clear_until && earliest.verdict == Verdict::within) first.gap = earliest.gap;
    first.clear_until = std::min(earliest.clear_until, free);
    for (const SweepHit& hit : w.sweeps) first.grazes_until = std::min(first.grazes_until, hit.grazes_until);
    return first;
}

SweepHit Space::cast(const MovingModel& model, const CollisionFilter& filter, const SweepOptions& options) const
{
    SweepHit hit;
    cast(std::span(&model, 1), filter, options, std::span(&hit, 1));
    return hit;
}

void Space::cast(std::span<const MovingModel> models, const CollisionFilter& filter, const SweepOptions& options,
                 std::span<SweepHit> hits) const
{
    WorldImpl& p = *world_;
    same_room("cast", "models", models.size(), "hits", hits.size());
    p.check_sweep("cast", options);
    for (std::size_t i = 0; i < models.size(); ++i) naming("cast", i, nullptr, [&] { p.check_model(models[i].model); });
    p.bring_up_to_date();
    p.each(models.size(), 4,
           [&](auto& worker, std::size_t i) { hits[i] = p.first_cast(worker, models[i], filter, options); });
}

std::vector<SweepHit> Space::cast_all(const MovingModel& model, const CollisionFilter& filter,
                                      const SweepOptions& options) const
{
    Lists<SweepHit> hits;
    cast_all(std::span(&model, 1), filter, options, hits);
    return std::move(hits.items);
}

void Space::cast_all(std::span<const MovingModel> models, const CollisionFilter& filter, const SweepOptions& options,
                     Lists<SweepHit>& hits) const
{
    WorldImpl& p = *world_;
    p.check_sweep("cast_all", options);
    for (std::size_t i = 0; i < models.size(); ++i)
        naming("cast_all", i, nullptr, [&] { p.check_model(models[i].model); });
    p.bring_up_to_date();
    p.gather(models.size(), 4, hits, [&](auto& worker, std::size_t i, auto& list) {
        p.find_casts(worker, models[i], filter, options, true, worker.sweeps);
        list.insert(list.end(), worker.sweeps.begin(), worker.sweeps.end());
    });
}

} // namespace oncollide
