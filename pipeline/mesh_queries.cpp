#include <oncollide/pipeline/mesh_queries.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>

namespace oncollide {

namespace {

Settings checked(Settings s)
{
    check(s);
    if (s.bounding_volume == BoundingVolume::automatic) s.bounding_volume = BoundingVolume::obb; // no GPU here
    const Settings usual;
    if (s.exact == ExactLevel::fcl || s.mode != usual.mode || s.backend != usual.backend || !s.skip.empty() ||
        wants_kinds(s))
        throw Error(ErrorKind::usage,
                    "MeshQueries: exact must be auto, off or predicates, mode surface and backend cpu; "
                    "skip and kinds are not supported");
    if (s.exact == ExactLevel::predicates && s.clearance > 0)
        throw Error(ErrorKind::usage,
                    "MeshQueries: clearance is not supported with exact = predicates; use exact = off");
    return s;
}

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

struct MeshQueries::Impl {
    World world;
    std::vector<ModelId> models; ///< by mesh
    std::vector<PairOfModels> pairs;
    std::vector<ModelId> a, b; ///< of columns

    ModelId model(std::uint32_t mesh, std::size_t query) const
    {
        if (mesh < models.size()) return models[mesh];
        throw Error(ErrorKind::usage,
                    fmt::format("query {}: there is no mesh {}; there are {} meshes", query, mesh, models.size()));
    }
    std::span<const PairOfModels> pairs_of(std::span<const MeshQuery> queries)
    {
        pairs.clear();
        for (const MeshQuery& q : queries)
            pairs.push_back({{model(q.a, pairs.size()), q.pose_a}, {model(q.b, pairs.size()), q.pose_b}});
        return pairs;
    }
    ModelPairColumns columns_of(const MeshQueryColumns& queries)
    {
        const auto fill = [&](std::span<const std::uint32_t> meshes, std::vector<ModelId>& ids) {
            ids.clear();
            for (const std::uint32_t mesh : meshes) ids.push_back(model(mesh, ids.size()));
        };
        fill(queries.a, a), fill(queries.b, b);
        return {a, b, queries.poses_a, queries.poses_b};
    }
    /// Ages the trees: a call counts as a frame.
    void end_call() { world.step(); }
};

MeshQueries::MeshQueries(std::vector<std::shared_ptr<const Geometry>> geometries, const Settings& settings)
    : impl_(std::make_unique<Impl>(World(checked(settings))))
{
    for (std::size_t i = 0; i < geometries.size(); ++i) {
        if (!geometries[i]) throw Error(ErrorKind::usage, fmt::format("MeshQueries: mesh {}: no geometry given", i));
        impl_->models.push_back(impl_->world.add(std::move(geometries[i])));
    }
}
MeshQueries::MeshQueries(std::vector<Mesh> meshes, const Settings& settings)
    : MeshQueries(checked(std::move(meshes)), settings)
{
}
MeshQueries::~MeshQueries() = default;
MeshQueries::MeshQueries(MeshQueries&&) noexcept = default;

void MeshQueries::run(std::span<const MeshQuery> queries, std::span<Finding> results)
{
    impl_->world.decide(impl_->pairs_of(queries), results);
    impl_->end_call();
}

void MeshQueries::run(const MeshQueryColumns& queries, std::span<Verdict> verdicts, std::span<double> bounds)
{
    impl_->world.decide(impl_->columns_of(queries), verdicts, bounds);
    impl_->end_call();
}

void MeshQueries::distances(std::span<const MeshQuery> queries, double tolerance, std::span<Distance> distances,
                            double cutoff)
{
    impl_->world.distances(impl_->pairs_of(queries), distances, tolerance, cutoff);
    impl_->end_call();
}

void MeshQueries::distances(const MeshQueryColumns& queries, double tolerance, std::span<Distance> distances,
                            double cutoff)
{
    impl_->world.distances(impl_->columns_of(queries), distances, tolerance, cutoff);
    impl_->end_call();
}

std::size_t MeshQueries::size() const
{
    return impl_->models.size();
}

std::size_t MeshQueries::bytes() const
{
    return impl_->world.inspect().bytes;
}

} // namespace oncollide
