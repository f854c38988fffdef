#include <oncollide/pipeline/mesh_queries.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/pipeline/refine/contact_finding.hpp>
#include <oncollide/pipeline/refine/narrowing.hpp>

namespace oncollide {

namespace {

constexpr std::size_t batch = 8192; // queries walked together: their parked work bounds the memory

Settings checked(Settings s)
{
    check(s);
    if (s.bounding_volume == BoundingVolume::automatic) s.bounding_volume = BoundingVolume::obb; // no GPU here
    const Settings usual;
    if (s.exact == ExactLevel::fcl || s.mode != usual.mode || s.backend != usual.backend || !s.skip.empty() ||
        wants_kinds(s))
        throw Error(ErrorKind::usage, "MeshQueries: exact is off or predicates, mode surface, the backend cpu, no "
                                      "stage can be skipped, and contacts have no kind");
    if (s.exact == ExactLevel::predicates && s.clearance > 0)
        throw Error(ErrorKind::usage, "MeshQueries: a clearance has no exact result; leave exact off");
    s.coherence = false; // a query's number says nothing about it
    return s;
}

} // namespace

struct MeshQueries::Impl {
    Settings settings;
    ModelStore store;
    std::vector<Model*> models; ///< by mesh
    BothLevels levels;
    RefineContext context;
    std::vector<PairTask> tasks;
    std::vector<RefineResult> refined;
    std::vector<ContactFinding> finders; ///< by thread

    Impl(std::vector<Mesh> meshes, const Settings& s)
        : settings(checked(s)), store(settings, make_cpu_backend()),
          levels(settings, store), context{.settings = settings, .trees = {}, .rounds = {}, .began = {}}
    {
        context.threads = thread_count(settings);
        for (std::size_t i = 0; i < meshes.size(); ++i) {
            const std::string name = fmt::format("mesh {}", i);
            check_mesh(name, meshes[i]);
            models.push_back(
                &store[store.add(std::make_shared<const Geometry>(Geometry{name, std::move(meshes[i]), {}}))]);
        }
    }

    void check_query(const MeshQuery& query, std::size_t number) const
    {
        for (const auto& [mesh, pose] : {std::pair(query.a, &query.pose_a), std::pair(query.b, &query.pose_b)}) {
            if (mesh >= models.size())
                throw Error(ErrorKind::usage, fmt::format("query {}: there is no mesh {}", number, mesh));
            if (const std::string why = why_not_rigid(*pose); !why.empty())
                throw Error(ErrorKind::bad_data, fmt::format("query {}: {}", number, why));
        }
    }

    /// Calls work(first) for batches whose tasks are ready.
    template <class Work>
    void in_batches(std::span<const MeshQuery> queries, std::size_t room, Work work)
    {
        if (queries.size() != room)
            throw Error(ErrorKind::usage,
                        fmt::format("MeshQueries: {} queries, room for {} results", queries.size(), room));
        for (std::size_t i = 0; i < queries.size(); ++i) check_query(queries[i], i);
        const ExecutorScope scope(settings.executor);
        context.trees = {}, context.rounds.clear();
        for (std::size_t first = 0; first < queries.size(); first += batch) {
            tasks.clear();
            for (const MeshQuery& q : queries.subspan(first, std::min(batch, queries.size() - first)))
                tasks.push_back(
                    {static_cast<std::uint32_t>(tasks.size()), models[q.a], models[q.b], &q.pose_a, &q.pose_b});
            work(first);
        }
        store.age(context.frame++);
    }

    void run_batch(std::span<MeshResult> results)
    {
        refined.assign(tasks.size(), {Verdict::undecided, ContactKind::unknown, 0});
        levels.run(context, tasks, refined);
        for (std::size_t i = 0; i < refined.size(); ++i) results[i] = {refined[i].verdict, refined[i].bound};
    }
};

MeshQueries::MeshQueries(std::vector<Mesh> meshes, const Settings& settings)
    : impl_(std::make_unique<Impl>(std::move(meshes), settings))
{
}
MeshQueries::~MeshQueries() = default;
MeshQueries::MeshQueries(MeshQueries&&) noexcept = default;

void MeshQueries::run(std::span<const MeshQuery> queries, std::span<MeshResult> results)
{
    Impl& p = *impl_;
    p.in_batches(queries, results.size(),
                 [&](std::size_t first) { p.run_batch(results.subspan(first, p.tasks.size())); });
}

void MeshQueries::distances(std::span<const MeshQuery> queries, double tolerance, std::span<Distance> distances,
                            double farthest)
{
    check_distance(tolerance, farthest);
    Impl& p = *impl_;
    p.finders.resize(static_cast<std::size_t>(p.context.threads));
    p.in_batches(queries, distances.size(), [&](std::size_t first) {
        for (const PairTask& task : p.tasks)
            for (Model* model : {task.a, task.b}) p.store.admit_boxes(*model, p.context.frame);
        parallel_chunks(p.tasks.size(), 64, p.context.threads, [&](std::size_t begin, std::size_t end, int thread) {
            for (std::size_t i = begin; i < end; ++i) {
                const PairTask& task = p.tasks[i];
                Distance& out = distances[first + i];
                out = {}; // a mesh for whose tree a budget has no room: nothing is known
                if (task.a->boxes && task.b->boxes)
                    out = p.finders[static_cast<std::size_t>(thread)].distance(
                        *task.a->boxes, *task.pose_a, *task.b->boxes, *task.pose_b, tolerance, farthest);
            }
        });
    });
}

std::size_t MeshQueries::bytes() const
{
    return impl_->store.bytes();
}

} // namespace oncollide
