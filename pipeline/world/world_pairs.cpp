// World: const queries about pairs, safe from many threads at once.
#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/convex_distance.hpp>
#include <oncollide/pipeline/check_distance.hpp>
#include <oncollide/pipeline/world/query_worker.hpp>

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

void check_columns(const char* call, const ModelPairColumns& columns, std::size_t room)
{
    const auto check = [&](const char* name, std::size_t numbers, std::size_t width) {
        if (numbers != width && numbers != width * room)
            throw Error(ErrorKind::usage, fmt::format("{}: column {}: {} numbers; must be {}, or {} for all of the {} "
                                                      "pairs",
                                                      call, name, numbers, width * room, width, room));
    };
    check("a", columns.a.size(), 1), check("b", columns.b.size(), 1);
    check("poses_a", columns.poses_a.size(), 16), check("poses_b", columns.poses_b.size(), 16);
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

World::Impl::QueryWorker::QueryWorker(Impl& impl, const Settings& settings)
    : levels(settings, impl.models), context{.settings = settings,
                                             .trees = {},
                                             .rounds = {},
                                             .began = {},
                                             .guard = &impl.guard}
{
}

World::Impl::~Impl() = default;

void World::Impl::check_side(const PairSide& side)
{
    if (!side.placed()) {
        slot_of(side.body());
        return;
    }
    check_model(side.placed()->model);
    check_pose("", side.placed()->pose);
}

PairTask World::Impl::task_of(const PairSide& a, const PairSide& b)
{
    PairTask task{};
    const auto fill = [&](const PairSide& side, Model*& model, const Eigen::Isometry3d*& pose) {
        if (const PlacedModel* placed = side.placed())
            model = &models[placed->model], pose = &placed->pose;
        else
            model = &bodies.model(side.body().slot), pose = &bodies.pose(side.body().slot);
    };
    fill(a, task.a, task.pose_a), fill(b, task.b, task.pose_b);
    return task;
}

PairTask World::Impl::checked_task(const PairSide& a, const PairSide& b)
{
    check_side(a), check_side(b);
    return task_of(a, b);
}

/// Calls work(worker, first), whose worker.tasks are pairs `first` and following, on the World's threads.
template <class Pairs, class Work>
void World::Impl::in_batches(const Pairs& pairs, std::size_t count, Work work)
{
    constexpr bool columns = std::is_same_v<Pairs, ModelPairColumns>;
    if constexpr (!columns) check_pairs(pairs);
    const int threads = frame.context.threads;
    const std::size_t batch =
        threads == 1 ? largest_batch
                     : std::clamp(count / (4 * static_cast<std::size_t>(threads)), std::size_t{64}, largest_batch);
    const ExecutorScope scope(settings.executor);
    parallel_chunks((count + batch - 1) / batch, 1, threads, [&](std::size_t begin, std::size_t end, int) {
        Lease worker(*this);
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t first = k * batch, many = std::min(batch, count - first);
            worker->tasks.clear();
            if constexpr (columns) worker->poses.resize(2 * many);
            for (std::size_t i = 0; i < many; ++i) {
                if constexpr (columns) {
                    const auto side = [&](const char* name, std::span<const ModelId> ids, std::span<const double> rows,
                                          Eigen::Isometry3d& pose) {
                        const ModelId id = *entry(ids, 1, first + i);
                        pose.matrix() = RowByRow(entry(rows, 16, first + i));
                        naming("pair", first + i, name, [&] { check_model(id), check_pose("", pose); });
                        return &models[id];
                    };
                    Eigen::Isometry3d &pose_a = worker->poses[2 * i], &pose_b = worker->poses[2 * i + 1];
                    Model* const a = side("a", pairs.a, pairs.poses_a, pose_a);
                    Model* const b = side("b", pairs.b, pairs.poses_b, pose_b);
                    worker->tasks.push_back({0, a, b, &pose_a, &pose_b});
                } else {
                    worker->tasks.push_back(task_of(pairs[first + i].a, pairs[first + i].b));
                }
                worker->tasks.back().number = static_cast<std::uint32_t>(i);
            }
            work(*worker, first);
        }
    });
}

