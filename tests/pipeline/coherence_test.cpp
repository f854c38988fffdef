// Pairs that stay separate because of an earlier frame's gap: the same results with coherence, without it, and in a new
// World, for any motion.
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/pipeline/settings_rules.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

#include "every_kind.hpp"
#include "random_pose.hpp"

namespace oncollide {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A crowd of every kind, in worlds of several settings at once.
class Crowd {
public:
    Crowd(std::uint64_t seed, std::initializer_list<Settings> settings) : random_(seed)
    {
        for (const Settings& s : settings) worlds_.push_back(std::make_unique<World>(s));
        for (std::uint64_t k = 0; k < 2 * kinds; ++k) {
            const auto geometry = std::make_shared<const Geometry>(
                Geometry{std::string(every_kind[k % kinds]) + (k < kinds ? "" : " again"),
                         draw_geometry(k % kinds, seed + k),
                         {}});
            geometries_.push_back(geometry);
            for (auto& world : worlds_) world->models().add(geometry);
        }
        for (std::size_t i = 0; i < 36; ++i) bodies_.push_back(drawn(i));
        for (std::size_t i = 0; i < bodies_.size(); ++i) add(i);
    }

    /// Most bodies move a little, some rest, and a few change in other ways.
    /// @param rest  the share of the bodies at rest
    void change(double rest = 0.2)
    {
        for (std::size_t i = 0; i < bodies_.size(); ++i) {
            Body& body = bodies_[i];
            if (u() < rest) continue;
            const std::size_t what = 12 + below(48);
            if (what < 52) {
                const double scale = std::pow(10, -2.0 - double(below(4)));
                const Isometry3d by = random_pose(random_(), scale);
                const Eigen::AngleAxisd turn(below(3) ? scale * (u() - 0.5) : 0,
                                             Vector3d(u() - 0.5, u() - 0.5, u() - 0.5).normalized());
                Isometry3d pose = body.pose;
                pose.linear() = Eigen::Quaterniond(turn * pose.linear()).normalized().toRotationMatrix();
                if (below(8) == 0) pose.linear() *= 1 + 4e-7 * (u() - 0.5); // at the limit of rigidity
                pose.translation() += by.translation();
                body.pose = pose;
                for (auto& world : worlds_) world->bodies().set_pose(world->bodies().at(body.slot), pose);
            } else if (what < 54) {
                body.pose = drawn(i).pose;
                for (auto& world : worlds_) world->bodies().set_pose(world->bodies().at(body.slot), body.pose);
            } else if (what < 55) {
                body.model = static_cast<std::uint32_t>(below(models_));
                for (auto& world : worlds_)
                    world->bodies().set_model(world->bodies().at(body.slot), world->models().at(body.model));
            } else if (what < 56) {
                body.mask = below(2) ? ~0u : 2;
                for (auto& world : worlds_)
                    world->bodies().set_filter(world->bodies().at(body.slot), {.mask = body.mask});
            } else if (what < 58) {
                for (auto& world : worlds_) world->bodies().remove(world->bodies().at(body.slot));
                body = drawn(i + 1000 * below(100));
                add(i);
            } else if (what < 59) {
                const Vector3d place(u(), u(), u());
                const CellState state = below(2) ? CellState::occupied : CellState::free;
                for (std::uint32_t m = 0; m < models_; ++m)
                    if (std::holds_alternative<OccupancyMap>(geometries_[m]->data))
                        for (auto& world : worlds_)
                            world->models().edit(world->models().at(m), [&](OccupancyMap& map) {
                                map.set({&place, 1}, state);
                            });
            } else {
                Body& other = bodies_[below(bodies_.size())];
                if (&other == &body) continue;
                for (auto& world : worlds_) {
                    const BodyId a = world->bodies().at(body.slot), b = world->bodies().at(other.slot);
                    world->bodies().excluded(a, b) ? world->bodies().include(a, b) : world->bodies().exclude(a, b);
                }
            }
        }
    }

    /// Queries each World.
    void look()
    {
        const Vector3d place = bodies_[0].pose.translation();
        for (auto& world : worlds_) world->space().overlaps(Aabb{place, place});
    }

