#include <oncollide/pipeline/mesh_queries.hpp>

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/pipeline/refine/narrowing.hpp>
#include <oncollide/pipeline/refine/pair_distance.hpp>

namespace oncollide {

namespace {

constexpr std::size_t batch = 8192; // queries per batch, which bounds the memory of parked traversals

Settings checked(Settings s)
{
    check(s);
    if (s.bounding_volume == BoundingVolume::automatic) s.bounding_volume = BoundingVolume::obb; // no GPU here
    const Settings usual;
    if (s.exact == ExactLevel::fcl || s.mode != usual.mode || s.backend != usual.backend || !s.skip.empty() ||
        wants_kinds(s))
        throw Error(ErrorKind::usage, "MeshQueries: exact must be off or predicates, mode surface and backend cpu; "
                                      "skip and kinds are not supported");
    if (s.exact == ExactLevel::predicates && s.clearance > 0)
        throw Error(ErrorKind::usage,
                    "MeshQueries: clearance is not supported with exact = predicates; use exact = off");
    s.coherence = false; // a query's index does not identify the pair
    return s;
}

} // namespace

struct MeshQueries::Impl {
    Settings settings;
    ModelStore store;
    std::vector<Model*> models; ///< by mesh
    BothLevels levels;
    RefineContext context;
    std::vector<MeshQuery> placed; ///< a batch of columns
    std::vector<PairTask> tasks;   ///< of the current batch
    std::vector<RefineResult> refined;
    std::vector<PairDistance> finders; ///< by thread

    Impl(const std::vector<std::shared_ptr<const Geometry>>& geometries, const Settings& s)
        : settings(checked(s)), store(settings, make_cpu_backend()),
          levels(settings, store), context{.settings = settings, .trees = {}, .rounds = {}, .began = {}}
    {
        context.threads = thread_count(settings);
        for (std::size_t i = 0; i < geometries.size(); ++i) {
            if (!geometries[i])
                throw Error(ErrorKind::usage, fmt::format("MeshQueries: mesh {}: no geometry given", i));
            models.push_back(&store[store.add(geometries[i])]);
        }
    }

    void check_query(const MeshQuery& query, std::size_t number) const
    {
        for (const auto& [mesh, pose, name] :
             {std::tuple(query.a, &query.pose_a, "pose_a"), std::tuple(query.b, &query.pose_b, "pose_b")}) {
            if (mesh >= models.size())
                throw Error(ErrorKind::usage, fmt::format("query {}: there is no mesh {}; there are {} meshes", number,
                                                          mesh, models.size()));
            if (const std::string why = why_not_rigid(*pose); !why.empty())
                throw Error(ErrorKind::bad_data, fmt::format("query {}: {}: {}", number, name, why));
        }
    }

    /// Prepares the tasks of each batch, then calls work(first).
    /// @param batch_of  batch_of(first, count) checks and returns the queries [first, first + count)
    template <class BatchOf, class Work>
    void in_batches(std::size_t queries, BatchOf batch_of, Work work)
    {
        const ExecutorScope scope(settings.executor);
        context.trees = {}, context.rounds.clear();
        for (std::size_t first = 0; first < queries; first += batch) {
            tasks.clear();
            for (const MeshQuery& q : std::span<const MeshQuery>(batch_of(first, std::min(batch, queries - first))))
                tasks.push_back(
                    {static_cast<std::uint32_t>(tasks.size()), models[q.a], models[q.b], &q.pose_a, &q.pose_b});
            work(first);
        }
        store.age(context.frame++);
    }

    template <class Work>
    void in_batches(std::span<const MeshQuery> queries, std::size_t room, Work work)
    {
        if (queries.size() != room)
            throw Error(ErrorKind::usage,
                        fmt::format("MeshQueries: {} queries, room for {} results", queries.size(), room));
        for (std::size_t i = 0; i < queries.size(); ++i) check_query(queries[i], i);
        in_batches(
            room, [&](std::size_t first, std::size_t count) { return queries.subspan(first, count); }, work);
    }

    template <class Work>
    void in_batches(const MeshQueryColumns& columns, std::size_t room, Work work)
    {
        for (const auto& [name, entries, width] :
             {std::tuple("a", columns.a.size(), std::size_t{1}), std::tuple("b", columns.b.size(), std::size_t{1}),
              std::tuple("poses_a", columns.poses_a.size(), std::size_t{16}),
              std::tuple("poses_b", columns.poses_b.size(), std::size_t{16})})
            if (entries != width && entries != width * room)
                throw Error(ErrorKind::usage, fmt::format("MeshQueries: {}: {} numbers; must be {}, or {} for all of "
                                                          "the {} queries",
                                                          name, entries, width * room, width, room));
        const auto number = [](std::span<const std::uint32_t> column, std::size_t i) {
            return column[column.size() > 1 ? i : 0];
        };
        const auto pose = [](std::span<const double> column, std::size_t i) {
            using RowByRow = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
            Eigen::Isometry3d made;
            made.matrix() = Eigen::Map<const RowByRow>(column.data() + (column.size() > 16 ? 16 * i : 0));
            return made;
        };
        in_batches(
            room,
            [&](std::size_t first, std::size_t count) -> std::span<const MeshQuery> {
                placed.resize(count);
                for (std::size_t i = 0; i < count; ++i) {
                    const std::size_t at = first + i;
                    placed[i] = {number(columns.a, at), number(columns.b, at), pose(columns.poses_a, at),
                                 pose(columns.poses_b, at)};
                    check_query(placed[i], at);
                }
                return placed;
            },
            work);
    }

