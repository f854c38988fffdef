// Absurd arguments of the C++ interface: each is one clear Error, and nothing has changed.
#include <gtest/gtest.h>

#include "hostile/refused_calls.hpp"
#include <oncollide/pipeline/mesh_queries.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::api_test {
namespace {

using test::bad_poses, test::Calls, test::expect_refused, test::inf, test::nan;

class HostileCalls : public ::testing::Test {
protected:
    World world;
    ModelId box = world.add(make_box_mesh({1, 1, 1})), ball = world.add(Sphere{1});
    BodyId body = world.add_body({.model = box}), other = world.add_body({.model = ball});
    std::vector<PairOfBodies> pairs{{body, other}};
    std::vector<PairOfModels> models{{{box}, {ball}}};

    /// Nothing has changed: the World has the results that it would have without the calls.
    ~HostileCalls() override
    {
        EXPECT_EQ(world.size(), 2u);
        EXPECT_EQ(world.models(), 2u);
        EXPECT_EQ(world.pose(body).matrix(), Eigen::Matrix4d::Identity());
        EXPECT_EQ(world.step().pairs.size(), 1u);
    }
};

TEST_F(HostileCalls, PosesAndMotionsAreRigid)
{
    for (const Eigen::Isometry3d& bad : bad_poses()) {
        const std::vector<BodyId> both{body, other};
        const std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d::Identity(), bad};
        const std::vector<ModelQuery> queries{{.model = box}, {.model = box, .pose = bad}};
        std::vector<double> zeros(2);
        const Mesh mesh = make_box_mesh({1, 1, 1});
        MeshQueries mesh_queries(std::vector{mesh});
        const std::vector<MeshQuery> one{{0, 0, Eigen::Isometry3d::Identity(), bad}};
        QueryHits hits;
        expect_refused({
            {"add_body", [&] { world.add_body({.model = box, .pose = bad}); }},
            {"set_pose", [&] { world.set_pose(body, bad); }},
            {"set_poses", [&] { world.set_poses(both, poses); }},
            {"set_motion", [&] { world.set_motion(body, bad); }},
            {"set_motions", [&] { world.set_motions(both, poses); }},
            {"a motion", [&] { RigidMotion(Eigen::Isometry3d::Identity(), bad); }},
            {"decide",
             [&] {
                 world.decide(body, PlacedModel{ball, bad});
             }},
            {"distance",
             [&] {
                 world.distance(PlacedModel{ball, bad}, body);
             }},
            {"contacts",
             [&] {
                 world.contacts(PlacedModel{ball, bad}, body);
             }},
            {"penetration",
             [&] {
                 world.penetration(PlacedModel{ball, bad}, body);
             }},
            {"manifold",
             [&] {
                 world.manifold(PlacedModel{ball, bad}, body);
             }},
            {"query", [&] { world.query(box, bad); }},
            {"queries", [&] { world.query(queries, hits); }},
            {"near", [&] { world.near(queries, zeros, hits); }},
            {"distances", [&] { world.distances(queries[1], 1); }},
            {"bounds", [&] { world.bounds(box, bad); }},
            {"mesh queries", [&] { mesh_queries.run(one, *std::make_unique<std::vector<Finding>>(1)); }},
            {"collide", [&] { collide(mesh, Eigen::Isometry3d::Identity(), mesh, bad); }},
            {"distance of meshes", [&] { distance(mesh, bad, mesh, Eigen::Isometry3d::Identity()); }},
            {"contacts of meshes", [&] { contacts(mesh, bad, mesh, Eigen::Isometry3d::Identity()); }},
        });
    }
}