    World& world(std::size_t i) { return *worlds_[i]; }
    /// A World with the same bodies and no history.
    World fresh(Settings settings)
    {
        World world(settings);
        for (std::uint32_t m = 0; m < models_; ++m) {
            const Geometry& geometry = *geometries_[m];
            std::holds_alternative<OccupancyMap>(geometry.data)
                ? world.models().add(worlds_[0]->models().geometry(worlds_[0]->models().at(m)).data)
                : world.models().add(geometries_[m]);
        }
        for (std::size_t i = 0; i < bodies_.size(); ++i) world.bodies().add(spec(world, i));
        for (std::uint32_t i = 0; i < bodies_.size(); ++i)
            for (std::uint32_t j = 0; j < i; ++j)
                if (worlds_[0]->bodies().excluded(worlds_[0]->bodies().at(bodies_[i].slot),
                                                  worlds_[0]->bodies().at(bodies_[j].slot)))
                    world.bodies().exclude(world.bodies().at(i), world.bodies().at(j));
        return world;
    }

private:
    struct Body {
        std::uint32_t model;
        Isometry3d pose;
        std::uint32_t mask = ~0u;
        std::uint32_t slot = 0; ///< the same in all Worlds
    };
    double u() { return std::uniform_real_distribution<>()(random_); }
    std::size_t below(std::size_t n) { return random_() % n; }
    Body drawn(std::size_t i)
    {
        const auto model = static_cast<std::uint32_t>(below(3) ? kinds * below(2) : below(models_));
        return {model, random_pose(31 * i + random_(), 2.2)};
    }
    BodySpec spec(const World& world, std::size_t i) const
    {
        const Body& body = bodies_[i];
        return {.model = world.models().at(body.model), .pose = body.pose, .layer = 1, .mask = body.mask, .user = i};
    }
    void add(std::size_t i)
    {
        for (auto& world : worlds_) bodies_[i].slot = world->bodies().add(spec(*world, i)).slot;
    }

