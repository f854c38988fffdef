// World: const queries about pairs, safe from many threads at once.
#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/convex_distance.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {

namespace {

constexpr std::size_t largest_batch = 8192; // pairs refined together: their parked work bounds the memory

using RowByRow = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>;

/// Entry i of a column of which each entry has `width` numbers; a column of one entry serves all.
template <class Number>
const Number* entry(std::span<const Number> column, std::size_t width, std::size_t i)
{
    return column.data() + (column.size() > width ? width * i : 0);
}

/// The number of pairs in columns: the entries of each column, except of columns whose one entry serves all pairs.
std::size_t count_of(const char* call, const PairOfColumns& pairs)
{
    const struct {
        const char* name;
        std::size_t numbers, width;
    } columns[] = {{"a.models", pairs.a.models.size(), 1},
                   {"a.poses", pairs.a.poses.size(), 16},
                   {"b.models", pairs.b.models.size(), 1},
                   {"b.poses", pairs.b.poses.size(), 16}};
    std::size_t count = 1;
    for (const auto& column : columns)
        if (column.numbers != column.width) count = column.numbers / column.width;
    for (const auto& [name, numbers, width] : columns)
        if (numbers != width && numbers != width * count)
            throw Error(ErrorKind::usage, fmt::format("{}: column {}: {} numbers; must be {}, or {} for all of the {} "
                                                      "pairs",
                                                      call, name, numbers, width * count, width, count));
    return count;
}
template <class Pair>
std::size_t count_of(const char*, std::span<const Pair> pairs)
{
    return pairs.size();
}

/// A lower bound on the distance of points of two AABBs; 0 if they overlap.
double least_gap(const Aabb& a, const Aabb& b)
{
    const Eigen::Vector3d gap = (a.min - b.max).cwiseMax(b.min - a.max).cwiseMax(0);
    return gap.norm() * (1 - 0x1p-50);
}

} // namespace

void same_room(const char* call, const char* items, std::size_t count, const char* results, std::size_t room)
{
    if (count != room)
        throw Error(ErrorKind::usage,
                    fmt::format("{}: {} {}, room for {} {}; must be of one length", call, count, items, room, results));
}

WorldImpl::QueryWorker::QueryWorker(WorldImpl& impl, const Settings& settings, GpuPairs* gpu)
    : levels(settings, impl.models, gpu), context{.settings = settings,
                                                  .trees = {},
                                                  .rounds = {},
                                                  .began = {},
                                                  .guard = &impl.guard}
{
}

WorldImpl::~WorldImpl() = default;

void WorldImpl::check_side(const PairSide& side)
{
    if (!side.placed()) {
        slot_of(side.body());
        return;
    }
    check_model(side.placed()->model);
    check_pose("", side.placed()->pose);
}

PairTask WorldImpl::task_of(const PairSide& a, const PairSide& b)
{
    PairTask task{};
    task.slack = 0;
    const auto fill = [&](const PairSide& side, Model*& model, const Eigen::Isometry3d*& pose) {
        if (const PlacedModel* placed = side.placed())
            model = &models[placed->model], pose = &placed->pose, task.slack += stretch(placed->pose);
        else
            model = &bodies.model(side.body().slot), pose = &bodies.pose(side.body().slot),
            task.slack += bodies.stretch(side.body().slot);
    };
    fill(a, task.a, task.pose_a), fill(b, task.b, task.pose_b);
    return task;
}

PairTask WorldImpl::checked_task(const PairSide& a, const PairSide& b)
{
    check_side(a), check_side(b);
    return task_of(a, b);
}

/// Pair first + k of columns. Its poses are written to poses[2 k] and [2 k + 1], but a pose that serves all pairs only
/// for k = 0.
PairTask WorldImpl::task_of(const PairOfColumns& pairs, std::size_t first, std::size_t k, Eigen::Isometry3d* poses)
{
    PairTask task{};
    const auto side = [&](const char* name, const ModelColumns& of, Eigen::Isometry3d* pose, Model*& model) {
        const ModelId id = *entry(of.models, 1, first + k);
        const bool written = k == 0 || of.poses.size() > 16;
        if (written) pose += 2 * k, pose->matrix() = RowByRow(entry(of.poses, 16, first + k));
        naming("pair", first + k, name, [&] {
            check_model(id);
            if (written) check_pose("", *pose);
        });
        model = &models[id];
        return pose;
    };
    task.pose_a = side("a", pairs.a, poses, task.a), task.pose_b = side("b", pairs.b, poses + 1, task.b);
    return task;
}

