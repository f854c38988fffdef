// An infinite ground under many bodies.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "every_kind.hpp"
#include "random_pose.hpp"
#include "truth/convex_truth.hpp"

namespace oncollide::half_space_test {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Crowd {
    World world;
    BodyId ground;
    std::vector<GeometryData> geometries;
    std::vector<ModelId> models;
    std::vector<BodyId> bodies;
};

Isometry3d place(std::uint64_t body, std::uint64_t frame)
{
    Isometry3d pose = random_pose(body, 60);
    pose.translation().z() = 5 * u01(body, 9, 0) - 0.5 + 0.2 * (u01(body, 10, frame) - 0.5);
    return pose;
}

Crowd crowd_of(const Settings& settings, const Isometry3d& ground, bool fixed, std::uint64_t count)
{
    Crowd crowd{World(settings), {}, {}, {}, {}};
    crowd.ground = crowd.world.bodies().add(
        {.model = crowd.world.models().add(Shape(HalfSpace{})), .pose = ground, .is_static = fixed});
    crowd.geometries = {Shape(Sphere{0.5}),  Shape(Box{{0.4, 0.5, 0.6}}), make_torus_mesh(0.5, 0.2, 300),
                        draw_geometry(7, 1), draw_geometry(9, 1),         small_terrain(1)};
    for (const GeometryData& g : crowd.geometries)
        crowd.models.push_back(std::visit([&](const auto& one) { return crowd.world.models().add(one); }, g));
    for (std::uint64_t i = 0; i < count; ++i)
        crowd.bodies.push_back(
            crowd.world.bodies().add({.model = crowd.models[i % crowd.models.size()], .pose = place(i, 0)}));
    return crowd;
}

/// Three frames: their hashes, and the number of pairs that are left over.
std::pair<std::uint64_t, std::size_t> played(const Settings& settings, const Isometry3d& ground, bool fixed = true)
{
    Crowd crowd = crowd_of(settings, ground, fixed, 2000);
    std::size_t pairs = 0;
    for (std::uint64_t frame = 0; frame < 3; ++frame) {
        for (std::uint64_t i = frame % 2; i < crowd.bodies.size(); i += 2)
            crowd.world.bodies().set_pose(crowd.bodies[i], place(i, frame));
        if (!fixed)
            crowd.world.bodies().set_pose(crowd.ground, Eigen::Translation3d(0, 0, 0.01 * double(frame)) * ground);
        pairs += crowd.world.step().pairs.size();
    }
    return {crowd.world.hash(), pairs};
}

const std::array grounds{Isometry3d::Identity(), Isometry3d(Eigen::AngleAxisd(0.02, Vector3d::UnitX())),
                         Isometry3d(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()))};

TEST(HalfSpaces, UnderManyBodiesLoseNoPairAndHaveOneResult)
{
    for (const Isometry3d& ground : grounds)
        for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates})
            for (const bool fixed : {true, false}) {
                const auto brute =
                    played({.exact = exact, .broad_phase = BroadPhaseKind::brute_force, .threads = 1}, ground, fixed);
                EXPECT_GT(brute.second, 500u);
                for (const BroadPhaseKind broad : {BroadPhaseKind::kd_tree, BroadPhaseKind::octree})
                    for (const int threads : {1, 3})
                        EXPECT_EQ(played({.exact = exact, .broad_phase = broad, .threads = threads}, ground, fixed),
                                  brute);
            }
}

/// The ground forms pairs with exactly the bodies that touch it, and bounds hold.
TEST(HalfSpaces, MeetWhatReachesIntoThem)
{
    for (const Isometry3d& ground : grounds)
        for (const ExactLevel exact : {ExactLevel::off, ExactLevel::predicates}) {
            Crowd crowd = crowd_of({.exact = exact}, ground, true, 600);
            std::vector<PairResult> of_ground(crowd.bodies.size());
            for (PairResult& pair : of_ground) pair.verdict = Verdict::separate, pair.bound = 0;
            for (const PairResult& pair : crowd.world.step().pairs)
                if (pair.a == crowd.ground) of_ground[pair.b.slot - 1] = pair;
            int meet = 0;
            for (std::uint64_t i = 0; i < crowd.bodies.size(); ++i) {
                const PairResult& found = of_ground[i];
                const auto sets = tools::convex_sets(crowd.geometries[i % crowd.geometries.size()], place(i, 0));
                const double truth = double(tools::half_space_distance(ground, sets).upper);
                SCOPED_TRACE(fmt::format("body {}, {} m", i, truth));
                if (found.verdict == Verdict::separate) {
                    EXPECT_GT(truth, 0);
                    EXPECT_LE(found.bound, truth + 1e-12);
                    EXPECT_GE(found.bound, 0);
                } else {
                    EXPECT_GE(found.bound, truth - 1e-12);
                    EXPECT_LE(truth, exact == ExactLevel::off ? 0.03 : 0);
                    ++meet;
                }
            }
            EXPECT_GT(meet, 40);
        }
}

/// A half-space rotated by quarter turns has a bounding box that ends at its plane.
TEST(HalfSpaces, AlongTheAxesArePairsOnlyOfWhatReachesTheirPlane)
{
    Crowd crowd = crowd_of({}, Isometry3d::Identity(), true, 2000);
    crowd.world.step();
    const auto stages = all_stage_names();
    std::size_t above = 0;
    for (std::uint64_t i = 0; i < crowd.bodies.size(); ++i) above += place(i, 0).translation().z() > 2.5;
    ASSERT_GT(above, 500u);
    const auto broad = std::size_t(std::ranges::find(stages, "broad") - stages.begin());
    Crowd without = crowd_of({}, Isometry3d(Eigen::Translation3d(0, 0, -100)), true, 2000);
    without.world.step();
    EXPECT_LE(crowd.world.inspect().totals[broad].out,
              without.world.inspect().totals[broad].out + crowd.bodies.size() - above);
}

} // namespace
} // namespace oncollide::half_space_test
