// Ids that do not name anything are refused, with one clear message each.
#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

template <class Call>
std::string message_of(Call call)
{
    try {
        call();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::usage);
        return error.what();
    }
    return "no error";
}

/// A World with one model and one body in use.
struct Small {
    World world;
    ModelId model = world.add(make_box_mesh({1, 1, 1}));
    BodyId body = world.add_body({.model = model});
};

TEST(Handles, AreNullUnlessAWorldIssuedThem)
{
    EXPECT_FALSE(BodyId{});
    EXPECT_FALSE(ModelId{});
    Small s;
    EXPECT_TRUE(s.model);
    EXPECT_TRUE(s.body);
    EXPECT_EQ(s.world.body_at(s.body.slot), s.body);
    EXPECT_EQ(s.world.model_at(s.model.slot), s.model);
    EXPECT_FALSE(s.world.body_at(7));
    EXPECT_FALSE(s.world.model_at(7));
}

TEST(Handles, NullOnesAreRefusedAndNeverMeanTheFirstBodyOrModel)
{
    Small s;
    const std::string body = "body: the id is null; add_body() returns ids",
                      model = "model: the id is null; add() returns ids";
    EXPECT_EQ(message_of([&] { s.world.add_body({}); }), model) << "a BodySpec without a model";
    EXPECT_EQ(message_of([&] { s.world.set_pose({}, Eigen::Isometry3d::Identity()); }), body);
    EXPECT_EQ(message_of([&] { s.world.remove_body({}); }), body);
    EXPECT_EQ(message_of([&] { s.world.query(std::vector<ModelQuery>(1), *std::make_unique<QueryHits>()); }),
              "query 0: " + model);
    EXPECT_EQ(message_of([&] { s.world.decide(s.body, BodyId{}); }), body);
    EXPECT_EQ(message_of([&] { s.world.decide(s.body, PlacedModel{}); }), model);
    std::vector<Finding> found(1);
    EXPECT_EQ(message_of([&] { s.world.decide(std::vector<PairOfModels>(1), found); }), "pair 0: a: " + model);
    EXPECT_FALSE(s.world.contains(BodyId{}));
    EXPECT_FALSE(s.world.contains(ModelId{}));
    EXPECT_EQ(s.world.size(), 1u);
}

TEST(Handles, ThoseOfAnotherWorldAreRefused)
{
    Small one, other;
    EXPECT_EQ(one.body.slot, other.body.slot);
    EXPECT_EQ(message_of([&] { one.world.pose(other.body); }), "body 0: the id is of another World");
    EXPECT_EQ(message_of([&] { one.world.add_body({.model = other.model}); }), "model 0: the id is of another World");
    EXPECT_FALSE(one.world.contains(other.body));
    World moved = std::move(one.world);
    EXPECT_TRUE(moved.contains(one.body)) << "ids stay valid when their World moves";
}

TEST(Handles, StaleOnesAreRefusedAlsoAfterTheirSlotIsUsedAgain)
{
    Small s;
    const BodyId old = s.body;
    s.world.remove_body(old);
    EXPECT_EQ(message_of([&] { s.world.pose(old); }), "body 0 (generation 1): was removed; its id is stale");
    const BodyId next = s.world.add_body({.model = s.model});
    EXPECT_EQ(next.slot, old.slot);
    EXPECT_EQ(message_of([&] { s.world.pose(old); }), "body 0 (generation 1): was removed; its id is stale");
    s.world.remove_body(next);
    s.world.remove(s.model);
    EXPECT_EQ(message_of([&] { s.world.closed(s.model); }), "model 0 (generation 1): was removed; its id is stale");
}

TEST(Handles, ASlotWhoseGenerationsAreUsedUpIsNotUsedAgain)
{
    World world;
    const ModelId model = world.add(Shape(Sphere{1}));
    const BodyId first = world.add_body({.model = model});
    BodyId last = first;
    for (int i = 1; i < 0xffff; ++i) world.remove_body(last), last = world.add_body({.model = model});
    EXPECT_EQ(last.slot, first.slot);
    EXPECT_EQ(last.generation, 0xffff);
    world.remove_body(last);
    const BodyId other = world.add_body({.model = model});
    EXPECT_NE(other.slot, first.slot) << "its next id would be null, the one after it the first again";
    EXPECT_FALSE(world.contains(first));
    EXPECT_FALSE(world.contains(last));
}

TEST(Handles, AMovedFromWorldSaysSo)
{
    Small s;
    World moved = std::move(s.world);
    const std::string expected = "World: it was moved from; only assign to it or destroy it";
    EXPECT_EQ(message_of([&] { s.world.step(); }), expected);
    EXPECT_EQ(message_of([&] { s.world.add(Shape(Sphere{1})); }), expected);
    EXPECT_EQ(message_of([&] { s.world.inspect(); }), expected);
    EXPECT_EQ(message_of([&] { s.world.settings(); }), expected);
    EXPECT_EQ(message_of([&] { s.world.query(Segment{{0, 0, 0}, {1, 0, 0}}); }), expected);
    s.world = World();
    EXPECT_EQ(s.world.size(), 0u);
}

TEST(Handles, ExcludingAndIncludingAPairAgainAndAgainTakesNoMemory)
{
    Small s;
    const BodyId other = s.world.add_body({.model = s.model});
    s.world.exclude(s.body, other);
    EXPECT_TRUE(s.world.excluded(other, s.body));
    const std::size_t before = s.world.inspect().bytes;
    for (int i = 0; i < 1000; ++i) s.world.include(s.body, other), s.world.exclude(s.body, other);
    EXPECT_EQ(s.world.inspect().bytes, before);
    s.world.include(s.body, other);
    EXPECT_FALSE(s.world.excluded(s.body, other));
}

} // namespace
} // namespace oncollide
