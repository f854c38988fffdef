#include <memory>

#include <gtest/gtest.h>

#include <oncollide/pipeline/world/body_table.hpp>
#include <oncollide/scenes/geometry.hpp>

namespace oncollide::body_table_test {
namespace {

class BodiesTest : public testing::Test {
protected:
    std::uint32_t add(bool is_static = false, std::uint32_t group = 0)
    {
        const std::uint32_t slot =
            bodies.add({&model, ModelId{0, 1, 1}, Eigen::Isometry3d::Identity(), 1, ~0u, group, 0, is_static});
        EXPECT_EQ(bodies.validate(), "");
        return slot;
    }
    void remove(std::uint32_t slot)
    {
        bodies.remove(slot);
        EXPECT_EQ(bodies.validate(), "");
    }
    BodyChanges changes()
    {
        BodyChanges changes;
        bodies.take_changes(changes);
        update_boxes(bodies, changes, true, 1);
        EXPECT_EQ(bodies.validate(), "");
        return changes;
    }
    static Eigen::Isometry3d at(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

    Model model{std::make_shared<const Geometry>(Geometry{"ball", Shape(Sphere{0.5}), {}})};
    BodyTable bodies{1};
};

using Slots = std::vector<std::uint32_t>;

TEST_F(BodiesTest, ListEachChangeOnceUnderTheNetEffect)
{
    const std::uint32_t a = add(), b = add(true), c = add();
    BodyChanges now = changes();
    EXPECT_EQ(now.added_dynamic, (Slots{a, c}));
    EXPECT_EQ(now.added_static, Slots{b});
    EXPECT_EQ(now.fresh, (Slots{a, b, c}));
    bodies.set_pose(a, at(1)), bodies.set_pose(a, at(2)), bodies.set_pose(b, at(0));
    bodies.set_static(c, true), bodies.set_static(b, false), bodies.set_static(b, true);
    now = changes();
    EXPECT_EQ(now.moved, Slots{a}) << "b is where it was";
    EXPECT_EQ(now.made_static, Slots{c});
    EXPECT_TRUE(now.made_dynamic.empty()) << "b is static again";
    remove(a);
    const std::uint32_t passing = add();
    EXPECT_EQ(passing, a) << "the slot freed last is reused";
    remove(passing), remove(c);
    now = changes();
    EXPECT_EQ(now.removed, (Slots{a, c}));
    EXPECT_TRUE(now.added_dynamic.empty());
    EXPECT_EQ(bodies.size(), 1u);
}

TEST_F(BodiesTest, GiveAReusedSlotANewGeneration)
{
    const std::uint32_t slot = add();
    const BodyId first = bodies.id(slot);
    remove(slot);
    EXPECT_FALSE(bodies.valid(first));
    EXPECT_EQ(add(), slot);
    EXPECT_FALSE(bodies.valid(first));
    EXPECT_TRUE(bodies.valid(bodies.id(slot)));
}

TEST_F(BodiesTest, KeepASlotEmptyOnceItsGenerationsAreUsedUp)
{
    std::uint32_t slot = bodies.add({&model, ModelId{0, 1, 1}, at(0), 1, ~0u, 0, 0, false});
    const std::uint32_t only = slot;
    for (int use = 0; slot == only; ++use) {
        ASSERT_LT(use, 70000);
        bodies.remove(slot);
        slot = bodies.add({&model, ModelId{0, 1, 1}, at(0), 1, ~0u, 0, 0, false});
    }
    EXPECT_EQ(bodies.validate(), "");
    EXPECT_FALSE(bodies.alive(only));
    EXPECT_EQ(bodies.size(), 1u);
}

TEST_F(BodiesTest, ForgetTheExclusionsOfABodyThatIsRemoved)
{
    const std::uint32_t a = add(), b = add(), c = add();
    bodies.exclude(a, b), bodies.exclude(b, c), bodies.exclude(c, b);
    EXPECT_TRUE(bodies.excluded(b, a) && bodies.excluded(b, c));
    remove(b);
    EXPECT_FALSE(bodies.any_excluded());
    EXPECT_EQ(add(), b);
    EXPECT_FALSE(bodies.excluded(a, b)) << "another body in the same slot";
}

TEST_F(BodiesTest, NameTheFirstFault)
{
    const std::uint32_t a = add(), b = add();
    changes();
    bodies.boxes()[b].max.x() = -100;
    EXPECT_EQ(bodies.validate(), "body 1 has an empty AABB");
    bodies.boxes().pop_back();
    EXPECT_EQ(bodies.validate(), "a column has 1 rows for 2 slots");
    bodies.boxes().push_back(bodies.boxes()[a]);
    EXPECT_EQ(bodies.validate(), "");
    bodies.exclude(a, 7);
    EXPECT_EQ(bodies.validate(), "the excluded pair (0, 7) is not of two bodies");
}

} // namespace
} // namespace oncollide::body_table_test
