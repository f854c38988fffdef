// Absurd arguments of the C++ interface: each is one clear Error, and nothing has changed.
#include <gtest/gtest.h>

#include "hostile/refused_calls.hpp"
#include <oncollide/pipeline/manifold_tracker.hpp>
#include <oncollide/pipeline/two_geometries.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/pipeline/world/world_access.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::api_test {
namespace {

using test::bad_poses, test::Calls, test::expect_refused, test::inf, test::nan;

class HostileCalls : public ::testing::Test {
protected:
    World world;
    ModelId box = world.models().add(make_box_mesh({1, 1, 1})), ball = world.models().add(Sphere{1});
    BodyId body = world.bodies().add({.model = box}), other = world.bodies().add({.model = ball});
    std::vector<PairOfBodies> pairs{{body, other}};
    std::vector<PairOfModels> models{{{box}, {ball}}};

    /// Nothing has changed: the World has the results that it would have without the calls.
    ~HostileCalls() override
    {
        EXPECT_EQ(world.bodies().size(), 2u);
        EXPECT_EQ(world.models().size(), 2u);
        EXPECT_EQ(world.bodies().pose(body).matrix(), Eigen::Matrix4d::Identity());
        EXPECT_EQ(world.step().pairs.size(), 1u);
    }
};

TEST_F(HostileCalls, PosesAndMotionsAreRigid)
{
    for (const Eigen::Isometry3d& bad : bad_poses()) {
        const std::vector<BodyId> both{body, other};
        const std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d::Identity(), bad};
        const std::vector<PlacedModel> queries{{.model = box}, {.model = box, .pose = bad}};
        const Mesh mesh = make_box_mesh({1, 1, 1});
        Lists<BodyDistance> distances;
        Lists<QueryHit> hits;
        expect_refused({
            {"add_body", [&] { world.bodies().add({.model = box, .pose = bad}); }},
            {"set_pose", [&] { world.bodies().set_pose(body, bad); }},
            {"set_poses", [&] { world.bodies().set_pose(both, poses); }},
            {"set_motion", [&] { world.bodies().set_motion(body, bad); }},
            {"set_motions", [&] { world.bodies().set_motion(both, poses); }},
            {"a motion", [&] { RigidMotion(Eigen::Isometry3d::Identity(), bad); }},
            {"decide",
             [&] {
                 world.pairs().decide(body, PlacedModel{ball, bad});
             }},
            {"distance",
             [&] {
                 world.pairs().distance(PlacedModel{ball, bad}, body);
             }},
            {"contacts",
             [&] {
                 world.pairs().contacts(PlacedModel{ball, bad}, body);
             }},
            {"penetration",
             [&] {
                 world.pairs().penetration(PlacedModel{ball, bad}, body);
             }},
            {"manifold",
             [&] {
                 world.pairs().manifold(PlacedModel{ball, bad}, body);
             }},
            {"query", [&] { world.space().overlaps(queries[1]); }},
            {"queries", [&] { world.space().overlaps(queries, {}, hits); }},
            {"distances", [&] { world.space().distances(queries[1], {}, {.cutoff = 1}); }},
            {"lists of distances", [&] { world.space().distances(queries, {}, {.cutoff = 1}, distances); }},
            {"bounds", [&] { world.models().bounds(box, bad); }},
            {"near",
             [&] {
                 WorldAccess::near(world, std::vector<PairOfModels>{{queries[0], queries[1]}}, std::vector<double>(1),
                                   *std::make_unique<std::vector<std::uint8_t>>(1));
             }},
            {"collide", [&] { collide(mesh, Eigen::Isometry3d::Identity(), mesh, bad); }},
            {"distance of meshes", [&] { distance(mesh, bad, mesh, Eigen::Isometry3d::Identity()); }},
            {"contacts of meshes", [&] { contacts(mesh, bad, mesh, Eigen::Isometry3d::Identity()); }},
            {"collide with a shape", [&] { collide(mesh, bad, Sphere{1}, Eigen::Isometry3d::Identity()); }},
            {"penetration of meshes", [&] { penetration(mesh, Eigen::Isometry3d::Identity(), mesh, bad); }},
        });
    }
}

