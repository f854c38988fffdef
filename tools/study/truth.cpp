#include "study/truth.hpp"

#include <algorithm>

#include "accuracy_check.hpp"

namespace oncollide::tools {

StudyTruth::StudyTruth(const Scene& scene, const Settings& asked, FclWorld& world)
    : scene_(scene), pipeline_(scene, {.clearance = asked.clearance,
                                       .exact = ExactLevel::predicates,
                                       .mode = asked.mode,
                                       .broad_phase = BroadPhaseKind::brute_force,
                                       .threads = asked.threads,
                                       .skip = {"delimitation"},
                                       .coherence = false}),
      contacts_(scene), world_(world)
{
}

void StudyTruth::step()
{
    colliding_.clear(), known_.clear();
    for (const PairResult& pair : pipeline_.step(scene_).pairs)
        if (pair.verdict != Verdict::separate) colliding_.push_back({index(pair.a), index(pair.b)});
}

bool StudyTruth::collide(BodyPair pair) const
{
    return std::ranges::binary_search(colliding_, pair);
}

MeshDistance StudyTruth::distance(BodyPair pair)
{
    const auto [at, fresh] = known_.try_emplace(pair);
    if (!fresh) return at->second;
    const auto is_mesh = [&](std::uint32_t body) {
        return std::holds_alternative<Mesh>(scene_.geometries[index(scene_.geometry[body])].data);
    };
    if (is_mesh(pair.a) && is_mesh(pair.b))
        return at->second = contacts_.distance(scene_, BodyId{pair.a}, BodyId{pair.b});
    const double distance = world_.distance(pair);
    return at->second = {std::max(0.0, distance - shape_rounding), distance};
}

} // namespace oncollide::tools
