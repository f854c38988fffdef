// Meshes that meet themselves: Models::self_contacts(), and the same without a World.
#include <oncollide/base/threads/parallel.hpp>
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

TriangleNumbers self_contacts(const Mesh& mesh, std::size_t most)
{
    check_mesh("mesh", mesh);
    return numbers_of(self_pairs(mesh, most, 1));
}

} // namespace oncollide