    void refine_batch()
    {
        constexpr double unknown = std::numeric_limits<double>::infinity();
        refined.assign(tasks.size(), {Verdict::undecided, ContactKind::unknown, unknown});
        levels.run(context, tasks, refined);
        const auto box = [](const Model& model, const Eigen::Isometry3d& pose) { return model.bounds().box(pose); };
        for (std::size_t i = 0; i < tasks.size(); ++i) // pairs that no level could test
            if (refined[i].verdict == Verdict::undecided && refined[i].bound == unknown)
                refined[i].bound =
                    farthest_apart(box(*tasks[i].a, *tasks[i].pose_a), box(*tasks[i].b, *tasks[i].pose_b));
    }

    template <class Queries>
    void find_distances(const Queries& queries, double tolerance, std::span<Distance> distances, double farthest)
    {
        check_distance(tolerance, farthest);
        finders.resize(static_cast<std::size_t>(context.threads));
        in_batches(queries, distances.size(), [&](std::size_t first) {
            for (const PairTask& task : tasks)
                for (Model* model : {task.a, task.b}) store.admit_obb_tree(*model, context.frame);
            parallel_chunks(tasks.size(), 16, context.threads, [&](std::size_t begin, std::size_t end, int thread) {
                const auto has_tree = [](const Model& model) { return !model.has_triangles() || model.obb_tree; };
                bool stopped = false;
                for (std::size_t i = begin; i < end; ++i) {
                    const PairTask& task = tasks[i];
                    Distance& out = distances[first + i];
                    out = {}; // for queries not reached after a stop, or without room for a tree
                    if (i % 16 == 0) stopped = context.stopped();
                    if (!stopped && has_tree(*task.a) && has_tree(*task.b))
                        out = store.with_room([&] {
                            return finders[static_cast<std::size_t>(thread)].find(task, settings.mode, tolerance,
                                                                                  farthest);
                        });
                }
            });
        });
    }
};

namespace {

std::vector<std::shared_ptr<const Geometry>> checked(std::vector<Mesh> meshes)
{
    std::vector<std::shared_ptr<const Geometry>> geometries;
    for (Mesh& mesh : meshes) {
        std::string name = fmt::format("mesh {}", geometries.size());
        check_mesh(name, mesh);
        geometries.push_back(std::make_shared<const Geometry>(Geometry{std::move(name), std::move(mesh), {}}));
    }
    return geometries;
}

} // namespace

MeshQueries::MeshQueries(std::vector<std::shared_ptr<const Geometry>> geometries, const Settings& settings)
    : impl_(std::make_unique<Impl>(geometries, settings))
{
}
MeshQueries::MeshQueries(std::vector<Mesh> meshes, const Settings& settings)
    : MeshQueries(checked(std::move(meshes)), settings)
{
}
MeshQueries::~MeshQueries() = default;
MeshQueries::MeshQueries(MeshQueries&&) noexcept = default;

void MeshQueries::run(std::span<const MeshQuery> queries, std::span<MeshResult> results)
{
    Impl& p = *impl_;
    p.in_batches(queries, results.size(), [&](std::size_t first) {
        p.refine_batch();
        for (std::size_t i = 0; i < p.refined.size(); ++i)
            results[first + i] = {p.refined[i].verdict, p.refined[i].bound};
    });
}

void MeshQueries::run(const MeshQueryColumns& queries, std::span<Verdict> verdicts, std::span<double> bounds)
{
    Impl& p = *impl_;
    if (verdicts.size() != bounds.size())
        throw Error(ErrorKind::usage,
                    fmt::format("MeshQueries: room for {} verdicts, but {} bounds", verdicts.size(), bounds.size()));
    p.in_batches(queries, verdicts.size(), [&](std::size_t first) {
        p.refine_batch();
        for (std::size_t i = 0; i < p.refined.size(); ++i)
            verdicts[first + i] = p.refined[i].verdict, bounds[first + i] = p.refined[i].bound;
    });
}

void MeshQueries::distances(std::span<const MeshQuery> queries, double tolerance, std::span<Distance> distances,
                            double farthest)
{
    impl_->find_distances(queries, tolerance, distances, farthest);
}

void MeshQueries::distances(const MeshQueryColumns& queries, double tolerance, std::span<Distance> distances,
                            double farthest)
{
    impl_->find_distances(queries, tolerance, distances, farthest);
}

std::size_t MeshQueries::size() const
{
    return impl_->models.size();
}

std::size_t MeshQueries::bytes() const
{
    return impl_->store.bytes();
}

} // namespace oncollide
