// Pairs of models at poses as columns, for every two kinds of geometry.
#include <gtest/gtest.h>

#include "every_kind.hpp"
#include "random_pose.hpp"
#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>

namespace oncollide::pair_columns_test {
namespace {

/// The same pairs, one by one and as columns.
struct Both {
    World world;
    std::vector<ModelId> models;
    std::vector<PairOfModels> pairs;
    std::vector<ModelId> a, b;
    std::vector<double> poses_a, poses_b;

    Both(const Settings& settings, std::size_t count) : world(settings)
    {
        for (std::size_t kind = 0; kind < kinds; ++kind) models.push_back(world.models().add(draw_geometry(kind, 7)));
        const auto append = [](std::vector<double>& rows, const Eigen::Isometry3d& pose) {
            for (int r = 0; r < 4; ++r)
                for (int c = 0; c < 4; ++c) rows.push_back(pose(r, c));
        };
        for (std::size_t i = 0; i < count; ++i) {
            const Eigen::Isometry3d at = random_pose(i, 20);
            pairs.push_back({{models[i % kinds], at}, {models[i / kinds % kinds], at * random_pose(i + 3000, 1.6)}});
            a.push_back(pairs[i].a.model), b.push_back(pairs[i].b.model);
            append(poses_a, pairs[i].a.pose), append(poses_b, pairs[i].b.pose);
        }
    }
    PairOfColumns columns() const { return {{a, poses_a}, {b, poses_b}}; }
};

class EveryExactness : public ::testing::TestWithParam<ExactLevel> {};

TEST_P(EveryExactness, ColumnsOfAnyKindAnswerAsPairsAndSpaceDo)
{
    Both both({.exact = GetParam(), .bounding_volume = BoundingVolume::obb, .threads = 2}, 500);
    std::vector<Finding> columns(both.pairs.size()), pairs(both.pairs.size());
    both.world.pairs().decide(both.columns(), columns);
    both.world.pairs().decide(both.pairs, pairs);
    std::size_t near = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const auto& [a, b] = both.pairs[i];
        EXPECT_EQ(columns[i], pairs[i]) << i;
        const BodyId body = both.world.bodies().add({.model = b.model, .pose = b.pose});
        const std::vector<QueryHit> hits = both.world.space().overlaps(a);
        EXPECT_EQ(columns[i].verdict == Verdict::separate, hits.empty()) << i;
        EXPECT_TRUE(hits.empty() || columns[i] == static_cast<const Finding&>(hits[0])) << i;
        near += !hits.empty();
        both.world.bodies().remove(body);
    }
    EXPECT_GT(near, 100u);
    EXPECT_LT(near, 450u);
}

INSTANTIATE_TEST_SUITE_P(PairColumns, EveryExactness, ::testing::Values(ExactLevel::off, ExactLevel::predicates));

TEST(PairColumns, EveryQueryTakesThem)
{
    Both both({.threads = 2}, 300);
    std::vector<Distance> distances(both.pairs.size());
    std::vector<Penetration> depths(both.pairs.size());
    Lists<Contact> contacts;
    ManifoldLists manifolds, same;
    both.world.pairs().distance(both.columns(), {}, distances);
    both.world.pairs().penetration(both.columns(), depths);
    both.world.pairs().contacts(both.columns(), contacts);
    both.world.pairs().manifold(both.columns(), {}, manifolds);
    both.world.pairs().manifold(both.pairs, {}, same);
    EXPECT_EQ(hash_of(manifolds), hash_of(same));
    ASSERT_EQ(contacts.size(), both.pairs.size());
    for (std::size_t i = 0; i < both.pairs.size(); ++i) {
        const auto& [a, b] = both.pairs[i];
        const Distance d = both.world.pairs().distance(a, b);
        EXPECT_EQ(distances[i].lower, d.lower) << i;
        EXPECT_EQ(distances[i].upper, d.upper) << i;
        EXPECT_EQ(distances[i].point_a, d.point_a) << i;
        EXPECT_EQ(depths[i].depth_upper, both.world.pairs().penetration(a, b).depth_upper) << i;
        EXPECT_EQ(contacts[i].size(), both.world.pairs().contacts(a, b).size()) << i;
    }
}

TEST(PairColumns, AColumnOfOneEntryServesAllPairsOverManyBatches)
{
    const std::size_t count = 20'000; // batches hold 8,192
    std::vector<double> here(16, 0), there;
    for (int k = 0; k < 4; ++k) here[std::size_t(5 * k)] = 1;
    for (std::size_t i = 0; i < count; ++i) {
        there.insert(there.end(), here.begin(), here.end());
        there[16 * i + 3] = 4.0 * double(i) / double(count); // row 0, column 3: along x
    }
    World world({.exact = ExactLevel::predicates});
    const ModelId ball = world.models().add(Sphere{1});
    std::vector<Finding> found(count);
    world.pairs().decide(PairOfColumns{{{&ball, 1}, here}, {{&ball, 1}, there}}, found);
    for (std::size_t i = 0; i < count; ++i)
        EXPECT_EQ(found[i].verdict, i <= count / 2 ? Verdict::colliding : Verdict::separate) << i;
}

TEST(PairColumns, RefuseOtherLengthsAndNameWhatIsWrong)
{
    Both both({}, 3);
    std::vector<Finding> found(3);
    const auto message = [&](const PairOfColumns& columns) -> std::string {
        try {
            both.world.pairs().decide(columns, found);
            return "";
        } catch (const Error& error) {
            return error.what();
        }
    };
    PairOfColumns columns = both.columns();
    columns.b.models = columns.b.models.first(2);
    EXPECT_NE(message(columns).find("column b.models: 2 numbers; must be"), std::string::npos) << message(columns);
    columns = both.columns(), columns.a.poses = columns.a.poses.first(33);
    EXPECT_NE(message(columns).find("column a.poses: 33 numbers; must be 48"), std::string::npos) << message(columns);
    both.b[1] = ModelId{};
    EXPECT_EQ(message(both.columns()), "pair 1: b: model: the id is null; Models::add() returns ids");
    both.b[1] = both.b[0], both.poses_b[16 + 12] = 1; // the matrix is stored in the other order
    EXPECT_EQ(message(both.columns()), "pair 1: b: the pose's last row is not (0, 0, 0, 1)");
    both.poses_b[16 + 12] = 0;
    EXPECT_THROW(both.world.pairs().decide(both.columns(), {}), Error);
    EXPECT_EQ(message(both.columns()), "");
}

} // namespace
} // namespace oncollide::pair_columns_test
