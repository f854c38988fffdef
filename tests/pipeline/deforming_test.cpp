// World::models().set_vertices(): Worlds whose meshes deform have the results of a new World.
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "changing_scene.hpp"
#include "deforming_mesh.hpp"
#include "every_kind.hpp"
#include "random_pose.hpp"
#include "same_results.hpp"

namespace oncollide::deforming_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// Meshes that deform, open and closed, small and large, among bodies of every kind, in several Worlds at once.
class Scene : public ChangingScene {
public:
    Scene(std::uint64_t seed, const std::vector<Settings>& settings) : ChangingScene(seed, settings)
    {
        add_mesh(make_torus_knot_mesh(2, 3, 0.4, 0.2, 0.08, 400));
        add_mesh(make_sphere_mesh(0.5, 200));
        add_mesh(make_box_mesh({0.4, 0.3, 0.5}, 3)); // vertices at equal positions, and coplanar triangles
        add_mesh(make_terrain_mesh(1.4, 0.2, 24, seed));
        add_mesh(make_torus_mesh(0.4, 0.15, 3000));
        for (std::size_t kind = 0; kind < kinds; ++kind) {
            partners_.push_back(
                std::make_shared<const Geometry>(Geometry{every_kind[kind], draw_geometry(kind, seed + kind), {}}));
            add_model(partners_.back());
        }
        const auto models = static_cast<std::uint32_t>(meshes_.size() + partners_.size());
        for (std::uint32_t i = 0; i < 2 * models; ++i) {
            const auto pose = i % 3 ? random_pose(random_(), 1.6) : Isometry3d(Eigen::Translation3d(u(), u(), u()));
            add_body({i % models, pose, i % 5 == 4});
        }
    }

    /// Some meshes deform, most bodies rest, some move a little or jump.
    void change()
    {
        for (std::uint32_t m = 0; m < meshes_.size(); ++m) {
            if (below(3) == 0) continue;
            DeformingMesh& mesh = meshes_[m];
            if (below(25) == 0) mesh.how = static_cast<DeformingWay>(below(deformations));
            mesh.time += below(8) ? 0.003 : 0.1 * u();
            const std::vector<Vector3d> now = deformed(mesh.rest, mesh.how, mesh.time);
            const std::size_t first = below(3) ? 0 : below(now.size()),
                              count = first || below(4) == 0 ? below(now.size() - first + 1) : now.size();
            for (auto& world : worlds_)
                if (count == now.size())
                    world->models().set_vertices(world->models().at(m), now);
                else
                    world->models().set_vertices(world->models().at(m), first, std::span(now).subspan(first, count));
        }
        move_bodies(6, 1.6);
    }
    /// A World without history.
    World fresh(const Settings& settings)
    {
        World world(settings);
        for (std::uint32_t m = 0; m < meshes_.size(); ++m)
            world.models().add(worlds_[0]->models().geometry(worlds_[0]->models().at(m)).data);
        for (const auto& partner : partners_) world.models().add(partner);
        add_bodies_to(world);
        return world;
    }
    /// Gives all bodies ways to go.
    void set_motions(World& world, std::uint64_t seed) const
    {
        for (std::uint32_t i = 0; i < bodies_.size(); ++i)
            if (u01(seed, i, 0) < 0.5) {
                Isometry3d to = bodies_[i].pose;
                to.translation() += 0.3 * Vector3d(u01(seed, i, 1) - 0.5, u01(seed, i, 2) - 0.5, u01(seed, i, 3) - 0.5);
                world.bodies().set_motion(world.bodies().at(i), to);
            }
    }

    void set_poses(World& world) const
    {
        for (std::uint32_t i = 0; i < bodies_.size(); ++i)
            world.bodies().set_pose(world.bodies().at(i), bodies_[i].pose);
    }

private:
    struct DeformingMesh {
        std::vector<Vector3d> rest;
        DeformingWay how;
        double time = 0;
    };
    void add_mesh(Mesh mesh)
    {
        const auto geometry = std::make_shared<const Geometry>(Geometry{"deforming", std::move(mesh), {}});
        meshes_.push_back({std::get<Mesh>(geometry->data).vertices, static_cast<DeformingWay>(meshes_.size()), 0.1});
        add_model(geometry);
    }
    std::vector<DeformingMesh> meshes_;
    std::vector<std::shared_ptr<const Geometry>> partners_;
};

std::vector<SettingsCase> cases()
{
    std::vector<SettingsCase> all = settings_cases();
    Settings sphere_trees{.bounding_volume = BoundingVolume::sphere};
    sphere_trees.depth = 4;
    all.push_back({"sphere_trees", sphere_trees, false});
    return all;
}

class Deforming : public testing::TestWithParam<SettingsCase> {};
class DeformingInContact : public Deforming {};