TEST_F(HostileCalls, SpansAreOfOneLength)
{
    std::vector<Finding> no_findings, findings(2);
    std::vector<Distance> distances(3);
    std::vector<Verdict> verdicts(2);
    std::vector<double> numbers(1), rows(16), odd(17);
    std::vector<std::uint8_t> near(1);
    std::vector<SweepResult> sweeps(4);
    std::vector<CastHit> casts(2);
    std::vector<BodyId> ids(3);
    const std::vector<PairOfMovingModels> ways(1, {{box, {}}, {ball, {}}});
    const std::vector<ModelId> three{box, box, box};
    QueryHits hits;
    MeshQueries queries(std::vector{make_box_mesh({1, 1, 1})});
    const std::vector<MeshQuery> query{{0, 0, Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()}};
    const std::vector<std::uint32_t> first{0}, absent{7}, many{0, 0, 0};
    expect_refused({
        {"add_bodies", [&] { world.add_bodies(std::vector<BodySpec>(2, {.model = box}), ids); }},
        {"set_poses", [&] { world.set_poses(std::vector{body}, std::vector<Eigen::Isometry3d>(2)); }},
        {"set_motions", [&] { world.set_motions(std::vector{body}, std::vector<Eigen::Isometry3d>()); }},
        {"decide bodies", [&] { world.decide(pairs, no_findings); }},
        {"decide models", [&] { world.decide(models, findings); }},
        {"verdicts and bounds",
         [&] {
             world.decide({three, three, rows, rows}, verdicts, numbers);
         }},
        {"columns",
         [&] {
             world.decide({three, three, rows, rows}, verdicts, *std::make_unique<std::vector<double>>(2));
         }},
        {"rows",
         [&] {
             world.distances({{&box, 1}, {&ball, 1}, odd, rows}, distances);
         }},
        {"no rows",
         [&] {
             world.distances({{&box, 1}, {&ball, 1}, {}, rows}, distances);
         }},
        {"no models",
         [&] {
             world.distances({{}, {&ball, 1}, rows, rows}, distances);
         }},
        {"distances", [&] { world.distances(pairs, distances); }},
        {"near", [&] { world.near(models, *std::make_unique<std::vector<double>>(2), near); }},
        {"near bodies", [&] { world.near(std::vector<ModelQuery>(1, {.model = box}), {}, hits); }},
        {"penetration", [&] { world.penetration(pairs, *std::make_unique<std::vector<Penetration>>(2)); }},
        {"sweep", [&] { world.sweep(ways, sweeps); }},
        {"clear_until", [&] { world.clear_until(ways, {}, numbers); }},
        {"until", [&] { world.clear_until(ways, numbers, {}); }},
        {"cast",
         [&] {
             world.cast(std::vector<Segment>(1, {{0, 0, 0}, {1, 0, 0}}), {}, casts);
         }},
        {"mesh queries", [&] { queries.run(query, findings); }},
        {"no such mesh",
         [&] {
             queries.run(std::vector<MeshQuery>{{0, 1, query[0].pose_a, query[0].pose_b}}, {findings.data(), 1});
         }},
        {"no such column",
         [&] {
             queries.run({first, absent, rows, rows}, {verdicts.data(), 1}, numbers);
         }},
        {"column of meshes",
         [&] {
             queries.run({first, many, rows, rows}, {verdicts.data(), 1}, numbers);
         }},
        {"distances of meshes", [&] { queries.distances(query, 0, distances); }},
    });
}

TEST_F(HostileCalls, IdsAreOfThisWorldAndAlive)
{
    World foreign;
    const ModelId foreign_model = foreign.add(Sphere{1});
    const BodyId foreign_body = foreign.add_body({.model = foreign_model}), gone = world.add_body({.model = box});
    const ModelId gone_model = world.add(Sphere{2});
    world.remove_body(gone), world.remove(gone_model);
    BodyId far = body, future = body;
    far.slot = ~0u, ++future.generation;
    ModelId far_model = box;
    far_model.slot = ~0u;
    for (const BodyId bad : {BodyId{}, gone, foreign_body, far, future}) {
        const std::vector<BodyId> two{body, bad};
        const std::vector<PairOfBodies> of_two{{body, other}, {body, bad}};
        const std::vector<Eigen::Isometry3d> poses(2, Eigen::Isometry3d::Identity());
        std::vector<Finding> found(2);
        ContactLists contacts;
        ManifoldLists manifolds;
        NearFeatureLists near;
        ManifoldTracker tracker;
        ManifoldLists of_one;
        of_one.offsets = {0, 1}, of_one.regions.resize(1), of_one.points.resize(1);
        of_one.regions[0].first = 0, of_one.regions[0].count = 1;
        expect_refused({
            {"remove", [&] { world.remove_bodies(two); }},
            {"twice",
             [&] {
                 world.remove_bodies(std::vector{body, body});
             }},
            {"set_poses", [&] { world.set_poses(two, poses); }},
            {"set_motions", [&] { world.set_motions(two, poses); }},
            {"motion", [&] { world.set_motion(bad, RigidMotion()); }},
            {"sleep", [&] { world.sleep(two); }},
            {"wake", [&] { world.wake(two); }},
            {"static", [&] { world.set_static(bad, true); }},
            {"layers", [&] { world.set_layers(bad, 1, 1); }},
            {"group", [&] { world.set_group(bad, 1); }},
            {"model", [&] { world.set_model(bad, box); }},
            {"user", [&] { world.set_user(bad, 1); }},
            {"exclude", [&] { world.exclude(body, bad); }},
            {"itself", [&] { world.exclude(body, body); }},
            {"include", [&] { world.include(bad, body); }},
            {"excluded", [&] { static_cast<void>(world.excluded(bad, body)); }},
            {"pose", [&] { world.pose(bad); }},
            {"max_error", [&] { world.max_error(body, bad); }},
            {"decide", [&] { world.decide(of_two, found); }},
            {"contacts", [&] { world.contacts(of_two, contacts); }},
            {"manifolds", [&] { world.manifolds(of_two, {}, manifolds); }},
            {"near_features", [&] { world.near_features(of_two, 0, near); }},
            {"tracker",
             [&] {
                 tracker.update(world, std::vector<PairOfBodies>{{body, bad}}, of_one);
             }},
        });
    }
    for (const ModelId bad : {ModelId{}, gone_model, foreign_model, far_model})
        expect_refused({
            {"add_body", [&] { world.add_body({.model = bad}); }},
            {"set_model", [&] { world.set_model(body, bad); }},
            {"replace", [&] { world.replace(bad, Shape(Sphere{1})); }},
            {"remove", [&] { world.remove(bad); }},
            {"closed", [&] { static_cast<void>(world.closed(bad)); }},
            {"bounds", [&] { world.bounds(bad, Eigen::Isometry3d::Identity()); }},
            {"bounds of a motion", [&] { world.bounds(bad, RigidMotion()); }},
            {"map", [&] { world.map(bad); }},
            {"cells",
             [&] {
                 world.set_cells(bad, Aabb{{0, 0, 0}, {1, 1, 1}}, CellState::free);
             }},
            {"sweep",
             [&] {
                 world.sweep({bad, {}}, {box, {}});
             }},
            {"cast",
             [&] {
                 world.cast(MovingModel{bad, {}});
             }},
            {"cast_all",
             [&] {
                 world.cast_all(MovingModel{bad, {}});
             }},
            {"query", [&] { world.query(bad, Eigen::Isometry3d::Identity()); }},
        });
    EXPECT_FALSE(world.is_asleep(body)) << "a list with a bad id changes none of its bodies";
    EXPECT_FALSE(world.body_at(~0u));
    EXPECT_FALSE(world.model_at(~0u));
}

