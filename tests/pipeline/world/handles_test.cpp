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
    ModelId model = world.models().add(make_box_mesh({1, 1, 1}));
    BodyId body = world.bodies().add({.model = model});
};

TEST(Handles, AreNullUnlessAWorldIssuedThem)
{
    EXPECT_FALSE(BodyId{});
    EXPECT_FALSE(ModelId{});
    Small s;
    EXPECT_TRUE(s.model);
    EXPECT_TRUE(s.body);
    EXPECT_EQ(s.world.bodies().at(s.body.slot), s.body);
    EXPECT_EQ(s.world.models().at(s.model.slot), s.model);
    EXPECT_FALSE(s.world.bodies().at(7));
    EXPECT_FALSE(s.world.models().at(7));
}

TEST(Handles, NullOnesAreRefusedAndNeverMeanTheFirstBodyOrModel)
{
    Small s;
    const std::string body = "body: the id is null; Bodies::add() returns ids",
                      model = "model: the id is null; Models::add() returns ids";
    EXPECT_EQ(message_of([&] { s.world.bodies().add({}); }), model) << "a BodySpec without a model";
    EXPECT_EQ(message_of([&] { s.world.bodies().set_pose({}, Eigen::Isometry3d::Identity()); }), body);
    EXPECT_EQ(message_of([&] { s.world.bodies().remove(BodyId{}); }), body);
    EXPECT_EQ(message_of([&] {
                  s.world.space().overlaps(std::vector<PlacedModel>(1), {}, *std::make_unique<Lists<QueryHit>>());
              }),
              "overlaps 0: " + model);
    EXPECT_EQ(message_of([&] { s.world.pairs().decide(s.body, BodyId{}); }), body);
    EXPECT_EQ(message_of([&] { s.world.pairs().decide(s.body, PlacedModel{}); }), model);
    std::vector<Finding> found(1);
    EXPECT_EQ(message_of([&] { s.world.pairs().decide(std::vector<PairOfModels>(1), found); }), "pair 0: a: " + model);
    EXPECT_FALSE(s.world.bodies().contains(BodyId{}));
    EXPECT_FALSE(s.world.models().contains(ModelId{}));
    EXPECT_EQ(s.world.bodies().size(), 1u);
}

TEST(Handles, ThoseOfAnotherWorldAreRefused)
{
    Small one, other;
    EXPECT_EQ(one.body.slot, other.body.slot);
    EXPECT_EQ(message_of([&] { one.world.bodies().pose(other.body); }), "body 0: the id is of another World");
    EXPECT_EQ(message_of([&] { one.world.bodies().add({.model = other.model}); }),
              "model 0: the id is of another World");
    EXPECT_FALSE(one.world.bodies().contains(other.body));
    World moved = std::move(one.world);
    EXPECT_TRUE(moved.bodies().contains(one.body)) << "ids stay valid when their World moves";
}

TEST(Handles, StaleOnesAreRefusedAlsoAfterTheirSlotIsUsedAgain)
{
    Small s;
    const BodyId old = s.body;
    s.world.bodies().remove(old);
    EXPECT_EQ(message_of([&] { s.world.bodies().pose(old); }), "body 0 (generation 1): was removed; its id is stale");
    const BodyId next = s.world.bodies().add({.model = s.model});
    EXPECT_EQ(next.slot, old.slot);
    EXPECT_EQ(message_of([&] { s.world.bodies().pose(old); }), "body 0 (generation 1): was removed; its id is stale");
    s.world.bodies().remove(next);
    s.world.models().remove(s.model);
    EXPECT_EQ(message_of([&] { s.world.models().closed(s.model); }),
              "model 0 (generation 1): was removed; its id is stale");
}

TEST(Handles, ASlotWhoseGenerationsAreUsedUpIsNotUsedAgain)
{
    World world;
    const ModelId model = world.models().add(Shape(Sphere{1}));
    const BodyId first = world.bodies().add({.model = model});
    BodyId last = first;
    for (int i = 1; i < 0xffff; ++i) world.bodies().remove(last), last = world.bodies().add({.model = model});
    EXPECT_EQ(last.slot, first.slot);
    EXPECT_EQ(last.generation, 0xffff);
    world.bodies().remove(last);
    const BodyId other = world.bodies().add({.model = model});
    EXPECT_NE(other.slot, first.slot) << "its next id would be null, the one after it the first again";
    EXPECT_FALSE(world.bodies().contains(first));
    EXPECT_FALSE(world.bodies().contains(last));
}

TEST(Handles, AMovedFromWorldSaysSo)
{
    Small s;
    World moved = std::move(s.world);
    const std::string expected = "World: it was moved from; only assign to it or destroy it";
    EXPECT_EQ(message_of([&] { s.world.step(); }), expected);
    EXPECT_EQ(message_of([&] { s.world.models().add(Shape(Sphere{1})); }), expected);
    EXPECT_EQ(message_of([&] { s.world.inspect(); }), expected);
    EXPECT_EQ(message_of([&] { s.world.settings(); }), expected);
    EXPECT_EQ(message_of([&] { s.world.space().overlaps(Segment{{0, 0, 0}, {1, 0, 0}}); }), expected);
    s.world = World();
    EXPECT_EQ(s.world.bodies().size(), 0u);
}

TEST(Handles, ExcludingAndIncludingAPairAgainAndAgainTakesNoMemory)
{
    Small s;
    const BodyId other = s.world.bodies().add({.model = s.model});
    s.world.bodies().exclude(s.body, other);
    EXPECT_TRUE(s.world.bodies().excluded(other, s.body));
    const std::size_t before = s.world.inspect().bytes;
    for (int i = 0; i < 1000; ++i) s.world.bodies().include(s.body, other), s.world.bodies().exclude(s.body, other);
    EXPECT_EQ(s.world.inspect().bytes, before);
    s.world.bodies().include(s.body, other);
    EXPECT_FALSE(s.world.bodies().excluded(s.body, other));
}

} // namespace
} // namespace oncollide
