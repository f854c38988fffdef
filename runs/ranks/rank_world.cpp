#include <oncollide/runs/ranks/rank_world.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/runs/deforming_models.hpp>

namespace oncollide {

namespace {

/// Replaces slots in error messages by the scene's body indices.
template <class Call>
auto naming(std::uint32_t gid, Call call)
{
    try {
        return call();
    } catch (const Error& error) {
        const std::string_view what = error.what();
        const std::size_t colon = what.find(": ");
        const bool of_body = what.starts_with("body ") || what.starts_with("new body");
        if (what.starts_with("the pose ") || what.starts_with("motion: "))
            throw Error(error.kind(), fmt::format("body {}: {}", gid, what));
        throw Error(error.kind(), of_body ? fmt::format("body {}{}", gid, what.substr(colon)) : std::string(what));
    }
}

} // namespace

void check_for_ranks(const Settings& settings)
{
    const auto refuse = [](const char* what) {
        throw Error(ErrorKind::usage, std::string(what) + "; run in one process or omit the option");
    };
    if (settings.node_budget || settings.memory_budget)
        refuse("--node-budget and --memory-budget limit all trees together, but each process has only some of them");
    if (settings.skip.contains(StageId::broad))
        refuse("--skip broad needs all pairs of bodies, but no process has all bodies");
}

RankWorld::RankWorld(const GeometryList& geometries, const Settings& settings, const Partitioner& partition, int rank)
    : geometries_(geometries), partition_(partition), rank_(rank), world_(settings),
      half_margin_(0.5 * settings.clearance), models_(geometries.size()), known_(geometries.deforming().size())
{
    check_for_ranks(settings);
    check_for_ranks(geometries, settings);
    world_.set_pair_filter([this](auto pairs, auto choices) { choose(pairs, choices); });
}

void check_for_ranks(const GeometryList& geometries, const Settings& settings)
{
    if (geometries.deforming().empty() || (exact_runs(settings) && settings.clearance == 0)) return;
    throw Error(ErrorKind::usage,
                fmt::format("geometry '{}' deforms, and results within an error then depend on earlier frames, which "
                            "other processes may not have computed; run with --exact on and without --clearance, or in "
                            "one process",
                            geometries[geometries.deforming().front()].name));
}

ModelId RankWorld::model_of(std::uint32_t geometry)
{
    if (!models_[geometry]) models_[geometry] = add_model(world_.models(), geometries_, geometry);
    return *models_[geometry];
}

void RankWorld::renew_models()
{
    for (std::size_t k = 0; k < known_.size(); ++k) {
        const std::uint32_t g = geometries_.deforming()[k];
        if (models_[g] && known_[k] != geometries_.share(g)) renew_model(world_.models(), *models_[g], geometries_, g);
        known_[k] = geometries_.share(g);
    }
}

Aabb RankWorld::grown(const Aabb& box) const
{
    if (half_margin_ == 0) return box;
    // The broad phase rounds the difference of two coordinates; growing by the rounding keeps every pair that it finds.
    const Eigen::Vector3d far = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs());
    const Eigen::Vector3d by = 0x1p-50 * far + Eigen::Vector3d::Constant(half_margin_ * (1 + 0x1p-50));
    return {box.min - by, box.max + by};
}

Aabb RankWorld::box(const BodyHere& body)
{
    return naming(body.gid, [&] {
        const ModelId model = model_of(body.geometry);
        return grown(body.way.empty() ? WorldAccess::step_bounds(world_, model, body.pose)
                                      : WorldAccess::step_bounds(world_, model, RigidMotion(body.way)));
    });
}

void RankWorld::begin()
{
    ++step_;
    come_.clear();
}

void RankWorld::add(const BodyHere& body)
{
    const auto found = here_.find(body.gid);
    if (found == here_.end()) {
        come_.push_back(&body);
        return;
    }
    found->second.seen = step_;
    move(body, found->second.id);
}

void RankWorld::move(const BodyHere& body, BodyId id)
{
    naming(body.gid, [&] {
        if (!body.way.empty())
            world_.bodies().set_motion(id, RigidMotion(body.way));
        else if (world_.bodies().pose(id).matrix() != body.pose.matrix())
            world_.bodies().set_pose(id, body.pose);
    });
}

FrameView RankWorld::step()
{
    for (auto at = here_.begin(); at != here_.end();)
        if (at->second.seen != step_)
            world_.bodies().remove(at->second.id), at = here_.erase(at);
        else
            ++at;
    // Sorted by index, so slots do not depend on the order of messages.
    std::ranges::sort(come_, {}, &BodyHere::gid);
    for (const BodyHere* const come : come_) {
        const BodyHere& body = *come;
        const BodySpec spec{.model = model_of(body.geometry),
                            .pose = body.way.empty() ? body.pose : body.way.front().pose,
                            .is_static = body.is_static,
                            .layer = body.layer,
                            .mask = body.mask,
                            .group = body.group,
                            .user = body.gid};
        const BodyId id = naming(body.gid, [&] { return world_.bodies().add(spec); });
        move(body, id);
        here_.emplace(body.gid, Entry{id, step_});
        if (names_.size() <= id.slot) names_.resize(id.slot + std::size_t{1});
        names_[id.slot] = body.name;
        for (const std::uint32_t other : body.excluded)
            if (const auto found = here_.find(other); found != here_.end())
                world_.bodies().exclude(id, found->second.id);
    }
    come_.clear();
    pairs_.assign(names_.size(), 0);
    return world_.step();
}

void RankWorld::choose(std::span<const CandidatePair> pairs, std::span<PairChoice> choices)
{
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto& [a, b, box_a, box_b] = pairs[i];
        if (partition_.owner(grown(box_a).min.cwiseMax(grown(box_b).min)) != rank_) {
            choices[i] = PairChoice::drop;
            continue;
        }
        if (gid(b) < gid(a)) choices[i] = PairChoice::refine_swapped;
        ++pairs_[a.slot], ++pairs_[b.slot];
    }
}

std::uint32_t RankWorld::pairs_of(std::uint32_t gid) const
{
    const auto found = here_.find(gid);
    return found == here_.end() || found->second.id.slot >= pairs_.size() ? 0 : pairs_[found->second.id.slot];
}

} // namespace oncollide