TEST_F(HostileCalls, SpansAreOfOneLength)
{
    std::vector<Finding> no_findings, findings(2);
    std::vector<Distance> distances(3);
    std::vector<double> numbers(1), rows(16), odd(17);
    std::vector<std::uint8_t> near(1);
    std::vector<SweepResult> sweeps(4);
    std::vector<CastHit> casts(2);
    std::vector<BodyId> ids(3);
    const std::vector<PairOf<MovingModel>> ways(1, {{box, {}}, {ball, {}}});
    const std::vector<ModelId> three{box, box, box};
    expect_refused({
        {"add_bodies", [&] { world.bodies().add(std::vector<BodySpec>(2, {.model = box}), ids); }},
        {"set_poses", [&] { world.bodies().set_pose(std::vector{body}, std::vector<Eigen::Isometry3d>(2)); }},
        {"set_motions", [&] { world.bodies().set_motion(std::vector{body}, std::vector<Eigen::Isometry3d>()); }},
        {"decide bodies", [&] { world.pairs().decide(pairs, no_findings); }},
        {"decide models", [&] { world.pairs().decide(models, findings); }},
        {"columns",
         [&] {
             world.pairs().decide(PairOfColumns{{three, rows}, {three, rows}}, findings);
         }},
        {"rows",
         [&] {
             world.pairs().distance(PairOfColumns{{{&box, 1}, odd}, {{&ball, 1}, rows}}, {}, distances);
         }},
        {"no rows",
         [&] {
             world.pairs().distance(PairOfColumns{{{&box, 1}, {}}, {{&ball, 1}, rows}}, {}, distances);
         }},
        {"no models",
         [&] {
             world.pairs().distance(PairOfColumns{{{}, rows}, {{&ball, 1}, rows}}, {}, distances);
         }},
        {"distance", [&] { world.pairs().distance(pairs, {}, distances); }},
        {"near", [&] { WorldAccess::near(world, models, *std::make_unique<std::vector<double>>(2), near); }},
        {"penetration", [&] { world.pairs().penetration(pairs, *std::make_unique<std::vector<Penetration>>(2)); }},
        {"sweep", [&] { world.pairs().sweep(ways, {}, sweeps); }},
        {"clear_until", [&] { WorldAccess::clear_until(world, ways, {}, numbers); }},
        {"until", [&] { WorldAccess::clear_until(world, ways, numbers, {}); }},
        {"cast",
         [&] {
             world.space().cast(std::vector<Segment>(1, {{0, 0, 0}, {1, 0, 0}}), {}, casts);
         }},
    });
}

