#include "bench/contacts/our_physics.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <oncollide/samples/impulse_solver.hpp>

#include "common/statistics.hpp"

namespace oncollide::tools {
namespace {

constexpr double still_speed = 0.05, still_spin = 0.5; ///< m/s, rad/s: slower bodies fall asleep
constexpr double still_time = 0.5;                     ///< seconds that they must be slow before
constexpr double waking_speed = 0.15;                  ///< of a body that wakes its neighbours, m/s

class OurPhysics final : public PhysicsPeer {
public:
    OurPhysics(std::span<const PhysicsBody> bodies, const PhysicsSettings& settings, int threads)
        : settings_(settings),
          world_({.clearance = margin, .mode = Mode::solid, .open_as_surface = true, .threads = threads}),
          solver_(world_)
    {
        solver_.dt = settings.dt, solver_.friction = settings.friction, solver_.margin = margin;
        solver_.slop = 2e-3, solver_.iterations = 10, solver_.relaxations = 4;
        std::map<const Geometry*, ModelId> models;
        for (const PhysicsBody& of : bodies) {
            auto [at, added] = models.emplace(of.geometry, ModelId{});
            if (added) // the caller keeps the geometries
                at->second = world_.models().add(std::shared_ptr<const Geometry>(of.geometry, [](auto*) {}));
            const BodyId id = world_.bodies().add({.model = at->second, .pose = of.pose, .is_static = of.mass == 0});
            solver_.bodies.push_back({.id = id});
            states_.emplace_back();
            if (of.mass == 0) continue;
            states_.back() = {.inverse_mass = 1 / of.mass, .inverse_inertia = of.inertia.cwiseInverse(), .moves = true};
            wake(solver_.bodies.size() - 1);
        }
    }
    PhysicsStep step() override
    {
        PhysicsStep done;
        const Clock::time_point from = Clock::now();
        solver_.detect();
        done.detection_ms = milliseconds_since(from);
        wake_neighbours();
        solver_.advance();
        const double kept = std::pow(1 - settings_.damping, settings_.dt);
        const double spin_kept = std::pow(1 - settings_.spin_damping, settings_.dt);
        for (std::size_t i = 0; i < states_.size(); ++i) {
            example::RigidBody& body = solver_.bodies[i];
            if (body.inverse_mass == 0) continue;
            body.velocity *= kept, body.spin *= spin_kept;
            ++done.awake, done.fastest = std::max(done.fastest, body.velocity.norm());
            const bool still = body.velocity.norm() < still_speed && body.spin.norm() < still_spin;
            states_[i].still = still ? states_[i].still + settings_.dt : 0;
            if (states_[i].still >= still_time) sleep(i);
        }
        done.contacts = solver_.manifolds().points.size();
        done.solver_ms = milliseconds_since(from) - done.detection_ms;
        return done;
    }
    void poses(std::vector<Eigen::Isometry3d>& poses) const override
    {
        poses.clear();
        for (const example::RigidBody& body : solver_.bodies) poses.push_back(world_.bodies().pose(body.id));
    }

private:
    static constexpr double margin = 5e-3;
    struct State {
        double inverse_mass = 0;
        Eigen::Vector3d inverse_inertia = Eigen::Vector3d::Zero();
        bool moves = false;
        double still = 0; ///< seconds for which it has been slow
    };

    void sleep(std::size_t i)
    {
        example::RigidBody& body = solver_.bodies[i];
        body = {.id = body.id};
    }
    void wake(std::size_t i)
    {
        example::RigidBody& body = solver_.bodies[i];
        body.inverse_mass = states_[i].inverse_mass, body.inverse_inertia = states_[i].inverse_inertia;
        states_[i].still = 0;
    }
    /// Moving bodies wake the bodies that they touch.
    void wake_neighbours()
    {
        for (const PairOfBodies& pair : solver_.manifolds().pairs) {
            const std::size_t a = pair.a.slot, b = pair.b.slot;
            const auto moves = [&](std::size_t i) { return solver_.bodies[i].velocity.norm() > waking_speed; };
            const auto asleep = [&](std::size_t i) { return states_[i].moves && solver_.bodies[i].inverse_mass == 0; };
            if (asleep(a) && moves(b)) wake(a);
            if (asleep(b) && moves(a)) wake(b);
        }
    }

    PhysicsSettings settings_;
    World world_;
    example::ImpulseSolver solver_;
    std::vector<State> states_; ///< of each body
};

} // namespace

std::unique_ptr<PhysicsPeer> make_our_physics(std::span<const PhysicsBody> bodies, const PhysicsSettings& settings,
                                              int threads)
{
    return std::make_unique<OurPhysics>(bodies, settings, threads);
}

} // namespace oncollide::tools
