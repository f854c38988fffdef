#include <gtest/gtest.h>

#include "every_kind.hpp"
#include "random_pose.hpp"
#include <oncollide/pipeline/world.hpp>
#include <oncollide/pipeline/world/world_access.hpp>

namespace oncollide {
namespace {

/// A World with a model of each kind, and poses of them.
struct OneOfEach {
    explicit OneOfEach(double clearance) : world({.clearance = clearance, .exact = ExactLevel::predicates})
    {
        for (std::size_t kind = 0; kind < kinds; ++kind)
            models.push_back(world.models().add(
                std::make_shared<const Geometry>(Geometry{every_kind[kind], draw_geometry(kind, 7), {}})));
    }
    PlacedModel placed(std::size_t kind, std::uint64_t seed) const { return {models[kind], random_pose(seed, 2)}; }
    World world;
    std::vector<ModelId> models;
};

TEST(WorldNear, NothingWithinTheReachIsFar)
{
    for (const double clearance : {0.0, 0.05}) {
        const OneOfEach all(clearance);
        std::vector<PairOfModels> pairs;
        std::vector<double> reaches;
        for (std::uint64_t i = 0; i < 4000; ++i) {
            pairs.push_back({all.placed(i % kinds, 3 * i), all.placed(i / kinds % kinds, 3 * i + 1)});
            reaches.push_back(i % 7 == 0 ? 0 : std::pow(10.0, 4 * u01(5, i, 0) - 3));
        }
        std::vector<std::uint8_t> near(pairs.size());
        WorldAccess::near(all.world, pairs, reaches, near);
        std::size_t far = 0, missed = 0;
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const Distance d = all.world.pairs().distance(pairs[i].a, pairs[i].b, {.cutoff = 100});
            if (!near[i]) {
                ASSERT_GT(d.upper, clearance + reaches[i]) << i;
            }
            far += !near[i], missed += near[i] && d.lower > 1.5 * (clearance + reaches[i]) + 0.1;
        }
        EXPECT_GT(far, 1000u); // the test tests something
        EXPECT_LT(missed, 400u);
    }
}

TEST(WorldNear, ModelsAreClearUntilTheBound)
{
    const OneOfEach all(0);
    std::vector<PairOf<MovingModel>> pairs;
    std::vector<double> margins;
    for (std::uint64_t i = 0; pairs.size() < 600; ++i) {
        const PlacedModel a = all.placed(i % kinds, 5 * i), b = all.placed(i / kinds % kinds, 5 * i + 1);
        const double margin = i % 2 ? 0 : 0.1 * u01(6, i, 0);
        if (!(all.world.pairs().distance(a, b, {.cutoff = 1}).lower > margin)) continue;
        const auto moved = [&](const Eigen::Isometry3d& pose, std::uint64_t seed) {
            const Eigen::Isometry3d by = random_pose(seed, 1);
            Eigen::Isometry3d to = pose;
            to.translation() += by.translation();
            to.rotate(Eigen::Quaterniond::Identity().slerp(0.1, Eigen::Quaterniond(by.linear())));
            return RigidMotion(pose, to);
        };
        pairs.push_back({{a.model, moved(a.pose, 5 * i + 2)}, {b.model, moved(b.pose, 5 * i + 3)}});
        margins.push_back(margin);
    }
    std::vector<double> until(pairs.size());
    WorldAccess::clear_until(all.world, pairs, margins, until);
    std::size_t whole = 0, part = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        whole += until[i] == 1, part += until[i] > 0 && until[i] < 1;
        for (int k = 0; k < 20; ++k) {
            const double time = until[i] * k / 20;
            const PlacedModel a{pairs[i].a.model, pairs[i].a.motion.pose(time)},
                b{pairs[i].b.model, pairs[i].b.motion.pose(time)};
            ASSERT_GT(all.world.pairs().distance(a, b, {.cutoff = 1}).upper, margins[i]) << i << " at " << time;
        }
    }
    EXPECT_GT(whole, 100u);
    EXPECT_GT(part, 20u);
}

TEST(WorldNear, BadInputIsRefused)
{
    const OneOfEach all(0);
    const std::vector<PairOfModels> pairs{{all.placed(0, 1), all.placed(1, 2)}};
    std::vector<std::uint8_t> near(1);
    EXPECT_THROW(WorldAccess::near(all.world, pairs, std::vector<double>{-1}, near), Error);
    EXPECT_THROW(WorldAccess::near(all.world, pairs, std::vector<double>{std::nan("")}, near), Error);
    EXPECT_THROW(WorldAccess::near(all.world, pairs, std::vector<double>{1, 2}, near), Error);
    const std::vector<PairOf<MovingModel>> moving{{{all.models[0], {}}, {all.models[1], {}}}};
    std::vector<double> until(1);
    EXPECT_THROW(WorldAccess::clear_until(all.world, moving, std::vector<double>{-1}, until), Error);
}

} // namespace
} // namespace oncollide
