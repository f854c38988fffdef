// World::models().set_heights(): Worlds whose terrains change have the results of a new World.
#include <memory>

#include <gtest/gtest.h>

#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "changing_scene.hpp"
#include "digging.hpp"
#include "every_kind.hpp"
#include "random_pose.hpp"
#include "same_results.hpp"

namespace oncollide::digging_test {
namespace {

using Eigen::Isometry3d;

/// Terrains that are dug, with and without holes, of all storages, among bodies of every kind, in several Worlds at
/// once.
class Scene : public ChangingScene {
public:
    Scene(std::uint64_t seed, const std::vector<Settings>& settings) : ChangingScene(seed, settings)
    {
        terrains_.emplace_back(41, 33, 0.1, 0, 0, seed);        // of doubles
        terrains_.emplace_back(21, 17, 0.2, 0.125, 0.05, seed); // of bytes, with holes
        terrains_.emplace_back(9, 70, 0.25, 0.25, 0, seed);     // long, and often flat
        terrains_.emplace_back(3, 2, 1.5, 1.0 / 1024, 0, seed); // of two bytes; two cells
        for (const DugTerrain& dug : terrains_)
            for (auto& world : worlds_) world->models().add(dug.made());
        for (std::size_t kind = 0; kind < 2 * kinds; ++kind) {
            partners_.push_back(std::make_shared<const Geometry>(
                Geometry{every_kind[kind % kinds], draw_geometry(kind % kinds, seed + kind), {}}));
            add_model(partners_.back());
        }
        const auto grounds = static_cast<std::uint32_t>(terrains_.size());
        const auto models = static_cast<std::uint32_t>(grounds + partners_.size());
        for (std::uint32_t i = 0; i < models + 2; ++i) { // two terrains have a second body
            Isometry3d pose = i % 3 ? random_pose(random_(), 2) : Isometry3d(Eigen::Translation3d(u(), u(), u()));
            if (i < grounds) pose = Isometry3d(Eigen::Translation3d(0.25 * i, 0, 1.25 - i));
            add_body({i < models ? i : 1 + 2 * (i - models), pose, i < grounds && i % 2 == 0});
        }
    }

    /// Some terrains are dug, most bodies rest, some move a little or jump.
    void change()
    {
        for (std::uint32_t t = 0; t < terrains_.size(); ++t) {
            if (below(2)) continue;
            const Dig dig = terrains_[t].dig();
            for (auto& world : worlds_)
                world->models().set_heights(world->models().at(t), dig.where, dig.heights), ++digs;
        }
        move_bodies(8, 1.5);
        for (auto& world : worlds_) // a change of a terrain wakes its bodies
            for (std::uint32_t i = 0; i < bodies_.size(); i += 3) world->bodies().sleep(world->bodies().at(i));
    }
    /// A World without history, of terrains that are made anew.
    World fresh(const Settings& settings) const
    {
        World world(settings);
        for (const DugTerrain& dug : terrains_) world.models().add(dug.made());
        for (const auto& partner : partners_) world.models().add(partner);
        add_bodies_to(world);
        return world;
    }
    int digs = 0;

private:
    std::vector<DugTerrain> terrains_;
    std::vector<std::shared_ptr<const Geometry>> partners_;
};

std::vector<SettingsCase> cases()
{
    std::vector<SettingsCase> all = settings_cases();
    all.front().frames = 1000;
    return all;
}

class Digging : public testing::TestWithParam<SettingsCase> {};

TEST_P(Digging, GivesTheResultsOfANewWorld)
{
    const Settings settings = GetParam().settings;
    Settings threads = settings;
    threads.threads = 2;
    Scene scene(1, {settings, threads});
    std::size_t found = 0, kept = 0, by_gap = 0, differ = 0, regions = 0, contacts = 0;
    for (int frame = 0; frame < GetParam().frames; ++frame) {
        if (frame) scene.change();
        const std::string when = "frame " + std::to_string(frame);
        const FrameView view = scene.world(0).step();
        by_gap += view.trees.by_gap, kept += view.trees.kept;
        ASSERT_EQ(scene.world(1).step().hash, view.hash) << when << ": threads";
        World fresh = scene.fresh(settings);
        const FrameView expected = fresh.step();
        const auto now = found_in(view), then = found_in(expected);
        found += now.size();
        if (GetParam().same_bits) {
            ASSERT_EQ(view.hash, expected.hash) << when;
            if (frame % 20 < 2) { // the second frame keeps some of the first one's
                const ManifoldOptions options{.margin = frame % 40 < 20 ? 0 : 0.01};
                const FrameManifolds& manifolds = scene.world(0).manifolds(options);
                ASSERT_NO_FATAL_FAILURE(expect_same(manifolds, fresh.manifolds(options), when));
                ASSERT_EQ(scene.world(1).manifolds(options).points.size(), manifolds.points.size()) << when;
                regions += manifolds.regions.size();
            }
            for (std::size_t i = std::size_t(frame) % 7; i < view.pairs.size(); i += 7)
                if (view.pairs[i].verdict == Verdict::colliding) {
                    ASSERT_NO_FATAL_FAILURE(expect_same_contacts(scene.world(0), fresh, view.pairs[i], when, contacts));
                }
        } else {
            for (const PairResult& r : view.pairs) {
                const auto other = then.find({r.a.slot, r.b.slot});
                const bool same = r.verdict == (other == then.end() ? Verdict::separate : other->second.verdict);
                differ += !same;
                if (same && r.verdict != Verdict::separate) {
                    ASSERT_NEAR(r.bound, other->second.bound, 1e-9) << when;
                }
                if (same && frame % 10) continue;
                ASSERT_TRUE(same || settings.max_error) << when;
                const auto a = fresh.bodies().at(r.a.slot), b = fresh.bodies().at(r.b.slot);
                expect_true(r, fresh.pairs().distance(a, b), settings, when);
            }
        }
        for (const PairResult& r : view.pairs) // bounds of pairs apart hold
            if (settings.mode != Mode::solid && r.verdict == Verdict::separate && frame % 10 == 7 && r.bound > 0) {
                const auto a = fresh.bodies().at(r.a.slot), b = fresh.bodies().at(r.b.slot);
                ASSERT_LE(r.bound, fresh.pairs().distance(a, b).upper + 2e-6) << when;
            }
    }
    const auto frames = std::size_t(GetParam().frames);
    EXPECT_GT(std::size_t(scene.digs), 3 * frames);
    EXPECT_GT(found, 50 * frames);
    EXPECT_LT(differ, found / 100);
    if (GetParam().same_bits) {
        EXPECT_GT(regions, 5 * frames);
        EXPECT_GT(contacts, 10 * frames);
    }
    if (settings.coherence) {
        EXPECT_GT(kept, 10 * frames);
        EXPECT_GT(by_gap, 2 * frames);
    }
}

INSTANTIATE_TEST_SUITE_P(EverySetting, Digging, testing::ValuesIn(cases()),
                         [](const auto& info) { return std::string(info.param.name); });

} // namespace
} // namespace oncollide::digging_test