/// Refines worker.tasks to worker.refined.
void World::Impl::decide(QueryWorker& worker)
{
    constexpr double unknown = std::numeric_limits<double>::infinity();
    worker.refined.assign(worker.tasks.size(), {Verdict::undecided, ContactKind::unknown, unknown});
    worker.levels.run(worker.context, worker.tasks, worker.refined);
    for (std::size_t i = 0; i < worker.tasks.size(); ++i) {
        Finding& found = worker.refined[i];
        if (found.verdict == Verdict::separate || found.verdict == Verdict::colliding) continue;
        const PairTask& task = worker.tasks[i];
        const Aabb a = task.a->bounds().box(*task.pose_a), b = task.b->bounds().box(*task.pose_b);
        if (const double gap = least_gap(a, b); gap > settings.clearance) // no candidate in a frame
            found = {Verdict::separate, ContactKind::unknown, gap};
        else if (found.bound == unknown) // no level had room or time
            found.bound = farthest_apart(a, b);
    }
}

Finding World::decide(PairSide a, PairSide b) const
{
    Impl& p = impl();
    const PairTask task = p.checked_task(a, b);
    Impl::Lease worker(p);
    worker->tasks.assign(1, task);
    p.decide(*worker);
    return worker->refined.front();
}

void World::decide(std::span<const PairOfBodies> pairs, std::span<Finding> found) const
{
    same_room("decide", "pairs", pairs.size(), "results", found.size());
    impl().in_batches(pairs, pairs.size(), [&](Impl::QueryWorker& worker, std::size_t first) {
        impl_->decide(worker);
        std::ranges::copy(worker.refined, found.begin() + static_cast<std::ptrdiff_t>(first));
    });
}

void World::decide(std::span<const PairOfModels> pairs, std::span<Finding> found) const
{
    same_room("decide", "pairs", pairs.size(), "results", found.size());
    impl().in_batches(pairs, pairs.size(), [&](Impl::QueryWorker& worker, std::size_t first) {
        impl_->decide(worker);
        std::ranges::copy(worker.refined, found.begin() + static_cast<std::ptrdiff_t>(first));
    });
}

void World::decide(const ModelPairColumns& pairs, std::span<Verdict> verdicts, std::span<double> bounds) const
{
    if (verdicts.size() != bounds.size())
        throw Error(ErrorKind::usage,
                    fmt::format("decide: room for {} verdicts, but {} bounds", verdicts.size(), bounds.size()));
    if (verdicts.empty()) return;
    check_columns("decide", pairs, verdicts.size());
    impl().in_batches(pairs, verdicts.size(), [&](Impl::QueryWorker& worker, std::size_t first) {
        impl_->decide(worker);
        for (std::size_t i = 0; i < worker.refined.size(); ++i)
            verdicts[first + i] = worker.refined[i].verdict, bounds[first + i] = worker.refined[i].bound;
    });
}

void World::Impl::need_trees(std::span<const PairTask> tasks)
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
Distance World::Impl::distance(QueryWorker& worker, const PairTask& task, double tolerance, double cutoff)
{
    const bool solid = settings.mode == Mode::solid;
    return models.with_room([&] {
        Distance found = tests_for(task).distance(worker.pairs, task, tolerance, cutoff, solid);
        // The distance of a box from triangles is computed in another frame than the exact decision. Where rounding
        // leaves open whether they meet, the decision is the truth.
        if (found.lower == 0 && found.upper > 0 && found.upper <= rounding_of(task) &&
            tests_for(task).decide(worker.pairs, task, {}, nullptr).verdict == Verdict::colliding)
            found.upper = 0, found.point_a = found.point_b = 0.5 * (found.point_a + found.point_b);
        return found;
    });
}

Distance World::distance(PairSide a, PairSide b, double tolerance, double cutoff) const
{
    Impl& p = impl();
    check_distance(tolerance, cutoff);
    const PairTask task = p.checked_task(a, b);
    if (const auto direct = tests_for(task).direct_distance) // needs no worker and no tree
        return direct(task, {.above = cutoff, .tolerance = tolerance});
    p.need_trees({&task, 1});
    Impl::Lease worker(p);
    return p.distance(*worker, task, tolerance, cutoff);
}

namespace {

/// The work of one batch of distances. Once the caller stops it, the rest stays unknown.
auto find_distances(auto& impl, std::span<Distance> found, double tolerance, double cutoff)
{
    return [&impl, found, tolerance, cutoff](auto& worker, std::size_t first) {
        impl.need_trees(worker.tasks);
        bool stopped = false;
        for (std::size_t i = 0; i < worker.tasks.size(); ++i) {
            if (i % 16 == 0) stopped = worker.context.stopped();
            found[first + i] = stopped ? Distance{} : impl.distance(worker, worker.tasks[i], tolerance, cutoff);
        }
    };
}

} // namespace

