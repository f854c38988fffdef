#pragma once
#include <memory>
#include <random>
#include <vector>

#include <oncollide/pipeline/world.hpp>

#include "random_pose.hpp"

namespace oncollide {

/// Bodies that move at random, in several Worlds at once. The models of the Worlds come from the tests.
class ChangingScene {
public:
    ChangingScene(std::uint64_t seed, const std::vector<Settings>& settings) : random_(seed)
    {
        for (const Settings& s : settings) worlds_.push_back(std::make_unique<World>(s));
    }
    World& world(std::size_t i) { return *worlds_[i]; }

protected:
    struct Body {
        std::uint32_t model;
        Eigen::Isometry3d pose;
        bool is_static;
    };
    void add_model(const std::shared_ptr<const Geometry>& geometry)
    {
        for (auto& world : worlds_) world->models().add(geometry);
    }
    void add_body(const Body& body)
    {
        bodies_.push_back(body);
        for (auto& world : worlds_) world->bodies().add(spec(*world, body));
    }
    /// One of `resting` bodies moves a little; one of ten of these jumps.
    void move_bodies(std::size_t resting, double reach)
    {
        for (std::uint32_t i = 0; i < bodies_.size(); ++i) {
            if (below(resting)) continue;
            if (below(10) == 0) bodies_[i].pose = random_pose(random_(), reach);
            bodies_[i].pose.translation() += 0.02 * Eigen::Vector3d(u() - 0.5, u() - 0.5, u() - 0.5);
            for (auto& world : worlds_) world->bodies().set_pose(world->bodies().at(i), bodies_[i].pose);
        }
    }
    /// Adds all bodies to a World without history, whose models are there.
    void add_bodies_to(World& world) const
    {
        for (const Body& body : bodies_) world.bodies().add(spec(world, body));
    }
    double u() { return std::uniform_real_distribution<>()(random_); }
    std::size_t below(std::size_t n) { return random_() % n; }

    std::mt19937_64 random_;
    std::vector<std::unique_ptr<World>> worlds_;
    std::vector<Body> bodies_;

private:
    static BodySpec spec(const World& world, const Body& body)
    {
        return {.model = world.models().at(body.model), .pose = body.pose, .is_static = body.is_static};
    }
};

/// Settings in which Worlds are compared.
struct SettingsCase {
    const char* name;
    Settings settings;
    bool same_bits; ///< decided exactly, so that hashes are equal
    int frames = 300;
};

inline std::vector<SettingsCase> settings_cases()
{
    return {{"default", {}, true},
            {"kinds", {.exact = ExactLevel::predicates, .contact_kinds = true}, true},
            {"touching", {.exact = ExactLevel::predicates, .ignore_touching = true}, true},
            {"solid", {.exact = ExactLevel::predicates, .mode = Mode::solid, .open_as_surface = true}, true},
            {"without_coherence", {.exact = ExactLevel::predicates, .coherence = false}, true},
            {"clearance", {.clearance = 0.02, .exact = ExactLevel::predicates}, false},
            {"error", {.max_error = 0.002, .clearance = 0.01}, false}};
}

} // namespace oncollide
