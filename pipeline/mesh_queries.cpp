#include <oncollide/pipeline/mesh_queries.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/parallel.hpp>
#include <oncollide/pipeline/mesh_pairs.hpp>
#include <oncollide/pipeline/pair_walks.hpp>

namespace oncollide {

namespace {

constexpr std::size_t batch = 8192; // queries walked together: their parked work bounds the memory

Settings checked(Settings s)
{
    check(s);
    if (s.bounding_volume == BoundingVolume::automatic)
        s.bounding_volume = BoundingVolume::obb; // no GPU here wants cells
    const Settings usual;
    if (s.exact == ExactLevel::fcl || s.mode != usual.mode || s.backend != usual.backend || !s.skip.empty() ||
        wants_kinds(s))
        throw Error(ErrorKind::usage, "MeshQueries: exact is off or predicates, mode surface, the backend cpu, no "
                                      "stage can be skipped, and contacts have no kind");
    if (s.exact == ExactLevel::predicates && s.clearance > 0)
        throw Error(ErrorKind::usage, "MeshQueries: a clearance has no exact answer; leave exact off");
    return s;
}

Scene scene_of(std::vector<Mesh> meshes)
{
    Scene scene;
    for (std::size_t i = 0; i < meshes.size(); ++i) scene.add(fmt::format("mesh {}", i), std::move(meshes[i]));
    return scene;
}

} // namespace

struct MeshQueries::Impl {
    Scene scene; ///< geometries, and two bodies a query of the batch: only their poses and geometries are used
    Settings settings;
    Forest forest;
    PairWalks pair_walks{forest};
    MeshPairs mesh_pairs{forest};
    Frame frame;
    std::vector<PairWalks::Walk> walks;
    std::vector<MeshPairs::Ask> asks;
    std::vector<std::uint32_t> of_walks, of_asks; ///< their queries
    std::vector<Traversal::Distance> found;

    Impl(std::vector<Mesh> meshes, const Settings& s)
        : scene(scene_of(std::move(meshes))), settings(checked(s)), forest(scene, settings, make_cpu_backend())
    {
        settings.coherence = false; // a query's number says nothing about it
        frame.settings = &settings;
        frame.threads = settings.threads ? settings.threads : hardware_threads();
    }

    void take(const MeshQuery& query, std::size_t number)
    {
        for (const auto& [mesh, pose] : {std::pair(query.a, &query.pose_a), std::pair(query.b, &query.pose_b)}) {
            if (mesh >= scene.geometries.size())
                throw Error(ErrorKind::usage, fmt::format("query {}: there is no mesh {}", number, mesh));
            if (const std::string why = why_not_rigid(*pose); !why.empty())
                throw Error(ErrorKind::bad_data, fmt::format("query {}: {}", number, why));
            scene.geometry.push_back(GeometryId{mesh}), scene.poses.push_back(*pose);
        }
        const auto first = static_cast<std::uint32_t>(scene.poses.size() - 2);
        const BodyPair pair{first, first + 1};
        if (wants_obbs(settings) && mesh_pairs.admit(scene, frame, pair))
            asks.push_back({pair}), of_asks.push_back(first / 2);
        else
            walks.push_back({pair, {}, {}}), of_walks.push_back(first / 2);
    }

    /// Calls answer(first, count) for batches that have been taken.
    template <class Answer>
    void in_batches(std::span<const MeshQuery> queries, std::size_t room, Answer answer)
    {
        if (queries.size() != room)
            throw Error(ErrorKind::usage,
                        fmt::format("MeshQueries: {} queries, room for {} answers", queries.size(), room));
        for (std::size_t first = 0; first < queries.size(); first += batch) {
            const std::size_t count = std::min(batch, queries.size() - first);
            scene.geometry.clear(), scene.poses.clear();
            walks.clear(), of_walks.clear(), asks.clear(), of_asks.clear();
            for (std::size_t i = first; i < first + count; ++i) take(queries[i], i);
            answer(first, count);
        }
        forest.age(frame.number++);
    }

    void answer_batch(std::span<MeshAnswer> answers)
    {
        const bool exact = settings.exact == ExactLevel::predicates;
        frame.trees = {}, frame.rounds.clear();
        if (exact)
            mesh_pairs.meet(scene, frame, asks);
        else
            mesh_pairs.near(scene, frame, asks);
        for (std::size_t i = 0; i < asks.size(); ++i) {
            const Traversal::Nearness& answer = asks[i].answer;
            const Verdict yes = exact ? Verdict::colliding : Verdict::within;
            answers[of_asks[i]] = {answer.near ? yes : Verdict::separate, answer.bound};
        }
        pair_walks.run(scene, frame, walks);
        for (std::size_t i = 0; i < walks.size(); ++i) {
            const WalkResult& walk = walks[i].result;
            // Touching spheres do not say that the surfaces meet.
            answers[of_walks[i]] = {walk.status == WalkStatus::separate             ? Verdict::separate
                                    : walk.status == WalkStatus::touching && !exact ? Verdict::within
                                                                                    : Verdict::undecided,
                                    walk.bound};
        }
    }
};

MeshQueries::MeshQueries(std::vector<Mesh> meshes, const Settings& settings)
    : impl_(std::make_unique<Impl>(std::move(meshes), settings))
{
}
MeshQueries::~MeshQueries() = default;
MeshQueries::MeshQueries(MeshQueries&&) noexcept = default;

void MeshQueries::ask(std::span<const MeshQuery> queries, std::span<MeshAnswer> answers)
{
    impl_->in_batches(queries, answers.size(), [&](std::size_t first, std::size_t count) {
        impl_->answer_batch(answers.subspan(first, count));
    });
}

void MeshQueries::distances(std::span<const MeshQuery> queries, double tolerance, std::span<MeshDistance> distances,
                            double farthest)
{
    check_distance(tolerance, farthest);
    Impl& p = *impl_;
    p.in_batches(queries, distances.size(), [&](std::size_t first, std::size_t) {
        // A mesh for whose tree a budget has no room: nothing is known.
        for (std::uint32_t i : p.of_walks) distances[first + i] = {0, std::numeric_limits<double>::infinity()};
        p.mesh_pairs.distances(p.scene, p.frame, p.asks, tolerance, farthest, p.found);
        for (std::size_t i = 0; i < p.asks.size(); ++i) distances[first + p.of_asks[i]] = mesh_distance(p.found[i]);
    });
}

std::size_t MeshQueries::bytes() const
{
    return impl_->forest.bytes();
}

} // namespace oncollide