    std::mt19937_64 random_;
    std::vector<std::unique_ptr<World>> worlds_;
    std::vector<std::shared_ptr<const Geometry>> geometries_;
    static constexpr std::uint32_t models_ = 2 * kinds;
    std::vector<Body> bodies_;
};

using Users = std::pair<std::uint64_t, std::uint64_t>;

std::map<Users, PairResult> by_users(const World& world, const FrameView& frame)
{
    std::map<Users, PairResult> results;
    for (const PairResult& r : frame.pairs)
        results[std::minmax(world.bodies().user(r.a), world.bodies().user(r.b))] = r;
    return results;
}

class Coherence : public testing::TestWithParam<int> {
protected:
    static Settings settings(int number)
    {
        Settings s;
        switch (number) {
        case 0:
            break;
        case 1:
            s.exact = ExactLevel::predicates;
            break;
        case 2:
            s.exact = ExactLevel::predicates, s.clearance = 0.02;
            break;
        case 3:
            s.exact = ExactLevel::predicates, s.contact_kinds = true;
            break;
        case 4:
            s.clearance = 0.01, s.max_error = 0.002;
            break;
        case 5:
            s.exact = ExactLevel::fcl;
            break;
        case 6:
            s.mode = Mode::solid, s.open_as_surface = true, s.exact = ExactLevel::predicates;
            break;
        default:
            s.bounding_volume = BoundingVolume::sphere, s.depth = 4;
        }
        return s;
    }
};

/// As the events of a World state them: pairs that began and ended, by the bodies' slots.
void follow_events(std::set<BodyPair>& pairs, const FrameView& frame)
{
    for (const PairOfBodies& pair : frame.ended)
        EXPECT_EQ(pairs.erase({index(pair.a), index(pair.b)}), 1u) << "frame " << frame.frame;
    for (const PairOfBodies& pair : frame.began)
        EXPECT_TRUE(pairs.insert({index(pair.a), index(pair.b)}).second) << "frame " << frame.frame;
}

/// The same pairs with the same results, bounds of separate pairs included.
void expect_same_results(const FrameView& view, const FrameView& expected, const std::string& when)
{
    ASSERT_EQ(view.hash, expected.hash) << when;
    ASSERT_EQ(view.pairs.size(), expected.pairs.size()) << when;
    for (std::size_t i = 0; i < view.pairs.size(); ++i) {
        const PairResult &r = view.pairs[i], &e = expected.pairs[i];
        ASSERT_TRUE(index(r.a) == index(e.a) && index(r.b) == index(e.b) && r.verdict == e.verdict &&
                    r.stage == e.stage && r.kind == e.kind && r.bound == e.bound)
            << when << " pair " << i << ": " << int(r.verdict) << " at " << r.bound << ", " << int(e.verdict) << " at "
            << e.bound;
    }
}

TEST_P(Coherence, KeepsTheResultsOfPairsAtRestAsANewWorldWouldFindThem)
{
    const Settings on = settings(GetParam());
    Settings off = on;
    off.coherence = false;
    std::uint64_t kept = 0, pairs = 0, repeated = 0;
    for (std::uint64_t seed = 11; seed < 14; ++seed) {
        Crowd crowd(seed, {on, off});
        std::set<BodyPair> present, expected_present;
        for (int frame = 0; frame < 40; ++frame) {
            if (frame) crowd.change(frame % 3 ? 0.97 : 1); // now and then all bodies rest
            if (frame % 2) crowd.look();                   // takes the changes in before the step
            const FrameView view = crowd.world(0).step(), expected = crowd.world(1).step();
            const std::string when = "seed " + std::to_string(seed) + " frame " + std::to_string(frame);
            ASSERT_NO_FATAL_FAILURE(expect_same_results(view, expected, when));
            for (std::size_t stage = 0; stage < view.stages.size(); ++stage)
                if (view.stages[stage].stage == "refine" || view.stages[stage].stage == "exact") {
                    EXPECT_EQ(view.stages[stage].in, expected.stages[stage].in) << view.stages[stage].stage;
                    EXPECT_EQ(view.stages[stage].out, expected.stages[stage].out) << view.stages[stage].stage;
                }
            follow_events(present, view), follow_events(expected_present, expected);
            ASSERT_EQ(present, expected_present);
            EXPECT_EQ(expected.trees.kept, 0u);
            kept += view.trees.kept, pairs += view.pairs.size();
            repeated += view.trees.kept == view.pairs.size();
            if (frame % 8) continue;
            World fresh = crowd.fresh(on);
            std::map<Users, PairResult> again = by_users(fresh, fresh.step());
            ASSERT_EQ(again.size(), view.pairs.size());
            for (const auto& [users, r] : by_users(crowd.world(0), view)) {
                ASSERT_EQ(again.at(users).verdict, r.verdict) << "seed " << seed << " frame " << frame;
                if (r.verdict == Verdict::separate) continue;
                ASSERT_EQ(again.at(users).bound, r.bound);
            }
        }
    }
    EXPECT_GT(kept, 4 * pairs / 5) << pairs;
    EXPECT_GT(repeated, 20u);
}

TEST_P(Coherence, ChangesNoVerdictAndNoBoundAndKeepsPairsApartThatAre)
{
    Settings on = settings(GetParam()), off = on, threads = on, none = on;
    off.coherence = false, threads.threads = 3;
    none.exact = ExactLevel::off, none.mode = Mode::surface;
    std::uint64_t by_gap = 0, by_hull = 0, by_inner_spheres = 0, by_witness = 0, same = 0, bounds = 0;
    for (std::uint64_t seed = 1; seed < 4; ++seed) {
        Crowd crowd(seed, {on, off, threads});
        for (int frame = 0; frame < 40; ++frame) {
            if (frame) crowd.change();
            const FrameView expected = crowd.world(0).step();
            by_gap += expected.trees.by_gap, by_hull += expected.trees.by_hull;
            by_inner_spheres += expected.trees.by_inner_spheres, by_witness += expected.trees.by_witness;
            for (const std::size_t other : {1u, 2u}) {
                const FrameView view = crowd.world(other).step();
                const std::string when = "seed " + std::to_string(seed) + " frame " + std::to_string(frame);
                ASSERT_NO_FATAL_FAILURE(expect_same_results(view, expected, when));
            }
            if (frame % 4) continue;
            // A new World has the same results, and the bounds on distances hold up to the distortion by poses that are
            // not quite rigid.
            World fresh = crowd.fresh(on);
            const auto results = by_users(crowd.world(0), expected);
            std::map<Users, PairResult> again = by_users(fresh, fresh.step());
            ASSERT_EQ(again.size(), results.size());
            for (const auto& [users, r] : results) {
                const PairResult& now = again.at(users);
                ASSERT_EQ(now.verdict, r.verdict) << "seed " << seed << " frame " << frame;
                ++same;
                if (r.verdict != Verdict::separate || r.bound == 0 || on.mode == Mode::solid) continue;
                EXPECT_LE(r.bound, fresh.pairs().distance(now.a, now.b, {.tolerance = 1e-3}).upper + 2e-6)
                    << "seed " << seed << " frame " << frame;
                ++bounds;
            }
        }
    }
    EXPECT_GT(same, 1000u);
    if (on.bounding_volume == BoundingVolume::sphere) return;
    EXPECT_GT(bounds + (on.mode == Mode::solid ? 1000 : 0), 100u);
    EXPECT_GT(by_gap, 1000u);
    EXPECT_GT(by_hull, 10u) << by_gap;
    if (!wants_kinds(on)) {
        EXPECT_GT(by_inner_spheres, 10u);
    }
    EXPECT_GT(by_witness, 1000u);
}

INSTANTIATE_TEST_SUITE_P(EverySetting, Coherence, testing::Range(0, 8));

TEST(CoherenceOfAPair, EndsWhereTheBodiesCanHaveMet)
{
    World world({.exact = ExactLevel::predicates});
    const ModelId model = world.models().add(make_sphere_mesh(0.5, 500));
    Isometry3d still = Isometry3d::Identity(), other = still;
    other.translation() = Vector3d(0.8, 0.8, 0); // their boxes overlap
    const BodyId a = world.bodies().add({.model = model, .pose = still});
    const BodyId b = world.bodies().add({.model = model, .pose = other});
    const auto step = [&] {
        const FrameView view = world.step();
        EXPECT_EQ(view.pairs.size(), 1u);
        return std::pair(view.pairs[0], view.trees.by_gap + view.trees.kept == 1);
    };
    const auto [first, kept_first] = step();
    ASSERT_EQ(first.verdict, Verdict::separate);
    const double gap = first.bound;
    ASSERT_GT(gap, 0.01);
    EXPECT_FALSE(kept_first);

    other.translation().x() -= 0.25 * gap;
    world.bodies().set_pose(b, other);
    const auto [second, kept] = step();
    EXPECT_TRUE(kept);
    EXPECT_NEAR(second.bound, 0.75 * gap, 1e-5 * gap);
    EXPECT_LE(second.bound, 0.75 * gap);
    EXPECT_TRUE(step().second) << "at rest";

    still.translation().y() -= 0.25 * gap;
    world.bodies().set_pose(a, still);
    EXPECT_TRUE(step().second);
    for (const double x : {0.3, -0.3}) { // there and back in one frame: the motion counts
        other.translation().x() += x * gap;
        world.bodies().set_pose(b, other);
    }
    const auto [walked, kept_no_more] = step();
    EXPECT_FALSE(kept_no_more);
    EXPECT_GT(walked.bound, 0.01) << "looked up anew";
    EXPECT_TRUE(step().second);
    world.models().replace(model, make_sphere_mesh(0.5, 400));
    EXPECT_FALSE(step().second) << "another geometry";
    EXPECT_TRUE(step().second);
    world.bodies().exclude(a, b);
    EXPECT_TRUE(world.step().pairs.empty());
    world.bodies().include(a, b);
    EXPECT_FALSE(step().second) << "no candidates meanwhile";
    other.translation() = Vector3d(0.1, 0.1, 0);
    world.bodies().set_pose(b, other);
    EXPECT_EQ(step().first.verdict, Verdict::colliding);
}

} // namespace
} // namespace oncollide