/// Sets worker.tasks to the pairs from `first` on.
template <class Form>
void WorldImpl::take_tasks(QueryWorker& worker, const Form& pairs, std::size_t first, std::size_t many)
{
    constexpr bool columns = std::is_same_v<Form, PairOfColumns>;
    worker.tasks.resize(many);
    if constexpr (columns) worker.poses.resize(2 * many);
    parallel_chunks(many, 256, worker.context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t k = begin; k < end; ++k) {
            if constexpr (columns)
                worker.tasks[k] = task_of(pairs, first, k, worker.poses.data());
            else
                worker.tasks[k] = task_of(pairs[first + k].a, pairs[first + k].b);
            worker.tasks[k].number = static_cast<std::uint32_t>(k);
        }
    });
}

/// Calls work(worker, first), whose worker.tasks are pairs `first` and following, on the World's threads. Throws unless
/// there is room for their results.
template <class Form, class Work>
void WorldImpl::in_batches(const char* call, const Form& pairs, std::size_t room, Work work)
{
    const std::size_t count = count_of(call, pairs);
    same_room(call, "pairs", count, "results", room);
    if constexpr (!std::is_same_v<Form, PairOfColumns>) check_pairs(pairs);
    const int threads = frame.context.threads;
    const std::size_t batch =
        threads == 1 ? largest_batch
                     : std::clamp(count / (4 * static_cast<std::size_t>(threads)), std::size_t{64}, largest_batch);
    const ExecutorScope scope(settings.executor);
    parallel_chunks((count + batch - 1) / batch, 1, threads, [&](std::size_t begin, std::size_t end, int) {
        Lease worker(*this);
        for (std::size_t k = begin; k < end; ++k) {
            take_tasks(*worker, pairs, k * batch, std::min(batch, count - k * batch));
            work(*worker, k * batch);
        }
    });
}

/// Checks the pairs and makes their trees.
PairTasks WorldImpl::ready_tasks(const char* call, const PairSpan& pairs)
{
    PairTasks ready;
    pairs.visit([&]<class Form>(const Form& form) {
        const std::size_t count = count_of(call, form);
        if constexpr (std::is_same_v<Form, PairOfColumns>) {
            ready.poses.resize(2 * count);
            for (std::size_t i = 0; i < count; ++i) ready.tasks.push_back(task_of(form, 0, i, ready.poses.data()));
        } else {
            check_pairs(form);
            for (const auto& pair : form) ready.tasks.push_back(task_of(pair.a, pair.b));
        }
    });
    need_trees(ready.tasks);
    return ready;
}

/// Refines worker.tasks.
void WorldImpl::decide(QueryWorker& worker, std::span<Finding> found)
{
    constexpr double unknown = Finding{}.bound;
    std::ranges::fill(found, Finding{});
    worker.levels.run(worker.context, worker.tasks, found);
    for (std::size_t i = 0; i < worker.tasks.size(); ++i) {
        if (found[i].verdict == Verdict::separate || found[i].verdict == Verdict::colliding) continue;
        const PairTask& task = worker.tasks[i];
        const Aabb a = task.a->bounds().box(*task.pose_a), b = task.b->bounds().box(*task.pose_b);
        // The pair would not be a candidate in a frame.
        if (const double gap = least_gap(a, b); gap > settings.clearance)
            found[i] = {Verdict::separate, ContactKind::unknown, gap};
        else if (found[i].bound == unknown) // no level had room or time
            found[i].bound = farthest_apart(a, b);
    }
}

Finding Pairs::decide(PairSide a, PairSide b) const
{
    WorldImpl& p = *world_;
    const PairTask task = p.checked_task(a, b);
    WorldImpl::Lease worker(p);
    worker->tasks.assign(1, task);
    Finding found;
    p.decide(*worker, {&found, 1});
    return found;
}

template <class Form>
bool WorldImpl::decide_on_gpu(const Form& pairs, std::span<Finding> found)
{
    const std::size_t count = count_of("decide", pairs);
    if (!gpu || !gpu->walks() || count < gpu->worth_pairs() || found.size() != count) return false;
    if constexpr (!std::is_same_v<Form, PairOfColumns>) check_pairs(pairs);
    if (!gpu_worker) gpu_worker = std::make_unique<QueryWorker>(*this, settings, gpu.get());
    QueryWorker& worker = *gpu_worker;
    worker.context.frame = frame.number, worker.context.threads = frame.context.threads;
    const ExecutorScope scope(settings.executor);
    constexpr std::size_t at_once = 4 * MeshWalks::most_pairs; // about 100 MB of working memory
    for (std::size_t first = 0; first < count; first += at_once) {
        {
            const GpuStage stage(gpu->host().tasks_ms);
            take_tasks(worker, pairs, first, std::min(at_once, count - first));
        }
        worker.context.trees = {}, worker.context.rounds.clear();
        decide(worker, found.subspan(first, worker.tasks.size()));
    }
    return true;
}