TEST_P(Deforming, GivesTheResultsOfANewWorld)
{
    const Settings settings = GetParam().settings;
    std::uint64_t found = 0, by_gap = 0, kept = 0, differ = 0;
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
        Settings threads = settings;
        threads.threads = seed % 2 ? 2 : 4;
        Scene scene(seed, {settings, threads});
        for (int frame = 0; frame < 150; ++frame) {
            if (frame) scene.change();
            const FrameView view = scene.world(0).step();
            const std::string when = "seed " + std::to_string(seed) + ", frame " + std::to_string(frame);
            by_gap += view.trees.by_gap, kept += view.trees.kept;
            ASSERT_EQ(scene.world(1).step().hash, view.hash) << when << ": threads";
            World fresh = scene.fresh(settings);
            const FrameView expected = fresh.step();
            const auto now = found_in(view), then = found_in(expected);
            found += now.size();
            if (GetParam().same_bits) {
                if (view.hash != expected.hash)
                    for (const auto& [slots, r] : then) {
                        const auto it = now.find(slots);
                        EXPECT_TRUE(it != now.end() && it->second.verdict == r.verdict)
                            << slots.first << " " << slots.second;
                    }
                ASSERT_EQ(view.hash, expected.hash) << when;
            } else {
                for (const PairResult& r : view.pairs) {
                    const auto other = then.find({r.a.slot, r.b.slot});
                    const bool same = r.verdict == (other == then.end() ? Verdict::separate : other->second.verdict);
                    differ += !same;
                    if (same && r.verdict != Verdict::separate) {
                        ASSERT_NEAR(r.bound, other->second.bound, 1e-9) << when;
                    }
                    if (same && frame % 10) continue;
                    ASSERT_TRUE(same || settings.max_error || settings.depth) << when;
                    expect_true(r, fresh.pairs().distance(fresh.bodies().at(r.a.slot), fresh.bodies().at(r.b.slot)),
                                settings, when);
                }
            }
            if (settings.mode == Mode::solid) continue;
            for (const PairResult& r : view.pairs) // bounds of pairs apart hold
                if (r.verdict == Verdict::separate && frame % 30 == 7 && r.bound > 0) {
                    const auto a = fresh.bodies().at(r.a.slot), b = fresh.bodies().at(r.b.slot);
                    ASSERT_LE(r.bound, fresh.pairs().distance(a, b).upper + 2e-6) << when;
                }
        }
    }
    EXPECT_GT(found, 10'000u);
    EXPECT_LT(differ, found / 100);
    if (!settings.coherence) return;
    EXPECT_GT(kept, 1000u);
    if (settings.bounding_volume != BoundingVolume::sphere && settings.mode != Mode::solid) {
        EXPECT_GT(by_gap, 1000u) << "remembered gaps are used";
    }
}

TEST_P(DeformingInContact, GivesTheManifoldsContactsAndSweepsOfANewWorld)
{
    const Settings settings = GetParam().settings;
    std::size_t regions = 0, contacts = 0, swept = 0;
    Scene scene(5, {settings});
    for (int frame = 0; frame < 30; ++frame) {
        if (frame) scene.change();
        const std::string when = "frame " + std::to_string(frame);
        World& live = scene.world(0);
        const FrameView view = live.step();
        World fresh = scene.fresh(settings);
        fresh.step();
        const ManifoldOptions options{.margin = frame % 3 ? 0 : 0.01};
        const FrameManifolds &now = live.manifolds(options), &expected = fresh.manifolds(options);
        regions += now.regions.size();
        if (GetParam().same_bits) {
            ASSERT_NO_FATAL_FAILURE(expect_same(now, expected, when));
        }
        for (const PairResult& r : view.pairs) {
            if (r.verdict == Verdict::separate || (r.a.slot + r.b.slot + std::uint32_t(frame)) % 8) continue;
            const auto a = fresh.bodies().at(r.a.slot), b = fresh.bodies().at(r.b.slot);
            const auto found = live.pairs().contacts(r.a, r.b), same = fresh.pairs().contacts(a, b);
            ASSERT_EQ(found.size(), same.size()) << when;
            for (std::size_t i = 0; i < found.size(); ++i) {
                ASSERT_EQ(found[i].a, same[i].a) << when;
                ASSERT_EQ(found[i].b, same[i].b) << when;
            }
            contacts += found.size();
        }
        if (frame % 10 == 9) {
            scene.change();
            World moving = scene.fresh(settings);
            scene.set_motions(live, std::uint64_t(frame)), scene.set_motions(moving, std::uint64_t(frame));
            const FrameView ways = live.step(), others = moving.step();
            std::map<Slots, PairSweep> by_pair;
            for (const PairSweep& s : others.sweeps)
                by_pair[{others.pairs[s.pair].a.slot, others.pairs[s.pair].b.slot}] = s;
            for (const PairSweep& s : ways.sweeps) {
                if (s.verdict == Verdict::separate) continue;
                const PairResult& pair = ways.pairs[s.pair];
                const PairSweep& other = by_pair.at({pair.a.slot, pair.b.slot});
                ASSERT_EQ(s.verdict, other.verdict) << when;
                ASSERT_NEAR(s.contact_by, other.contact_by, 1e-3) << when;
                ++swept;
            }
            scene.set_poses(live);
        }
    }
    EXPECT_GT(regions, 500u);
    EXPECT_GT(contacts, 100u);
    EXPECT_GT(swept, 20u);
}

std::vector<SettingsCase> cases_in_contact()
{
    std::vector<SettingsCase> some = cases();
    std::erase_if(some, [](const SettingsCase& c) {
        const std::string name = c.name;
        return name != "default" && name != "solid" && name != "clearance";
    });
    return some;
}

INSTANTIATE_TEST_SUITE_P(SomeSettings, DeformingInContact, testing::ValuesIn(cases_in_contact()),
                         [](const auto& info) { return std::string(info.param.name); });
INSTANTIATE_TEST_SUITE_P(EverySetting, Deforming, testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.name); });

} // namespace
} // namespace oncollide::deforming_test
