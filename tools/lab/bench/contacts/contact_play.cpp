#include "bench/contacts/contact_play.hpp"

#include <algorithm>
#include <cmath>

#include <oncollide/samples/impulse_solver.hpp>

#include "bench/contacts/our_contacts.hpp"
#include "common/race.hpp"

namespace oncollide::tools {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// How a body has turned around z from one pose to the next.
double turn_between(const Isometry3d& from, const Isometry3d& to)
{
    const Eigen::Matrix3d turned = to.linear() * from.linear().transpose();
    return std::atan2(turned(1, 0) - turned(0, 1), turned(0, 0) + turned(1, 1));
}

void add_manifolds(PlayedScene& played, const ManifoldLists& lists)
{
    played.pairs = lists.complete.size(), played.regions = lists.regions.size(), played.points = lists.points.size();
    for (std::size_t i = 0; i < played.pairs; ++i) {
        std::size_t points = 0;
        for (std::size_t k = lists.offsets[i]; k < lists.offsets[i + 1]; ++k) points += lists.regions[k].count;
        played.most_points = std::max(played.most_points, points);
        played.complete = played.complete && lists.complete[i];
    }
    for (const ManifoldRegion& r : lists.regions) played.depth = std::max(played.depth, r.depth_lower);
    played.hash = hash_of(lists);
}

} // namespace

PlayedScene play(const ContactScene& scene, int steps, int threads)
{
    OurContacts ours(scene, threads);
    World& world = ours.world();
    example::ImpulseSolver solver(world);
    solver.dt = scene.dt, solver.friction = scene.friction, solver.margin = scene.margin, solver.slop = scene.slop;
    std::size_t first = scene.bodies.size(); // that moves
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const ContactBody& body = scene.bodies[i];
        const bool moves = !body.half.isZero(0);
        if (moves) first = std::min(first, i);
        solver.bodies.push_back(moves ? example::box_body(ours.ids()[i], body.half)
                                      : example::RigidBody{.id = ours.ids()[i]});
        solver.bodies.back().velocity = body.velocity;
    }
    const auto poses = [&] {
        Poses all;
        for (const BodyId id : ours.ids()) all.push_back(world.bodies().pose(id));
        return all;
    };
    PlayedScene played;
    if (steps == 0) { // as they are
        played.poses.push_back(poses());
        ours.contacts();
        add_manifolds(played, ours.manifolds());
        return played;
    }
    const Vector3d along = scene.bodies[first].velocity;
    Isometry3d before = world.bodies().pose(ours.ids()[first]), after_half = before;
    std::vector<double> step_ms;
    for (int i = 0; i < steps; ++i) {
        if (i >= steps - scene.timed) played.poses.push_back(poses());
        const double ms = least_ms(1, [&] { solver.step(); });
        if (i >= steps - scene.timed) step_ms.push_back(ms), add_manifolds(played, solver.manifolds());
        const Isometry3d now = world.bodies().pose(ours.ids()[first]);
        const double turn = turn_between(before, now) / (2 * M_PI);
        if (std::abs(played.turns) < 0.5 && std::abs(played.turns + turn) >= 0.5) after_half = now;
        played.turns += turn, before = now;
        if (!along.isZero(0) && i >= steps / 10) {
            const Vector3d& v = solver.bodies[first].velocity;
            played.speed = v.dot(along) / along.squaredNorm();
            played.aside = std::max(played.aside, (v - played.speed * along).norm());
        }
    }
    played.step_ms = median(step_ms);
    if (std::abs(played.turns) > 1)
        played.lead = (before.translation().z() - after_half.translation().z()) / (std::abs(played.turns) - 0.5);
    const double time = scene.dt * double(played.poses.size());
    for (std::size_t i = 0; i < ours.ids().size(); ++i) {
        const Vector3d way = world.bodies().pose(ours.ids()[i]).translation() - played.poses.front()[i].translation();
        played.creep = std::max(played.creep, way.norm() / time);
    }
    return played;
}

} // namespace oncollide::tools