void Pairs::decide(PairSpan pairs, std::span<Finding> found) const
{
    pairs.visit([&](const auto& form) {
        if (world_->decide_on_gpu(form, found)) return;
        world_->in_batches("decide", form, found.size(), [&](WorldImpl::QueryWorker& worker, std::size_t first) {
            world_->decide(worker, found.subspan(first, worker.tasks.size()));
        });
    });
}

void WorldImpl::need_trees(std::span<const PairTask> tasks)
{
    const auto there = [&](Model& model) {
        model.need_obb_tree(frame.number);
        return model.has_obb_tree();
    };
    {
        const std::shared_lock lock(guard);
        if (std::ranges::all_of(tasks, [&](const PairTask& task) { return there(*task.a) && there(*task.b); })) return;
    }
    const std::lock_guard lock(guard);
    for (const PairTask& task : tasks)
        for (Model* model : {task.a, task.b})
            if (model->has_triangles()) models.obb_tree(*model, frame.number);
}

/// The trees must be there.
Distance WorldImpl::distance(QueryWorker& worker, const PairTask& task, const DistanceOptions& options)
{
    if (const auto direct = tests_for(task).direct_distance) // needs no tree
        return direct(task, options);
    const bool solid = settings.mode == Mode::solid;
    return models.with_room([&] {
        Distance found = tests_for(task).distance(worker.pairs, task, options, solid);
        // The distance of a box from triangles is computed in another frame than the exact decision. Where rounding
        // leaves open whether they meet, the decision is the truth.
        if (found.lower == 0 && found.upper > 0 && found.upper <= rounding_of(task) &&
            tests_for(task).decide(worker.pairs, task, {}, nullptr).verdict == Verdict::colliding)
            found.upper = 0, found.point_a = found.point_b = 0.5 * (found.point_a + found.point_b);
        return found;
    });
}

void check_distance(const DistanceOptions& options)
{
    for (const auto& [what, value] : {std::pair("tolerance", options.tolerance), std::pair("cutoff", options.cutoff)})
        if (!(value >= 0))
            throw Error(ErrorKind::usage, fmt::format("distance: a {} of {}; must be 0 or more", what, value));
}

Distance Pairs::distance(PairSide a, PairSide b, const DistanceOptions& options) const
{
    WorldImpl& p = *world_;
    check_distance(options);
    const PairTask task = p.checked_task(a, b);
    if (const auto direct = tests_for(task).direct_distance) // needs no worker, either
        return direct(task, options);
    p.need_trees({&task, 1});
    WorldImpl::Lease worker(p);
    return p.distance(*worker, task, options);
}

void Pairs::distance(PairSpan pairs, const DistanceOptions& options, std::span<Distance> found) const
{
    check_distance(options);
    const auto work = [&](WorldImpl::QueryWorker& worker, std::size_t first) {
        world_->need_trees(worker.tasks);
        bool stopped = false; // once the caller stops it, the rest stays unknown
        for (std::size_t i = 0; i < worker.tasks.size(); ++i) {
            if (i % 16 == 0) stopped = worker.context.stopped();
            found[first + i] = stopped ? Distance{} : world_->distance(worker, worker.tasks[i], options);
        }
    };
    pairs.visit([&](const auto& form) { world_->in_batches("distance", form, found.size(), work); });
}

bool WorldImpl::may_be_near(QueryWorker& worker, const PairTask& task, double reach)
{
    constexpr double any = std::numeric_limits<double>::infinity();
    const double beyond = surely_separate(task, settings.clearance + reach);
    try {
        return models.with_room([&] {
            return tests_for(task).near(worker.pairs, task, beyond, any, nullptr).verdict != Verdict::separate;
        });
    } catch (const ChunkFault& fault) {
        models.note(fault.what());
        return true;
    }
}

void check_reaches(const char* what, std::span<const double> reaches)
{
    for (std::size_t i = 0; i < reaches.size(); ++i)
        if (!(reaches[i] >= 0 && reaches[i] <= 1e15))
            throw Error(ErrorKind::usage, fmt::format("{} {}: {}: must be 0 to 1e15 m", what, i, reaches[i]));
}

void WorldAccess::near(const World& world, std::span<const PairOfModels> pairs, std::span<const double> reaches,
                       std::span<std::uint8_t> near)
{
    WorldImpl& p = world.impl();
    same_room("near", "pairs", pairs.size(), "reaches", reaches.size());
    check_reaches("near: reach", reaches);
    p.in_batches("near", pairs, near.size(), [&](WorldImpl::QueryWorker& worker, std::size_t first) {
        p.need_trees(worker.tasks);
        for (std::size_t i = 0; i < worker.tasks.size(); ++i)
            near[first + i] = p.may_be_near(worker, worker.tasks[i], reaches[first + i]);
    });
}

double Pairs::max_error(PairSide a, PairSide b) const
{
    const PairTask task = world_->checked_task(a, b);
    return world_->models.max_error(*task.a, *task.b);
}

} // namespace oncollide
