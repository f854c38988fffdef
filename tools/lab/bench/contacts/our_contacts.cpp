#include "bench/contacts/our_contacts.hpp"

#include <map>

#include "common/race.hpp"

namespace oncollide::tools {

OurContacts::OurContacts(const ContactScene& scene, int threads)
    : world_({.clearance = scene.margin, .mode = Mode::solid, .open_as_surface = true, .threads = threads}),
      margin_(scene.margin)
{
    std::map<const Geometry*, ModelId> models;
    for (const ContactBody& body : scene.bodies) {
        auto [at, added] = models.emplace(body.geometry.get(), ModelId{});
        if (added) at->second = world_.models().add(body.geometry);
        const bool is_static = body.half.isZero(0);
        ids_.push_back(world_.bodies().add({.model = at->second, .pose = body.pose, .is_static = is_static}));
    }
}

void OurContacts::place(std::span<const Eigen::Isometry3d> poses)
{
    if (!poses.empty()) world_.bodies().set_pose(ids_, poses);
}

std::size_t OurContacts::contacts()
{
    world_.step();
    const Clock::time_point from = Clock::now();
    manifolds_ = &world_.manifolds({.margin = margin_});
    manifolds_ms_ = milliseconds_since(from);
    return manifolds_->points.size();
}

std::size_t OurContacts::contacts_of(std::span<const BodyPair> pairs)
{
    if (pairs_.empty())
        for (const auto& [a, b] : pairs) pairs_.push_back({ids_[a], ids_[b]});
    world_.pairs().manifold(pairs_, {.margin = margin_}, lists_);
    return lists_.points.size();
}

} // namespace oncollide::tools
