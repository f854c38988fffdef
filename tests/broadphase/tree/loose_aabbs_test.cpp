#include <gtest/gtest.h>

#include "broadphase/boxes.hpp"

#include <oncollide/broadphase/tree/loose_aabbs.hpp>

namespace oncollide {
namespace {

/// Boxes of side 1 at rest in a row; each test moves some.
class LooseAabbsOf : public testing::Test {
protected:
    LooseAabbsOf()
    {
        for (int i = 0; i < 100; ++i) scene.add({3.0 * i, 0, 0}, {3.0 * i + 1, 1, 1});
    }
    Aabb renew(std::uint32_t body) { return loose.renew(body, scene.columns(), true); }
    bool holds(std::uint32_t body) const { return loose.hold(body, scene.columns(), true, true); }

    Boxes scene;
    LooseAabbs loose;
};

TEST_F(LooseAabbsOf, GivesNoRoomToABodyThatIsNew)
{
    EXPECT_FALSE(holds(4));
    const Aabb box = renew(4);
    EXPECT_EQ(box.min, scene.boxes[4].min);
    EXPECT_EQ(box.max, scene.boxes[4].max);
    EXPECT_TRUE(holds(4));
    EXPECT_FALSE(holds(5));
    scene.step(4, {0.001, 0, 0});
    EXPECT_FALSE(holds(4)) << "it left the box of its first frame";
}

TEST_F(LooseAabbsOf, GivesRoomForThreeToSixFramesOfTheRecentMotion)
{
    constexpr double step = 0.01;
    std::array<int, 10> frames_held{};
    for (std::uint32_t body : scene.all) {
        renew(body);
        loose.end_frame();
        scene.step(body, {step, 0, 0});
        ASSERT_FALSE(holds(body));
        renew(body);
        std::size_t frames = 0;
        for (; holds(body) && frames < 10; ++frames) scene.step(body, {step * (1 - 1e-9), 0, 0});
        ++frames_held[frames - 1]; // the frame that left it does not count
    }
    for (std::size_t frames = 0; frames < frames_held.size(); ++frames)
        EXPECT_EQ(frames_held[frames] > 0, frames >= 3 && frames <= 6) << frames;
}

TEST_F(LooseAabbsOf, GivesNoRoomToAFastBody)
{
    renew(0);
    loose.end_frame();
    scene.step(0, {5, 0, 0});
    const Aabb box = renew(0);
    EXPECT_EQ(box.min, scene.boxes[0].min);
    EXPECT_EQ(box.max, scene.boxes[0].max);
}

TEST_F(LooseAabbsOf, HoldNoBodyWhoseFiltersOrKindChanged)
{
    renew(1);
    EXPECT_TRUE(holds(1));
    EXPECT_FALSE(loose.hold(1, scene.columns(), false, false)) << "it is static now";
    for (std::vector<std::uint32_t>* column : {&scene.layers, &scene.masks, &scene.groups}) {
        const std::uint32_t before = (*column)[1];
        (*column)[1] = 12;
        EXPECT_FALSE(holds(1));
        EXPECT_TRUE(loose.hold(1, scene.columns(), true, false)) << "the caller says that filters did not change";
        (*column)[1] = before;
    }
    EXPECT_TRUE(holds(1));
}

TEST_F(LooseAabbsOf, ReusesTheRowOfABodyThatIsErased)
{
    EXPECT_TRUE(loose.empty());
    for (std::uint32_t body = 0; body < 50; ++body) renew(body);
    const std::size_t bytes = loose.bytes();
    for (std::uint32_t body = 0; body < 50; body += 2) loose.erase(body);
    loose.erase(99); // never had a box
    EXPECT_FALSE(holds(2));
    EXPECT_EQ(loose.find(2), nullptr);
    EXPECT_TRUE(holds(3));
    EXPECT_EQ(loose.validate(scene.columns()), "");
    for (std::uint32_t body = 50; body < 75; ++body) renew(body);
    EXPECT_EQ(loose.validate(scene.columns()), "");
    EXPECT_LE(loose.bytes(), bytes + 64 * sizeof(std::uint32_t));
    EXPECT_FALSE(loose.empty());
    loose.clear();
    EXPECT_TRUE(loose.empty());
    EXPECT_EQ(loose.validate(scene.columns()), "");
}

TEST_F(LooseAabbsOf, NamesABodyThatLeftItsBoxUnnoticed)
{
    for (std::uint32_t body = 0; body < 50; ++body) renew(body);
    EXPECT_EQ(loose.validate(scene.columns()), "");
    scene.step(31, {0, 0, 1e-6});
    EXPECT_EQ(loose.validate(scene.columns()), "body 31 is outside its box");
}

} // namespace
} // namespace oncollide
