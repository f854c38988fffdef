// MeshQueries from columns, and for geometries of any kind. predicates_test.cpp tests the results of meshes.
#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/mesh_queries.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

#include "random_pose.hpp"

namespace oncollide {
namespace {

std::vector<std::shared_ptr<const Geometry>> one_of_each()
{
    CellTree cells;
    cells.set(CellBox({-2, -2, -2}, {2, 1, 2}), CellState::occupied);
    std::vector<std::shared_ptr<const Geometry>> all;
    for (GeometryData data :
         {GeometryData(make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 300)), GeometryData(make_box_mesh({1, 0.5, 1})),
          GeometryData(Shape(Box{{0.5, 1, 1}})), GeometryData(Shape(Capsule{0.5, 1})),
          GeometryData(MapAccess::make("map", cells, 0.3)), GeometryData(make_hills(12, 12, 0.25, 0.5, 3))})
        all.push_back(std::make_shared<const Geometry>(Geometry{"", std::move(data), ""}));
    return all;
}

/// The same queries, one by one and as columns.
struct Both {
    std::vector<MeshQuery> queries;
    std::vector<std::uint32_t> a, b;
    std::vector<double> poses_a, poses_b;

    Both(std::uint32_t count, std::uint32_t kinds)
    {
        const auto append = [](std::vector<double>& rows, const Eigen::Isometry3d& pose) {
            for (int r = 0; r < 4; ++r)
                for (int c = 0; c < 4; ++c) rows.push_back(pose(r, c));
        };
        for (std::uint32_t i = 0; i < count; ++i) {
            const Eigen::Isometry3d at = random_pose(i, 20);
            queries.push_back({i % kinds, i / kinds % kinds, at, at * random_pose(i + 3000, 1.6)});
            a.push_back(queries[i].a), b.push_back(queries[i].b);
            append(poses_a, queries[i].pose_a), append(poses_b, queries[i].pose_b);
        }
    }
    MeshQueryColumns columns() const { return {a, b, poses_a, poses_b}; }
};

class EveryExactness : public ::testing::TestWithParam<ExactLevel> {};

TEST_P(EveryExactness, ColumnsOfAnyKindAnswerAsAWorldDoes)
{
    const auto geometries = one_of_each();
    const auto kinds = static_cast<std::uint32_t>(geometries.size());
    const Settings settings{.exact = GetParam(), .bounding_volume = BoundingVolume::obb, .threads = 2};
    const Both both(400, kinds);
    MeshQueries queries(geometries, settings), again(geometries, settings);
    ASSERT_EQ(queries.size(), geometries.size());
    std::vector<Verdict> verdicts(both.queries.size());
    std::vector<double> bounds(both.queries.size());
    queries.run(both.columns(), verdicts, bounds);
    std::vector<Finding> results(both.queries.size());
    again.run(both.queries, results);

    World world(settings);
    std::vector<ModelId> models;
    for (const auto& geometry : geometries) models.push_back(world.add(geometry));
    int near = 0;
    for (std::size_t i = 0; i < both.queries.size(); ++i) {
        const MeshQuery& q = both.queries[i];
        EXPECT_EQ(verdicts[i], results[i].verdict) << i;
        EXPECT_EQ(bounds[i], results[i].bound) << i;
        const BodyId body = world.add_body({.model = models[q.b], .pose = q.pose_b});
        const std::vector<QueryHit> hits = world.query(models[q.a], q.pose_a);
        EXPECT_EQ(verdicts[i] == Verdict::separate, hits.empty()) << i;
        if (!hits.empty()) {
            EXPECT_EQ(verdicts[i], hits[0].verdict) << i;
            EXPECT_EQ(bounds[i], hits[0].bound) << i;
        }
        near += !hits.empty();
        world.remove_body(body);
    }
    EXPECT_GT(near, 100);
    EXPECT_LT(near, 350);
}

INSTANTIATE_TEST_SUITE_P(MeshQueryColumns, EveryExactness, ::testing::Values(ExactLevel::off, ExactLevel::predicates));

TEST(MeshQueryColumns, DistancesOfAnyKindAreThoseOfAWorld)
{
    const auto geometries = one_of_each();
    const Both both(200, static_cast<std::uint32_t>(geometries.size()));
    MeshQueries queries(geometries, {.threads = 2});
    std::vector<Distance> distances(both.queries.size());
    queries.distances(both.columns(), 0, distances);
    World world;
    std::vector<ModelId> models;
    for (const auto& geometry : geometries) models.push_back(world.add(geometry));
    for (std::size_t i = 0; i < both.queries.size(); ++i) {
        const MeshQuery& q = both.queries[i];
        const Distance d = world.distance(world.add_body({.model = models[q.a], .pose = q.pose_a}),
                                          world.add_body({.model = models[q.b], .pose = q.pose_b}));
        EXPECT_EQ(distances[i].lower, d.lower) << i;
        EXPECT_EQ(distances[i].upper, d.upper) << i;
        EXPECT_EQ(distances[i].point_a, d.point_a) << i;
    }
}

TEST(MeshQueryColumns, AColumnOfOneEntryServesAllQueriesOverManyBatches)
{
    const std::uint32_t ball = 0;
    const std::size_t count = 20'000; // batches hold 8,192
    std::vector<double> here(16, 0), there;
    for (int k = 0; k < 4; ++k) here[std::size_t(5 * k)] = 1;
    for (std::size_t i = 0; i < count; ++i) {
        there.insert(there.end(), here.begin(), here.end());
        there[16 * i + 3] = 4.0 * double(i) / double(count); // row 0, column 3: along x
    }
    MeshQueries queries({std::make_shared<const Geometry>(Geometry{"ball", Shape(Sphere{1}), ""})},
                        {.exact = ExactLevel::predicates});
    std::vector<Verdict> verdicts(count);
    std::vector<double> bounds(count);
    queries.run({{&ball, 1}, {&ball, 1}, here, there}, verdicts, bounds);
    for (std::size_t i = 0; i < count; ++i)
        EXPECT_EQ(verdicts[i], i <= count / 2 ? Verdict::colliding : Verdict::separate) << i;
}

TEST(MeshQueryColumns, RefuseOtherLengthsAndNameWhatIsWrong)
{
    const auto geometries = one_of_each();
    MeshQueries queries(geometries);
    Both both(3, 2);
    std::vector<Verdict> verdicts(3);
    std::vector<double> bounds(3);
    const auto message = [&](const MeshQueryColumns& columns) -> std::string {
        try {
            queries.run(columns, verdicts, bounds);
            return "";
        } catch (const Error& error) {
            return error.what();
        }
    };
    MeshQueryColumns columns = both.columns();
    columns.b = columns.b.first(2);
    EXPECT_EQ(message(columns), "decide: column b: 2 numbers; must be 3, or 1 for all of the 3 pairs");
    columns = both.columns(), columns.poses_a = columns.poses_a.first(32);
    EXPECT_NE(message(columns).find("column poses_a: 32 numbers; must be 48"), std::string::npos);
    both.b[1] = 6;
    EXPECT_EQ(message(both.columns()), "query 1: there is no mesh 6; there are 6 meshes");
    both.b[1] = 0, both.poses_b[16 + 12] = 1; // the matrix is stored in the other order
    EXPECT_EQ(message(both.columns()), "pair 1: b: the pose's last row is not (0, 0, 0, 1)");
    EXPECT_THROW(queries.run(columns, verdicts, {}), Error);
    EXPECT_THROW(MeshQueries({nullptr, geometries[0]}), Error);
    queries.run({}, std::span<Verdict>(), std::span<double>());
}

} // namespace
} // namespace oncollide
