// One level of refinement, and both in sequence: each pair gets its own result, whichever refiner took it.
#include <thread>

#include <gtest/gtest.h>

#include <oncollide/pipeline/refine/narrowing.hpp>

#include "pipeline/refine/refined_models.hpp"

namespace oncollide::narrowing_test {
namespace {

using enum Kind;
using test::RefinedModels;

constexpr Finding unrefined{Verdict::within, ContactKind::unknown, 0.5};

Eigen::Isometry3d at_x(double x)
{
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(x, 0.01, 0.02);
    return pose;
}

/// Pairs of models: `a` at the origin, `b` at some x.
struct Pairs {
    struct Pair {
        Model *a, *b;
        double x;
    };
    std::vector<PairTask> tasks;

    explicit Pairs(const std::vector<Pair>& pairs) : poses_(pairs.size())
    {
        for (std::uint32_t i = 0; i < pairs.size(); ++i) {
            poses_[i] = at_x(pairs[i].x);
            tasks.push_back({i, pairs[i].a, pairs[i].b, &origin_, &poses_[i]});
        }
    }

private:
    const Eigen::Isometry3d origin_ = Eigen::Isometry3d::Identity();
    std::vector<Eigen::Isometry3d> poses_;
};

RefineContext context_of(const Settings& settings, WorldMutex* guard = nullptr)
{
    return {settings, 0, 1, {}, {}, {}, guard};
}

/// The results of pairs that were not refined before.
std::vector<Finding> run(Narrowing& narrowing, const Settings& settings, std::span<const PairTask> tasks)
{
    RefineContext context = context_of(settings);
    std::vector<Finding> results(tasks.size(), unrefined);
    narrowing.run(context, tasks, nullptr, results);
    return results;
}

TEST(Narrowing, GivesEachPairTheResultThatItHasAlone)
{
    const Settings settings{.max_error = 0.05, .bounding_volume = BoundingVolume::sphere};
    RefinedModels models(settings);
    Model &ball = models.add(mesh), &hills = models.add(terrain), &box = models.add(polytope), &cells = models.add(map);
    // Alternately spheres and OBBs; separate and within in turn.
    const Pairs pairs({{&ball, &box, 5},
                       {&hills, &ball, 1},
                       {&ball, &ball, 1.5},
                       {&ball, &hills, 6},
                       {&cells, &ball, 9},
                       {&hills, &cells, 0.5},
                       {&box, &cells, 1}});
    const Verdict expected[] = {Verdict::separate, Verdict::within, Verdict::within, Verdict::separate,
                                Verdict::separate, Verdict::within, Verdict::within};
    Narrowing narrowing(settings, models.store, Level::refine);
    const std::vector<Finding> together = run(narrowing, settings, pairs.tasks);
    for (std::size_t i = 0; i < together.size(); ++i) EXPECT_TRUE(narrowing.decided(i)) << i;
    for (std::size_t i = 0; i < together.size(); ++i) {
        SCOPED_TRACE(i);
        EXPECT_EQ(together[i].verdict, expected[i]);
        EXPECT_EQ(run(narrowing, settings, std::span(pairs.tasks).subspan(i, 1))[0], together[i]);
    }
}

TEST(Narrowing, LeavesPairsThatPredicatesDecideAsTheyAre)
{
    const Settings settings{.exact = ExactLevel::predicates};
    RefinedModels models(settings);
    Model &ball = models.add(mesh), &box = models.add(polytope);
    const Pairs pairs({{&ball, &ball, 1}, {&ball, &box, 5}, {&box, &box, 1}});
    Narrowing refine(settings, models.store, Level::refine), exact(settings, models.store, Level::exact);
    EXPECT_EQ(run(refine, settings, pairs.tasks), std::vector(3, unrefined));
    const std::vector<Finding> decided = run(exact, settings, pairs.tasks);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_FALSE(refine.decided(i)) << i;
        EXPECT_TRUE(exact.decided(i)) << i;
        EXPECT_EQ(decided[i].verdict, i == 1 ? Verdict::separate : Verdict::colliding) << i;
    }
}

TEST(Narrowing, FindsNothingInsideForPairsThatItDoesNotDecide)
{
    const Settings settings{.exact = ExactLevel::predicates, .mode = Mode::solid};
    RefinedModels models(settings);
    const Pairs pairs({{&models.add(mesh), &models.add(make_sphere_mesh(0.25, 100)), 0.1}});
    Narrowing refine(settings, models.store, Level::refine);
    RefineContext context = context_of(settings);
    const Finding before{Verdict::separate, ContactKind::unknown, 0.25};
    std::vector<Finding> results{before};
    refine.run(context, pairs.tasks, nullptr, results);
    EXPECT_EQ(results[0], before) << "the exact level will decide it";
}

TEST(Narrowing, PairsWithoutRoomAreUndecidedAndKeepTheirBounds)
{
    const Settings settings{.exact = ExactLevel::predicates, .node_budget = 1};
    RefinedModels models(settings);
    Model &ball = models.add(mesh), &box = models.add(polytope);
    const Pairs pairs({{&ball, &ball, 1}, {&box, &box, 1}, {&ball, &box, 5}});
    Narrowing exact(settings, models.store, Level::exact);
    RefineContext context = context_of(settings);
    const Finding apart{Verdict::separate, ContactKind::unknown, 0.25};
    std::vector<Finding> results{unrefined, unrefined, apart};
    exact.run(context, pairs.tasks, nullptr, results);
    EXPECT_EQ(results[0], Finding(Verdict::undecided, ContactKind::unknown, unrefined.bound));
    EXPECT_EQ(results[1].verdict, Verdict::colliding) << "two shapes need no room";
    EXPECT_EQ(results[2], apart) << "it was decided before";
    EXPECT_FALSE(exact.decided(0) || exact.decided(2));
    EXPECT_TRUE(exact.decided(1));
}

TEST(Narrowing, PairsThatAStopLeavesAreUndecided)
{
    const Settings settings{.exact = ExactLevel::predicates, .stop = [] { return true; }};
    RefinedModels models(settings);
    Model& ball = models.add(mesh);
    const Pairs pairs({{&ball, &ball, 1}, {&ball, &ball, 3}});
    Narrowing exact(settings, models.store, Level::exact);
    for (const Finding& found : run(exact, settings, pairs.tasks))
        EXPECT_EQ(found, Finding(Verdict::undecided, ContactKind::unknown, unrefined.bound));
}

TEST(Narrowing, FindsWhatIsInsideOnlyWhereSurfacesAreCertainlyApart)
{
    const Settings settings{.exact = ExactLevel::predicates, .mode = Mode::solid};
    RefinedModels models(settings);
    Model &ball = models.add(mesh), &core = models.add(make_sphere_mesh(0.25, 100));
    const Pairs pairs({{&ball, &core, 0.1}, {&core, &ball, 0.9}, {&ball, &core, 4}, {&core, &ball, 0.1}});
    Narrowing exact(settings, models.store, Level::exact);
    const std::vector<Finding> found = run(exact, settings, pairs.tasks);
    const Finding inside{Verdict::colliding, ContactKind::enclosed, 0};
    EXPECT_EQ(found[0], inside);
    EXPECT_EQ(found[1].verdict, Verdict::colliding);
    EXPECT_NE(found[1].kind, ContactKind::enclosed) << "the surfaces meet";
    EXPECT_EQ(found[2].verdict, Verdict::separate);
    EXPECT_EQ(found[3], inside);
}

TEST(Narrowing, FindsNothingInsideWithoutRoomToKnowThatSurfacesAreApart)
{
    const Settings settings{.exact = ExactLevel::predicates, .mode = Mode::solid, .node_budget = 1};
    RefinedModels models(settings);
    const Pairs pairs({{&models.add(mesh), &models.add(make_sphere_mesh(0.25, 100)), 0.1}});
    Narrowing exact(settings, models.store, Level::exact);
    EXPECT_EQ(run(exact, settings, pairs.tasks)[0].verdict, Verdict::undecided);
}

TEST(Narrowing, GivesTheSameResultsWhereThreadsShareItsModels)
{
    const Settings settings{.exact = ExactLevel::predicates};
    RefinedModels models(settings);
    Model &ball = models.add(mesh), &ring = models.add(make_torus_mesh(1, 0.25, 400));
    const Pairs pairs({{&ball, &ring, 0.5}, {&ring, &ring, 1}, {&ball, &ring, 4}});
    WorldMutex guard;
    std::vector<std::vector<Finding>> found(4, std::vector<Finding>(3, unrefined));
    std::vector<std::thread> threads;
    for (std::vector<Finding>& results : found)
        threads.emplace_back([&] {
            Narrowing exact(settings, models.store, Level::exact);
            RefineContext context = context_of(settings, &guard);
            exact.run(context, pairs.tasks, nullptr, results);
        });
    for (std::thread& thread : threads) thread.join();
    for (const std::vector<Finding>& results : found) EXPECT_EQ(results, found[0]);
    EXPECT_EQ(found[0][0].verdict, Verdict::colliding);
    EXPECT_EQ(found[0][2].verdict, Verdict::separate);
}

TEST(BothLevels, GiveTheExactLevelThePairsThatAreOpen)
{
    Settings settings{.max_error = 0.2, .exact = ExactLevel::predicates, .bounding_volume = BoundingVolume::sphere};
    RefinedModels models(settings);
    Model& ball = models.add(mesh);
    const Pairs pairs(
        {{&ball, &ball, 5}, {&ball, &ball, 1.9}, {&ball, &ball, 4}, {&ball, &ball, 2}, {&ball, &ball, 1}});
    Narrowing refine(settings, models.store, Level::refine), exact(settings, models.store, Level::exact);
    const std::vector<Finding> refined = run(refine, settings, pairs.tasks), alone = run(exact, settings, pairs.tasks);
    const auto both = [&] {
        RefineContext context = context_of(settings);
        std::vector<Finding> results(pairs.tasks.size(), unrefined);
        BothLevels(settings, models.store).run(context, pairs.tasks, results);
        return std::pair(results, context.trees.narrowed);
    };
    const auto [results, narrowed] = both();
    std::uint64_t open = 0;
    for (std::size_t i = 0; i < results.size(); ++i) {
        SCOPED_TRACE(i);
        open += is_open(refined[i].verdict);
        EXPECT_EQ(results[i], is_open(refined[i].verdict) ? alone[i] : refined[i]);
    }
    EXPECT_EQ(open, 3u) << "two are far apart";
    EXPECT_EQ(results[1].verdict, Verdict::colliding);
    EXPECT_EQ(results[3].verdict, Verdict::separate);
    EXPECT_EQ(narrowed, open) << "pairs that the exact level examined";

    settings.skip = {StageId::refine};
    EXPECT_EQ(both(), std::pair(alone, std::uint64_t(5)));
    settings.skip = {StageId::exact};
    EXPECT_EQ(both().first, refined);
}

} // namespace
} // namespace oncollide::narrowing_test
