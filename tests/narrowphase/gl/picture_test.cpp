// Pictures are checked by colour and position, with tolerances for the lights and for other renderers.
#include <numbers>

#include <gtest/gtest.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/gl/picture.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide {
namespace {

constexpr Colour red{200, 20, 20}, blue{20, 20, 200};

struct Pixels {
    std::vector<std::uint8_t> bytes;
    int width;

    std::uint8_t at(int x, int y, int channel) const { return bytes[std::size_t(3 * (y * width + x) + channel)]; }
    bool is(int x, int y, int channel) const
    {
        const int mine = at(x, y, channel), other = std::max(at(x, y, (channel + 1) % 3), at(x, y, (channel + 2) % 3));
        return mine > 2 * other;
    }
    bool is_red(int x, int y) const { return is(x, y, 0); }
    bool is_blue(int x, int y) const { return is(x, y, 2); }
    int count_red() const
    {
        int count = 0;
        for (int y = 0; y < int(bytes.size()) / 3 / width; ++y)
            for (int x = 0; x < width; ++x) count += is_red(x, y);
        return count;
    }
};

/// 120 x 90 pixels; the plane through the origin is 4 m high, so a metre there is 22.5 pixels.
Picture empty_picture()
{
    Picture picture;
    picture.camera = {.eye = {0, -10, 0}, .look_at = {0, 0, 0}, .view_angle = 2 * std::atan(0.2)};
    picture.width = 120, picture.height = 90;
    return picture;
}

Pixels draw(const Picture& picture)
{
    return {Painter().draw(picture), picture.width};
}

TEST(Picture, ABallCoversItsDisc)
{
    Picture picture = empty_picture();
    picture.balls.push_back({{0, 0, 0}, 1, red});
    const Pixels seen = draw(picture);
    ASSERT_EQ(seen.bytes.size(), 3u * 120 * 90);
    EXPECT_TRUE(seen.is_red(60, 45));
    EXPECT_NEAR(seen.count_red(), std::numbers::pi * 22.5 * 22.5, 0.05 * std::numbers::pi * 22.5 * 22.5);
    for (int channel = 0; channel < 3; ++channel) EXPECT_EQ(seen.at(2, 2, channel), 255) << "background";
}

TEST(Picture, RowsStartAtTheTopAndXGoesToTheRight)
{
    Picture picture = empty_picture();
    picture.balls = {{{-1.5, 0, 1}, 0.4, red}, {{1.5, 0, -1}, 0.4, blue}};
    const Pixels seen = draw(picture);
    EXPECT_TRUE(seen.is_red(60 - 34, 45 - 22));
    EXPECT_TRUE(seen.is_blue(60 + 34, 45 + 22));
}

TEST(Picture, TheNearThingHidesTheFarWhicheverComesFirst)
{
    const Mesh wall = make_box_mesh({1, 0.1, 1});
    for (double y : {-2.0, 2.0}) {
        Picture picture = empty_picture();
        picture.balls = {{{0, 0, 0}, 0.8, blue}, {{0, y, 0}, 0.3, red}};
        EXPECT_EQ(draw(picture).is_red(60, 45), y < 0);
        std::swap(picture.balls[0], picture.balls[1]);
        EXPECT_EQ(draw(picture).is_red(60, 45), y < 0);

        picture.balls = {{{0, 0, 0}, 0.8, blue}};
        picture.bodies = {{&wall, Eigen::Isometry3d(Eigen::Translation3d(0, y, 0)), red}};
        EXPECT_EQ(draw(picture).is_red(60, 45), y < 0);
    }
}

TEST(Picture, WhatABallHasInFrontOfAWallIsRound)
{
    const Mesh wall = make_box_mesh({3, 0.1, 3});
    Picture picture = empty_picture();
    picture.bodies = {{&wall, Eigen::Isometry3d(Eigen::Translation3d(0, -0.1, 0)), blue}}; // its face: y = -0.2
    picture.balls = {{{0, 0, 0}, 1, red}};
    const double radius2 = (1 - 0.2 * 0.2) * 22.5 * 22.5;
    EXPECT_NEAR(draw(picture).count_red(), std::numbers::pi * radius2, 0.07 * std::numbers::pi * radius2);
}

TEST(Picture, BubblesLetOneSeeThrough)
{
    Picture picture = empty_picture();
    Colour bubble = blue;
    bubble.alpha = 80;
    picture.balls = {{{0, -2, 0}, 1, bubble}, {{0, 0, 0}, 0.5, red}};
    const Pixels seen = draw(picture);
    EXPECT_TRUE(seen.is_red(60, 45));
    picture.balls.erase(picture.balls.begin());
    EXPECT_GT(seen.at(60, 45, 2), draw(picture).at(60, 45, 2)) << "the transparent sphere is also visible";
}

TEST(Picture, BodiesOfGlassLetOneSeeThrough)
{
    Picture picture = empty_picture();
    const Mesh wall = make_box_mesh({1, 0.1, 1});
    Colour glass = blue;
    glass.alpha = 30;
    picture.bodies = {{&wall, Eigen::Isometry3d(Eigen::Translation3d(0, -2, 0)), glass}};
    picture.balls = {{{0, 0, 0}, 0.5, red}};
    const Pixels seen = draw(picture);
    EXPECT_TRUE(seen.is_red(60, 45));
    EXPECT_LT(seen.at(60 + 20, 45, 0), 230) << "beside the sphere the glass is visible";
    picture.bodies.clear();
    EXPECT_GT(seen.at(60, 45, 2), draw(picture).at(60, 45, 2)) << "the glass also covers the sphere";
}

TEST(Picture, LinesAreSeenThroughAllElseAndAreAsWideAsTheyShould)
{
    Picture picture = empty_picture();
    const Mesh wall = make_box_mesh({2, 0.1, 2});
    picture.bodies = {{&wall, Eigen::Isometry3d(Eigen::Translation3d(0, -2, 0)), blue}};
    picture.lines = {{{-1, 0, 0}, {1, 0, 0}, 4, red}};
    const Pixels seen = draw(picture);
    EXPECT_TRUE(seen.is_red(60, 45));
    EXPECT_TRUE(seen.is_blue(60, 45 + 5));
    EXPECT_NEAR(seen.count_red(), (45 + 4) * 4, 30);
    picture.lines = {{{0, 0, 0}, {0, 0, 0}, 6, red}};
    EXPECT_NEAR(draw(picture).count_red(), 36, 8) << "a dot";
    picture.lines = {{{0, 0, 0}, {0, -20, 0}, 6, red}};
    EXPECT_EQ(draw(picture).count_red(), 0) << "the line ends behind the camera";
}

TEST(Picture, PlacesFarFromTheOriginLookTheSame)
{
    const Eigen::Vector3d far(1e7, -1e7, 1e7);
    Picture near = empty_picture(), moved = near;
    const Mesh box = make_box_mesh({0.5, 0.5, 0.5}), far_box = transformed("far", box, 1, -far);
    near.bodies = {{&box, Eigen::Isometry3d::Identity(), blue}}, near.balls = {{{1, 0, 0}, 0.5, red}};
    moved.bodies = {{&far_box, Eigen::Isometry3d::Identity(), blue}},
    moved.balls = {{far + near.balls[0].centre, 0.5, red}};
    moved.camera.eye += far, moved.camera.look_at += far;
    const Pixels a = draw(near), b = draw(moved);
    int different = 0;
    for (std::size_t i = 0; i < a.bytes.size(); ++i) different += std::abs(a.bytes[i] - b.bytes[i]) > 2;
    EXPECT_LT(different, 30);
}

TEST(Picture, TheSamePictureGivesTheSameBytes)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 1, 0.4, 0.15, 1500);
    Picture picture = empty_picture();
    picture.bodies = {{&knot, Eigen::Isometry3d::Identity(), blue}};
    for (int i = 0; i < 50; ++i)
        picture.balls.push_back({{0.05 * i - 1, 0.3 * (i % 3), 0.1 * (i % 7)}, 0.2, {200, 20, 20, 120}});
    Painter painter;
    const std::vector<std::uint8_t> first = painter.draw(picture);
    EXPECT_EQ(first, painter.draw(picture));
    EXPECT_EQ(first, Painter().draw(picture));
}

TEST(Picture, NothingToDrawIsBackground)
{
    Picture picture = empty_picture();
    picture.background = {10, 20, 30};
    const Pixels seen = draw(picture);
    EXPECT_EQ(seen.at(60, 45, 0), 10);
    EXPECT_EQ(seen.at(119, 89, 2), 30);
}

TEST(Picture, AnUnknownGpuIsAnError)
{
    try {
        Painter painter(99);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::no_gpu);
    }
}

} // namespace
} // namespace oncollide
