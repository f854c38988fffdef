// Meshes that meet themselves or come near: Models::self_contacts() and near_features(), and the same without a World.
#include <cmath>

#include <fmt/format.h>

#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/narrowphase/inside/mesh_links.hpp>
#include <oncollide/narrowphase/self/self_near.hpp>
#include <oncollide/narrowphase/self/self_pairs.hpp>
#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/pipeline/world/world_impl.hpp>

namespace oncollide {

namespace {

using TriangleNumbers = std::vector<PairOf<std::uint32_t>>;

TriangleNumbers numbers_of(const std::vector<TrianglePair>& pairs)
{
    TriangleNumbers numbers;
    numbers.reserve(pairs.size());
    for (const TrianglePair& pair : pairs) numbers.push_back({pair.a, pair.b});
    return numbers;
}

std::vector<NearFeatures> near_in(const Mesh& mesh, double dhat, const SelfNearOptions& options, int threads)
{
    const auto refuse = [](const std::string& fault) { throw Error(ErrorKind::usage, "near_features: " + fault); };
    check_dhat(dhat);
    if (options.rings < 1) refuse("rings of 0; must be at least 1");
    if (!(options.rest_distance >= 0 && std::isfinite(options.rest_distance)))
        refuse(fmt::format("rest_distance of {}; must be 0 or more, and finite", options.rest_distance));
    if (!options.rest.empty() && options.rest.size() != mesh.vertices.size())
        refuse(fmt::format("rest has {} positions, and the mesh has {} vertices", options.rest.size(),
                           mesh.vertices.size()));
    if (options.rest.empty() && options.rest_distance > 0) refuse("rest_distance without the positions `rest`");
    for (std::size_t v = 0; v < options.rest.size(); ++v)
        if (!(options.rest[v].array().abs() <= 1e15).all()) // false for NaN
            refuse(fmt::format("rest: position {} is not finite, or above 1e15", v));
    return self_near(mesh, links_of(mesh).vertex, dhat, options, threads);
}

} // namespace

TriangleNumbers Models::self_contacts(ModelId id, std::size_t most) const
{
    WorldImpl& p = *world_;
    const Model& model = p.model_of(id);
    const int threads = p.frame.context.threads;
    const ExecutorScope scope(p.settings.executor);
    if (!model.is_mesh()) return {};
    return model.cooked() ? numbers_of(self_pairs(model.cooked()->whole(), most, threads))
                          : numbers_of(self_pairs(*model.mesh(), most, threads));
}

std::vector<NearFeatures> Models::near_features(ModelId id, double dhat, const SelfNearOptions& options) const
{
    WorldImpl& p = *world_;
    const Model& model = p.model_of(id);
    const int threads = p.frame.context.threads;
    const ExecutorScope scope(p.settings.executor);
    if (!model.is_mesh()) throw Error(ErrorKind::usage, "near_features: the model is no mesh");
    return model.cooked() ? near_in(model.cooked()->whole(), dhat, options, threads)
                          : near_in(*model.mesh(), dhat, options, threads);
}

TriangleNumbers self_contacts(const Mesh& mesh, std::size_t most)
{
    check_mesh("mesh", mesh);
    return numbers_of(self_pairs(mesh, most, 1));
}

std::vector<NearFeatures> near_features(const Mesh& mesh, double dhat, const SelfNearOptions& options)
{
    check_mesh("mesh", mesh);
    return near_in(mesh, dhat, options, 1);
}

} // namespace oncollide