TEST_F(HostileCalls, NumbersAreFiniteAndInRange)
{
    const Aabb unordered{{1, 0, 0}, {0, 1, 1}}, no_number{{0, nan, 0}, {1, 1, 1}}, endless{{0, 0, 0}, {1, inf, 1}};
    std::vector<double> until(1);
    std::vector<std::uint8_t> near(1);
    const std::vector<PairOfMovingModels> ways(1, {{box, {}}, {ball, {}}});
    NearFeatureLists features;
    Calls calls{
        {"box", [&] { world.query(unordered); }},
        {"box of nan", [&] { world.query(no_number); }},
        {"endless box", [&] { world.query(endless); }},
        {"no length",
         [&] {
             world.cast(Segment{{1, 1, 1}, {1, 1, 1}});
         }},
        {"all bodies", [&] { world.distances(ModelQuery{.model = box}, inf); }},
        {"more bodies than ids", [&] { world.reserve_bodies(~std::size_t{0}); }},
        {"no steps",
         [&] {
             world.sweep({box, {}}, {ball, {}}, {.most_steps = 0});
         }},
        {"no points", [&] { world.manifold(body, other, {.points_per_region = 0}); }},
        {"no regions", [&] { world.manifold(body, other, {.regions_per_pair = 0}); }},
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
        calls["tolerance " + name] = [&, bad] { world.distance(body, other, bad); };
        calls["cutoff " + name] = [&, bad] { world.distance(body, other, 0, bad); };
        calls["cutoff of all " + name] = [&, bad] { world.distances(ModelQuery{.model = box}, bad); };
        calls["reach " + name] = [&, bads] { world.near(models, bads, near); };
        calls["margin " + name] = [&, bads] { world.clear_until(ways, bads, until); };
        calls["margin of manifold " + name] = [&, bad] { world.manifold(body, other, {.margin = bad}); };
        calls["spread " + name] = [&, bad] { world.manifold(body, other, {.normal_spread = bad}); };
        calls["dhat " + name] = [&, bad] { world.near_features(pairs, bad, features); };
        calls["time " + name] = [&, bad] { world.sweep({box, {}}, {ball, {}}, {.time_tolerance = bad}); };
        calls["gap " + name] = [&, bad] { world.cast(MovingModel{box, {}}, {}, {.gap_tolerance = bad}); };
        calls["options " + name] = [&, bad] { world.set_sweep_options({.gap_tolerance = bad}); };
        calls["tracker " + name] = [bad] { ManifoldTracker tracker(bad); };
        calls["clearance " + name] = [bad] { World made({.clearance = bad}); };
        calls["max_error " + name] = [bad] { World made({.max_error = bad}); };
        calls["mesh tolerance " + name] = [bad] {
            const Mesh mesh = make_box_mesh({1, 1, 1});
            distance(mesh, Eigen::Isometry3d::Identity(), mesh, Eigen::Isometry3d::Identity(), bad);
        };
    }
    for (const double bad : {nan, inf, 1e300}) {
        const std::string name = std::to_string(bad);
        const Segment segment{{0, 0, 0}, {0, bad, 0}};
        calls["segment " + name] = [&, segment] { world.query(segment); };
        calls["cast " + name] = [&, segment] { world.cast(segment); };
        calls["cast_all " + name] = [&, segment] { world.cast_all(segment); };
        calls["radius " + name] = [&, bad] { world.add(Sphere{bad}); };
        calls["vertex " + name] = [&, bad] {
            Mesh mesh = make_box_mesh({1, 1, 1});
            mesh.vertices[3].z() = bad;
            world.replace(box, mesh);
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
            {"add " + std::to_string(i), [&] { world.add(bad[i]); }},
            {"replace " + std::to_string(i), [&] { world.replace(box, bad[i]); }},
            {"MeshQueries " + std::to_string(i), [&] { MeshQueries queries(std::vector{bad[i]}); }},
        });
    expect_refused({{"cooked", [&] { world.add(std::shared_ptr<const CookedMesh>()); }}});
}

} // namespace
} // namespace oncollide::api_test