void World::distances(std::span<const PairOfBodies> pairs, std::span<Distance> found, double tolerance,
                      double cutoff) const
{
    check_distance(tolerance, cutoff);
    same_room("distances", "pairs", pairs.size(), "results", found.size());
    impl().in_batches(pairs, pairs.size(), find_distances(*impl_, found, tolerance, cutoff));
}

void World::distances(std::span<const PairOfModels> pairs, std::span<Distance> found, double tolerance,
                      double cutoff) const
{
    check_distance(tolerance, cutoff);
    same_room("distances", "pairs", pairs.size(), "results", found.size());
    impl().in_batches(pairs, pairs.size(), find_distances(*impl_, found, tolerance, cutoff));
}

void World::distances(const ModelPairColumns& pairs, std::span<Distance> found, double tolerance, double cutoff) const
{
    check_distance(tolerance, cutoff);
    if (found.empty()) return;
    check_columns("distances", pairs, found.size());
    impl().in_batches(pairs, found.size(), find_distances(*impl_, found, tolerance, cutoff));
}

bool World::Impl::may_be_near(QueryWorker& worker, const PairTask& task, double reach)
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

void World::near(std::span<const PairOfModels> pairs, std::span<const double> reaches,
                 std::span<std::uint8_t> near) const
{
    same_room("near", "pairs", pairs.size(), "reaches", reaches.size());
    same_room("near", "pairs", pairs.size(), "results", near.size());
    check_reaches("near: reach", reaches);
    impl().in_batches(pairs, pairs.size(), [&](Impl::QueryWorker& worker, std::size_t first) {
        impl_->need_trees(worker.tasks);
        for (std::size_t i = 0; i < worker.tasks.size(); ++i)
            near[first + i] = impl_->may_be_near(worker, worker.tasks[i], reaches[first + i]);
    });
}

/// The trees must be there. Appends.
void World::Impl::contacts(QueryWorker& worker, const PairTask& task, std::vector<Contact>& found)
{
    models.with_room([&, begin = found.size()] {
        found.resize(begin);
        tests_for(task).contacts(worker.pairs, task, found);
    });
}

std::vector<Contact> World::contacts(PairSide a, PairSide b) const
{
    Impl& p = impl();
    const PairTask task = p.checked_task(a, b);
    p.need_trees({&task, 1});
    std::vector<Contact> found;
    Impl::Lease worker(p);
    p.contacts(*worker, task, found);
    return found;
}

namespace {

template <class Pairs>
void find_contacts(auto& impl, const Pairs& pairs, ContactLists& lists)
{
    const std::vector<PairTask> tasks = impl.ready_tasks(pairs);
    impl.gather(tasks.size(), 16, lists.contacts, lists.offsets,
                [&](auto& worker, std::size_t i, auto& found) { impl.contacts(worker, tasks[i], found); });
}

} // namespace

void World::contacts(std::span<const PairOfBodies> pairs, ContactLists& lists) const
{
    find_contacts(impl(), pairs, lists);
}

void World::contacts(std::span<const PairOfModels> pairs, ContactLists& lists) const
{
    find_contacts(impl(), pairs, lists);
}

/// The trees must be there.
Penetration World::Impl::penetration(QueryWorker& worker, const PairTask& task)
{
    const auto measure = tests_for(task).penetration;
    if (!measure || reads_a_part(task)) {
        Penetration none;
        none.supported = false;
        return none;
    }
    return models.with_room([&] { return measure(worker.pairs, task); });
}

Penetration World::penetration(PairSide a, PairSide b) const
{
    Impl& p = impl();
    const PairTask task = p.checked_task(a, b);
    p.need_trees({&task, 1});
    Impl::Lease worker(p);
    return p.penetration(*worker, task);
}

namespace {

template <class Pairs>
void find_penetrations(auto& impl, const Pairs& pairs, std::span<Penetration> found)
{
    same_room("penetration", "pairs", pairs.size(), "results", found.size());
    const std::vector<PairTask> tasks = impl.ready_tasks(pairs);
    impl.each(tasks.size(), 4, [&](auto& worker, std::size_t i) { found[i] = impl.penetration(worker, tasks[i]); });
}

} // namespace

void World::penetration(std::span<const PairOfBodies> pairs, std::span<Penetration> found) const
{
    find_penetrations(impl(), pairs, found);
}

void World::penetration(std::span<const PairOfModels> pairs, std::span<Penetration> found) const
{
    find_penetrations(impl(), pairs, found);
}

} // namespace oncollide
