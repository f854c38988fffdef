#include <gtest/gtest.h>

#include "broadphase/boxes.hpp"

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/body_states.hpp>

namespace oncollide {
namespace {

using State = BodyStates::State;

Bodies changes_of(const BodyStates& bodies)
{
    return {bodies.changes().begin(), bodies.changes().end()};
}

TEST(BodyStates, CountBodiesAndListEachChangeOnce)
{
    BodyStates bodies;
    bodies.add(Bodies{3, 1}, false), bodies.add(Bodies{7}, true);
    EXPECT_EQ(bodies.validate(), "");
    EXPECT_EQ(bodies.size(), 3u);
    EXPECT_EQ(bodies.rows(), 8u);
    EXPECT_EQ(bodies.dynamic_count(), 2u);
    bodies.move(Bodies{1, 7}), bodies.move(Bodies{7});
    EXPECT_EQ(changes_of(bodies), (Bodies{3, 1, 7}));
    EXPECT_TRUE(bodies.some_came_or_went());
    bodies.forget_changes();
    EXPECT_TRUE(changes_of(bodies).empty());
    EXPECT_FALSE(bodies.some_came_or_went());
    bodies.set_dynamic(Bodies{7}, true), bodies.remove(Bodies{3});
    EXPECT_EQ(bodies.validate(), "");
    EXPECT_EQ(changes_of(bodies), (Bodies{7, 3}));
    EXPECT_EQ(bodies.dynamic_count(), 2u);
    Bodies present;
    bodies.list(present);
    EXPECT_EQ(present, (Bodies{1, 7}));
}

TEST(BodyStates, ChangeNothingIfOneBodyOfACallIsWrong)
{
    BodyStates bodies;
    bodies.add(Bodies{0, 1, 2}, false);
    bodies.forget_changes();
    EXPECT_THROW(bodies.add(Bodies{5, 2}, false), Error);
    EXPECT_THROW(bodies.remove(Bodies{1, 5}), Error);
    EXPECT_THROW(bodies.move(Bodies{0, 4000000000u}), Error);
    EXPECT_TRUE(changes_of(bodies).empty());
    EXPECT_EQ(bodies.size(), 3u);
    EXPECT_EQ(bodies.validate(), "");
}

TEST(BodyStates, NameACountOrAListThatIsWrong)
{
    BodyStates bodies;
    bodies.add(Bodies{0, 1, 2}, false);
    bodies.clear(1, State::changed);
    EXPECT_EQ(bodies.validate(), "a wrong number of changed bodies");
    bodies.set(1, State::changed), bodies.clear(2, State::dynamic);
    EXPECT_EQ(bodies.validate(), "a wrong number of bodies or of dynamic bodies");
    bodies.set(2, State::dynamic), bodies.clear(2, State::present);
    EXPECT_EQ(bodies.validate(), "a body that is absent is dynamic");
}

} // namespace
} // namespace oncollide