TEST_F(HostileCalls, IdsAreOfThisWorldAndAlive)
{
    World foreign;
    const ModelId foreign_model = foreign.models().add(Sphere{1});
    const BodyId foreign_body = foreign.bodies().add({.model = foreign_model}),
                 gone = world.bodies().add({.model = box});
    const ModelId gone_model = world.models().add(Sphere{2});
    world.bodies().remove(gone), world.models().remove(gone_model);
    BodyId far = body, future = body;
    far.slot = ~0u, ++future.generation;
    ModelId far_model = box;
    far_model.slot = ~0u;
    for (const BodyId bad : {BodyId{}, gone, foreign_body, far, future}) {
        const std::vector<BodyId> two{body, bad};
        const std::vector<PairOfBodies> of_two{{body, other}, {body, bad}};
        const std::vector<Eigen::Isometry3d> poses(2, Eigen::Isometry3d::Identity());
        std::vector<Finding> found(2);
        Lists<Contact> contacts;
        ManifoldLists manifolds;
        Lists<NearFeatures> near;
        ManifoldTracker tracker;
        ManifoldLists of_one;
        of_one.offsets = {0, 1}, of_one.regions.resize(1), of_one.points.resize(1);
        of_one.regions[0].first = 0, of_one.regions[0].count = 1;
        expect_refused({
            {"remove", [&] { world.bodies().remove(two); }},
            {"twice",
             [&] {
                 world.bodies().remove(std::vector{body, body});
             }},
            {"set_poses", [&] { world.bodies().set_pose(two, poses); }},
            {"set_motions", [&] { world.bodies().set_motion(two, poses); }},
            {"motion", [&] { world.bodies().set_motion(bad, RigidMotion()); }},
            {"sleep", [&] { world.bodies().sleep(two); }},
            {"wake", [&] { world.bodies().wake(two); }},
            {"static", [&] { world.bodies().set_static(bad, true); }},
            {"filter", [&] { world.bodies().filter(bad); }},
            {"filters", [&] { world.bodies().set_filter(two, {.layer = 2}); }},
            {"models", [&] { world.bodies().set_model(two, ball); }},
            {"statics", [&] { world.bodies().set_static(two, true); }},
            {"model", [&] { world.bodies().set_model(bad, box); }},
            {"user", [&] { world.bodies().set_user(bad, 1); }},
            {"exclude", [&] { world.bodies().exclude(body, bad); }},
            {"itself", [&] { world.bodies().exclude(body, body); }},
            {"include", [&] { world.bodies().include(bad, body); }},
            {"excluded", [&] { static_cast<void>(world.bodies().excluded(bad, body)); }},
            {"pose", [&] { world.bodies().pose(bad); }},
            {"max_error", [&] { world.pairs().max_error(body, bad); }},
            {"decide", [&] { world.pairs().decide(of_two, found); }},
            {"contacts", [&] { world.pairs().contacts(of_two, contacts); }},
            {"manifolds", [&] { world.pairs().manifold(of_two, {}, manifolds); }},
            {"near_features", [&] { world.pairs().near_features(of_two, 0, near); }},
            {"tracker",
             [&] {
                 tracker.update(world, std::vector<PairOfBodies>{{body, bad}}, of_one);
             }},
        });
    }
    for (const ModelId bad : {ModelId{}, gone_model, foreign_model, far_model})
        expect_refused({
            {"add_body", [&] { world.bodies().add({.model = bad}); }},
            {"set_model", [&] { world.bodies().set_model(body, bad); }},
            {"replace", [&] { world.models().replace(bad, Shape(Sphere{1})); }},
            {"remove", [&] { world.models().remove(bad); }},
            {"closed", [&] { static_cast<void>(world.models().closed(bad)); }},
            {"bounds", [&] { world.models().bounds(bad, Eigen::Isometry3d::Identity()); }},
            {"bounds of a motion", [&] { world.models().bounds(bad, RigidMotion()); }},
            {"geometry", [&] { world.models().geometry(bad); }},
            {"cells", [&] { world.models().edit(bad, [](OccupancyMap&) { FAIL(); }); }},
            {"sweep",
             [&] {
                 world.pairs().sweep({bad, {}}, {box, {}});
             }},
            {"cast",
             [&] {
                 world.space().cast(MovingModel{bad, {}});
             }},
            {"cast_all",
             [&] {
                 world.space().cast_all(MovingModel{bad, {}});
             }},
            {"query", [&] { world.space().overlaps(PlacedModel{bad}); }},
        });
    EXPECT_FALSE(world.bodies().is_asleep(body)) << "a list with a bad id changes none of its bodies";
    EXPECT_FALSE(world.bodies().at(~0u));
    EXPECT_FALSE(world.models().at(~0u));
}

