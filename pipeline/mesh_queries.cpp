#include <oncollide/pipeline/mesh_queries.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/narrowphase/mesh_leaf_test.hpp>
#include <oncollide/pipeline/pair_walks.hpp>
#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

constexpr std::size_t batch = 8192; // queries walked together: their parked work bounds the memory

const Settings& checked(const Settings& s)
{
    check(s);
    const Settings usual;
    if (s.exact == ExactLevel::fcl || s.mode != usual.mode || s.backend != usual.backend || !s.skip.empty())
        throw Error(ErrorKind::usage, "MeshQueries: exact is off or predicates, mode surface, the backend cpu, and no "
                                      "stage can be skipped");
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
    MeshLeafTest test;
    Frame frame;
    std::vector<PairWalks::Walk> walks, open;

    Impl(std::vector<Mesh> meshes, const Settings& s)
        : scene(scene_of(std::move(meshes))), settings(checked(s)), forest(scene, settings, make_cpu_backend()),
          test(scene, *forest.backend().lists())
    {
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
        walks.push_back({{first, first + 1}, {}, {}});
    }

    void answer_batch(std::span<MeshAnswer> answers)
    {
        frame.trees = {}, frame.rounds.clear();
        pair_walks.run(scene, frame, walks, nullptr);
        open.clear();
        for (std::size_t i = 0; i < walks.size(); ++i) {
            const WalkResult& walk = walks[i].result;
            answers[i] = {walk.status == WalkStatus::separate   ? Verdict::separate
                          : walk.status == WalkStatus::touching ? Verdict::within
                                                                : Verdict::undecided,
                          walk.bound};
            if (walk.status != WalkStatus::separate) open.push_back({walks[i].pair, {}, {}});
        }
        if (settings.exact == ExactLevel::off) return;
        pair_walks.run(scene, frame, open, &test);
        for (const PairWalks::Walk& walk : open) {
            MeshAnswer& answer = answers[walk.pair.a / 2];
            if (walk.result.status == WalkStatus::undecided) // a budget
                answer.verdict = Verdict::undecided;
            else
                answer = {walk.result.status == WalkStatus::touching ? Verdict::colliding : Verdict::separate, 0};
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
    Impl& p = *impl_;
    if (queries.size() != answers.size())
        throw Error(ErrorKind::usage,
                    fmt::format("MeshQueries: {} queries, room for {} answers", queries.size(), answers.size()));
    for (std::size_t first = 0; first < queries.size(); first += batch) {
        const std::size_t count = std::min(batch, queries.size() - first);
        p.scene.geometry.clear(), p.scene.poses.clear(), p.walks.clear();
        for (std::size_t i = first; i < first + count; ++i) p.take(queries[i], i);
        p.answer_batch(answers.subspan(first, count));
    }
    p.forest.age(p.frame.number++);
}

std::size_t MeshQueries::bytes() const
{
    return impl_->forest.bytes();
}

} // namespace oncollide
