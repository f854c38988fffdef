#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world/placed_tests.hpp>

#include <oncollide/pipeline/world/query_worker.hpp>

namespace oncollide {

struct WorldAccess::PlacedTests::Parts {
    WorldImpl& world;
    Settings settings;
    WorldImpl::QueryWorker worker;

    explicit Parts(WorldImpl& impl) : world(impl), settings(settings_of(impl)), worker(impl, settings) {}

    static Settings settings_of(const WorldImpl& impl)
    {
        Settings s = impl.settings;
        const bool bounds_pairs = s.exact == ExactLevel::off && s.max_error && s.clearance == 0 && wants_obbs(s) &&
                                  s.memory_budget == 0 && s.skip.empty();
        if (bounds_pairs && impl.requested_exact == ExactLevel::automatic) s.exact = ExactLevel::predicates;
        return s;
    }
};

WorldAccess::PlacedTests::PlacedTests(const World& world) : parts_(std::make_unique<Parts>(world.impl())) {}

WorldAccess::PlacedTests::~PlacedTests() = default;

bool WorldAccess::PlacedTests::are_of(const World& world) const
{
    return &parts_->world == &world.impl();
}

void WorldAccess::PlacedTests::begin()
{
    parts_->world.bring_up_to_date();
    parts_->worker.context.frame = parts_->world.frame.number;
}

Model& WorldAccess::PlacedTests::model(ModelId id) const
{
    return parts_->world.check_model(id);
}

std::span<const AabbHit> WorldAccess::PlacedTests::around(std::span<const Aabb> boxes, const CollisionFilter& filter)
{
    WorldImpl& world = parts_->world;
    std::vector<AabbHit>& hits = parts_->worker.hits;
    world.broad->query(world.bodies.columns(), boxes, hits);
    std::erase_if(hits, [&](const AabbHit& hit) { return !world.allows(filter, hit.body); });
    return hits;
}

bool WorldAccess::PlacedTests::allows(const CollisionFilter& filter, std::uint32_t slot) const
{
    return parts_->world.allows(filter, slot);
}

Model& WorldAccess::PlacedTests::model_at(std::uint32_t slot) const
{
    return parts_->world.bodies.model(slot);
}

const Eigen::Isometry3d& WorldAccess::PlacedTests::pose_at(std::uint32_t slot) const
{
    return parts_->world.bodies.pose(slot);
}

BodyId WorldAccess::PlacedTests::body_at(std::uint32_t slot) const
{
    return parts_->world.bodies.id(slot);
}

bool WorldAccess::PlacedTests::is_exact() const
{
    return exact_runs(parts_->settings) && exact_level(parts_->settings) == ExactLevel::predicates;
}

std::span<const Finding> WorldAccess::PlacedTests::decide(std::span<const PairTask> tasks)
{
    WorldImpl::QueryWorker& worker = parts_->worker;
    worker.context.trees = {}, worker.context.rounds.clear();
    worker.tasks.assign(tasks.begin(), tasks.end());
    worker.refined.resize(tasks.size());
    parts_->world.decide(worker, worker.refined);
    return worker.refined;
}

Finding WorldAccess::PlacedTests::within(const PairTask& task, double clearance)
{
    if (clearance <= parts_->settings.clearance) return {Verdict::separate, ContactKind::unknown, clearance};
    parts_->world.need_trees({&task, 1});
    const Finding found = parts_->world.models.with_room(
        [&] { return tests_for(task).near(parts_->worker.pairs, task, clearance, 0, nullptr); });
    return {found.verdict == Verdict::separate ? Verdict::separate : Verdict::within, ContactKind::near, clearance};
}

Distance WorldAccess::PlacedTests::distance(const PairTask& task, const DistanceOptions& options)
{
    if (const auto direct = tests_for(task).direct_distance) return direct(task, options);
    parts_->world.need_trees({&task, 1});
    return parts_->world.distance(parts_->worker, task, options);
}

const Manifold& WorldAccess::PlacedTests::manifold(const PairTask& task, const ManifoldOptions& options)
{
    parts_->world.need_trees({&task, 1});
    parts_->world.manifold(parts_->worker, task, options, parts_->worker.manifold);
    return parts_->worker.manifold;
}

} // namespace oncollide