TEST_F(HostileCalls, NumbersAreFiniteAndInRange)
{
    const Aabb unordered{{1, 0, 0}, {0, 1, 1}}, no_number{{0, nan, 0}, {1, 1, 1}}, endless{{0, 0, 0}, {1, inf, 1}};
    std::vector<double> until(1);
    std::vector<std::uint8_t> near(1);
    const std::vector<PairOf<MovingModel>> ways(1, {{box, {}}, {ball, {}}});
    Lists<NearFeatures> features;
    Calls calls{
        {"box", [&] { world.space().overlaps(unordered); }},
        {"box of nan", [&] { world.space().overlaps(no_number); }},
        {"endless box", [&] { world.space().overlaps(endless); }},
        {"no length",
         [&] {
             world.space().cast(Segment{{1, 1, 1}, {1, 1, 1}});
         }},
        {"all bodies", [&] { world.space().distances({.model = box}, {}, {}); }},
        {"more bodies than ids", [&] { world.bodies().reserve(~std::size_t{0}); }},
        {"no steps",
         [&] {
             world.pairs().sweep({box, {}}, {ball, {}}, {.most_steps = 0});
         }},
        {"no points", [&] { world.pairs().manifold(body, other, {.points_per_region = 0}); }},
        {"no regions", [&] { world.pairs().manifold(body, other, {.regions_per_pair = 0}); }},
        {"offsets",
         [&] {
             ManifoldTracker().update(world, pairs, {.regions = {}, .points = {}, .offsets = {0, 4}, .complete = {}});
         }},
        {"no offsets", [&] { ManifoldTracker().update(world, {}, {}); }},
        {"points",
         [&] {
             ManifoldLists lists;
             lists.offsets = {0, 1}, lists.regions.resize(1);
             lists.regions[0].first = 3, lists.regions[0].count = ~0u;
             ManifoldTracker().update(world, pairs, lists);
         }},
    };
    for (const double bad : {nan, -1.0, -inf}) {
        const std::string name = std::to_string(bad);
        const std::vector<double> bads{bad};
        calls["tolerance " + name] = [&, bad] { world.pairs().distance(body, other, {.tolerance = bad}); };
        calls["cutoff " + name] = [&, bad] { world.pairs().distance(body, other, {.cutoff = bad}); };
        calls["cutoff of all " + name] = [&, bad] { world.space().distances({.model = box}, {}, {.cutoff = bad}); };
        calls["reach " + name] = [&, bads] { WorldAccess::near(world, models, bads, near); };
        calls["margin " + name] = [&, bads] { WorldAccess::clear_until(world, ways, bads, until); };
        calls["margin of manifold " + name] = [&, bad] { world.pairs().manifold(body, other, {.margin = bad}); };
        calls["spread " + name] = [&, bad] { world.pairs().manifold(body, other, {.normal_spread = bad}); };
        calls["dhat " + name] = [&, bad] { world.pairs().near_features(pairs, bad, features); };
        calls["time " + name] = [&, bad] { world.pairs().sweep({box, {}}, {ball, {}}, {.time_tolerance = bad}); };
        calls["gap " + name] = [&, bad] { world.space().cast(MovingModel{box, {}}, {}, {.gap_tolerance = bad}); };
        calls["options " + name] = [&, bad] { world.set_sweep_options({.gap_tolerance = bad}); };
        calls["tracker " + name] = [bad] { ManifoldTracker tracker(bad); };
        calls["clearance " + name] = [bad] { World made({.clearance = bad}); };
        calls["max_error " + name] = [bad] { World made({.max_error = bad}); };
        calls["mesh tolerance " + name] = [bad] {
            const Mesh mesh = make_box_mesh({1, 1, 1});
            distance(mesh, Eigen::Isometry3d::Identity(), mesh, Eigen::Isometry3d::Identity(), {.tolerance = bad});
        };
    }
    for (const double bad : {nan, inf, 1e300}) {
        const std::string name = std::to_string(bad);
        const Segment segment{{0, 0, 0}, {0, bad, 0}};
        calls["segment " + name] = [&, segment] { world.space().overlaps(segment); };
        calls["cast " + name] = [&, segment] { world.space().cast(segment); };
        calls["cast_all " + name] = [&, segment] { world.space().cast_all(segment); };
        calls["radius " + name] = [&, bad] { world.models().add(Sphere{bad}); };
        calls["vertex " + name] = [&, bad] {
            Mesh mesh = make_box_mesh({1, 1, 1});
            mesh.vertices[3].z() = bad;
            world.models().replace(box, mesh);
        };
    }
    expect_refused(calls);
}

/// Geometries that no make_...() has seen.
TEST_F(HostileCalls, GeometriesAreChecked)
{
    const auto made = [](GeometryData data) {
        return std::make_shared<const Geometry>(Geometry{"g", std::move(data), {}});
    };
    Mesh index = make_box_mesh({1, 1, 1}), bounds = index;
    index.triangles[5][2] = 1000, bounds.bounds.max.x() = 0;
    const std::vector<std::shared_ptr<const Geometry>> bad{nullptr,
                                                           made(Mesh{}),
                                                           made(index),
                                                           made(bounds),
                                                           made(Shape(Sphere{-1})),
                                                           made(Shape(Box{{1, nan, 1}})),
                                                           made(Shape(ConvexHull{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}})),
                                                           made(std::shared_ptr<const CookedMesh>())};
    for (std::size_t i = 0; i < bad.size(); ++i)
        expect_refused({
            {"add " + std::to_string(i), [&] { world.models().add(bad[i]); }},
            {"replace " + std::to_string(i), [&] { world.models().replace(box, bad[i]); }},
            {"collide " + std::to_string(i),
             [&] { collide(bad[i], Eigen::Isometry3d::Identity(), Sphere{1}, Eigen::Isometry3d::Identity()); }},
        });
    expect_refused({{"cooked", [&] { world.models().add(std::shared_ptr<const CookedMesh>()); }}});
}

} // namespace
} // namespace oncollide::api_test
