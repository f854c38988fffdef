// Pictures are decoded and checked by colour: only spheres that touch and triangles that meet are red.
#include "tools/command_fixture.hpp"
#include "tools/decoded_png.hpp"

namespace oncollide::test {
namespace {

bool is_red(const std::uint8_t* p)
{
    return p[0] > 2 * p[1] && p[0] > 2 * p[2];
}
bool is_drawn(const std::uint8_t* p)
{
    return p[0] < 250 || p[1] < 250 || p[2] < 250;
}

class Render : public CommandLine {
protected:
    void SetUp() override { write_scene("apart.json", 5), write_scene("touching.json", 1.02); }

    /// Two spheres of radius 0.5; at frame f the second has moved by f / 100 m.
    void write_scene(const std::string& name, double distance)
    {
        folder_.write(name, fmt::format(R"({{"frames": 21, "geometries": {{"ball": {{"mesh": {{"generate":
            {{"kind": "sphere", "radius": 0.5, "triangles": 512}}}}}}}},
            "bodies": [{{"name": "one", "geometry": "ball"}}, {{"name": "other", "geometry": "ball",
            "position": [{}, 0.1, 0.05], "motion": {{"drift": {{"velocity": [-0.01, 0, 0]}}}}}}]}})",
                                        distance));
    }

    Outcome render(const std::string& scene, std::vector<std::string> more)
    {
        std::vector<std::string> arguments{"render", scene, "--size", "64x48", "--depth", "4"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    }

    /// Renders to x.png; must succeed.
    Decoded picture(const std::string& scene, std::vector<std::string> more = {})
    {
        more.insert(more.end(), {"--out", "x.png"});
        const Outcome outcome = render(scene, more);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return decode(folder_.read("x.png"));
    }
};

TEST_F(Render, WritesAPictureOfTheSizeAskedFor)
{
    const Decoded image = picture("touching.json");
    EXPECT_EQ(image.width, 64);
    EXPECT_EQ(image.height, 48);
    EXPECT_GT(image.count(is_drawn), 300);
    EXPECT_FALSE(is_drawn(image.at(0, 0))) << "the whole content fits";
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"apart.json", "touching.json", "x.png"}));
}

TEST_F(Render, OnlyCollisionsAreRed)
{
    EXPECT_GT(picture("touching.json", {"--show", "spheres", "--whole", "--level", "4"}).count(is_red), 10);
    EXPECT_EQ(picture("apart.json", {"--show", "spheres", "--whole", "--level", "4"}).count(is_red), 0);
    EXPECT_EQ(picture("touching.json", {"--show", "meshes"}).count(is_red), 0);
    // Touching spheres are not a collision if deeper spheres separated the bodies.
    write_scene("near.json", 1.5);
    EXPECT_EQ(picture("near.json", {"--show", "spheres", "--whole", "--level", "1"}).count(is_red), 0);
}

TEST_F(Render, TrianglesThatMeetAreRedUnderExactPredicates)
{
    write_scene("through.json", 0.9);
    for (const char* what : {"meshes", "both", "spheres"}) {
        const std::vector<std::string> exact{"--exact", "predicates", "--show", what};
        EXPECT_GT(picture("through.json", exact).count(is_red), 10) << what;
        EXPECT_EQ(picture("apart.json", exact).count(is_red), 0) << what;
        // Their spheres touch, and their triangles do not.
        EXPECT_EQ(picture("touching.json", {"--exact", "predicates", "--show", what, "--frame", "0"}).count(is_red), 0);
    }
    EXPECT_NE(render("through.json", {"--exact", "predicates", "--out", "x.png"}).out.find("triangles that meet"),
              std::string::npos);
    EXPECT_GT(picture("through.json", {"--exact", "predicates", "--body", "one"}).count(is_red), 0)
        << "also where they meet a hidden body";
}

TEST_F(Render, RedThatIsHiddenIsMentioned)
{
    write_scene("through.json", 0.9);
    const auto text = [&](const char* eye) {
        return render("through.json",
                      {"--exact", "predicates", "--eye", eye, "--look-at", "0.45 0 0", "--out", "x.png"})
            .out;
    };
    EXPECT_NE(text("-6 0 0").find("all of the red is hidden"), std::string::npos) << "behind the first ball";
    EXPECT_EQ(text("0.45 -6 0").find("hidden"), std::string::npos);
}

TEST_F(Render, TheLiveTreesShowTheDecidingSpheres)
{
    const Outcome touching = render("touching.json", {"--out", "x.png"});
    EXPECT_EQ(touching.out.find(" 0 of them red"), std::string::npos) << touching.out;
    EXPECT_EQ(render("apart.json", {"--out", "x.png"}).out, "x.png: 0 spheres, 0 of them red\n")
        << "no test has reached any tree";
    for (const std::vector<std::string>& eye : std::vector<std::vector<std::string>>{{}, {"--eye", "0 -5 0"}}) {
        std::vector<std::string> nothing{"--show", "spheres"};
        nothing.insert(nothing.end(), eye.begin(), eye.end());
        EXPECT_EQ(picture("apart.json", nothing).count(is_drawn), 0);
    }
}

TEST_F(Render, SpheresTouchBodiesThatAreNotShown)
{
    const std::vector<std::string> spheres{"--show", "spheres", "--whole", "--level", "4", "--body", "one"};
    EXPECT_GT(picture("touching.json", spheres).count(is_red), 0);
}

TEST_F(Render, BodiesWithoutNamesAreShownByNumberAndListed)
{
    folder_.write("unnamed.json", R"({"geometries": {"box": {"shape": {"kind": "box", "half": [0.5, 0.5, 0.5]}}},
        "bodies": [{"geometry": "box"}, {"geometry": "box", "position": [3, 0, 0]}]})");
    EXPECT_GT(picture("unnamed.json", {"--body", "body 1"}).count(is_drawn), 0);
    expect_error(64, {"render", "unnamed.json", "--body", "body 2", "--out", "x.png"}, {"body 0, body 1"});
}

TEST_F(Render, LevelsAndFramesStandSideBySide)
{
    const Decoded levels = picture("touching.json", {"--show", "spheres", "--whole", "--level", "0,4"});
    EXPECT_EQ(levels.width, 64);
    EXPECT_GT(levels.count(is_drawn, 0, 32), levels.count(is_drawn, 32, 64)) << "level 0 is larger";
    const Decoded frames = picture("apart.json", {"--frame", "0,10,20"});
    EXPECT_EQ(run({"render", "--frame", "0", "apart.json", "--level", "1", "--size", "64x48", "--out", "x.png"}).code,
              0)
        << "the lists end with the word";
    for (int k = 0; k < 3; ++k) EXPECT_GT(frames.count(is_drawn, 21 * k, 21 * (k + 1)), 5);
    const Decoded one = picture("touching.json", {"--eye", "0 -9 0", "--look-at", "0 0 0", "--frame", "20"});
    EXPECT_TRUE(is_drawn(one.at(32, 24))) << "the body at the origin";
}

TEST_F(Render, EverySoManyFramesMakesASequence)
{
    const Outcome outcome = render("apart.json", {"--every", "10", "--out", "film.png"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"apart.json", "film-0000.png", "film-0010.png", "film-0020.png",
                                                        "touching.json"}));
    EXPECT_NE(folder_.read("film-0000.png"), folder_.read("film-0020.png"));
}

TEST_F(Render, StandardOutputTakesThePictureAlone)
{
    const Outcome outcome = render("touching.json", {"--out", "-"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(decode(outcome.out).width, 64);
    EXPECT_EQ(picture("touching.json").pixels, decode(outcome.out).pixels) << "and the same picture";
}

TEST_F(Render, EveryKindOfGeometryIsDrawn)
{
    folder_.write("kinds.json", R"({"geometries": {"pill": {"shape": {"kind": "capsule", "radius": 0.3, "length": 1}},
        "house": {"octomap": {"building": {"rooms": 1, "resolution": 0.25, "seed": 7}}}},
        "bodies": [{"name": "pill", "geometry": "pill"}, {"name": "house", "geometry": "house"}]})");
    for (const char* body : {"pill", "house"}) EXPECT_GT(picture("kinds.json", {"--body", body}).count(is_drawn), 200);
}

TEST_F(Render, WhatHasNoSpheresIsDrawnWithoutThem)
{
    folder_.write(
        "ground.json",
        R"({"geometries": {"hills": {"terrain": {"hills": {"cells": 8, "spacing": 1, "height": 1, "seed": 3}}},
        "floor": {"shape": {"kind": "half_space"}}, "ball": {"shape": {"kind": "sphere", "radius": 1}}},
        "bodies": [{"geometry": "hills"}, {"geometry": "floor"}, {"geometry": "ball"}]})");
    EXPECT_GT(picture("ground.json", {"--whole", "--level", "2"}).count(is_drawn), 100);
    EXPECT_GT(picture("ground.json", {"--whole", "--level", "2", "--show", "spheres"}).count(is_drawn), 20);
}

TEST_F(Render, RaysSeeWhatTrianglesShow)
{
    folder_.write(
        "mixed.json",
        R"({"geometries": {"hills": {"terrain": {"hills": {"cells": 30, "spacing": 0.3, "height": 1, "seed": 3}}},
        "knot": {"mesh": {"generate": {"kind": "sphere", "radius": 1, "triangles": 2000}}},
        "box": {"shape": {"kind": "box", "half": [0.5, 1, 0.25]}}},
        "bodies": [{"geometry": "hills"}, {"geometry": "knot", "position": [2, 3, 2]},
                   {"geometry": "box", "position": [6, 5, 2.5]}]})");
    const std::vector<std::string> common{"--eye", "4 -14 9", "--look-at", "4.5 4.5 1"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.end(), common.begin(), common.end());
        return picture("mixed.json", more);
    };
    const Decoded cast = with({"--rays"}), drawn = with({"--show", "meshes", "--exact", "off"});
    int different = 0, unlike = 0;
    for (int y = 0; y < cast.height; ++y)
        for (int x = 0; x < cast.width; ++x) {
            const std::uint8_t *p = cast.at(x, y), *q = drawn.at(x, y);
            different += is_drawn(p) != is_drawn(q);
            unlike += std::abs(int(p[0]) - p[2] - q[0] + q[2]) > 60; // another body's hue
        }
    EXPECT_GT(cast.count(is_drawn), 500);
    RecordProperty("different", different), RecordProperty("unlike", unlike);
    EXPECT_LT(different, 25) << "only along outlines";
    EXPECT_LT(unlike, 25);
    EXPECT_NE(render("mixed.json", {"--rays", "--out", "x.png"}).out.find("x.png: 12288 rays"), std::string::npos);
    EXPECT_LT(with({"--rays", "--body", "body 2"}).count(is_drawn), cast.count(is_drawn) / 2);
    // Several frames stand side by side; the second ball comes nearer.
    const Decoded two = picture("apart.json", {"--rays", "--frame", "0,20"});
    EXPECT_GT(two.count(is_drawn, 0, 32), 20);
    EXPECT_GT(two.count(is_drawn, 32), 20);
}

TEST_F(Render, RaysReadCookedMeshesOnDemand)
{
    folder_.write("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    ASSERT_EQ(run({"cook", "ball.obj", "-o", "ball.cooked"}).code, 0);
    folder_.write("cooked.json",
                  R"({"geometries": {"g": {"mesh": {"file": "ball.cooked"}}}, "bodies": [{"geometry": "g"}]})");
    EXPECT_GT(picture("cooked.json", {"--rays"}).count(is_drawn), 300);
}

TEST_F(Render, RefusesWhatMakesNoSense)
{
    const auto refuse = [&](std::vector<std::string> more, const std::vector<std::string>& words) {
        std::vector<std::string> arguments{"render", "apart.json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        if (std::find(more.begin(), more.end(), "--out") == more.end())
            arguments.insert(arguments.end(), {"--out", "x.png"});
        expect_error(64, arguments, words);
    };
    expect_error(64, {"render", "apart.json"}, {"--out"});
    refuse({"--out", ""}, {"--out", "empty"});
    refuse({"--frame", "21"}, {"--frame 21", "0 to 20"});
    refuse({"--frame", "-1"}, {"--frame -1"});
    refuse({"--frame", "5,3"}, {"--frame 3", "ascend"});
    refuse({"--frame", "soon"}, {"--frame"});
    refuse({"--every", "0"}, {"--every 0"});
    refuse({"--every", "5", "--frame", "1,2"}, {"--every"});
    refuse({"--every", "5", "--out", "-"}, {"--every", "standard output"});
    for (const char* size : {"640", "640x", "0x0", "64x48x2", "-64x48", "100000x48", "axb"})
        refuse({"--size", size}, {"--size", size, "16 to 4096"});
    refuse({"--size", "64x48", "--level", "0,1,2,3,4"}, {"--size 64x48", "5 pictures"});
    refuse({"--level", "7"}, {"--level 7", "0 to 6", "--depth"});
    refuse({"--level", "17", "--whole"}, {"--level 17", "0 to 16"});
    refuse({"--level", "16", "--whole"}, {"level 9 of 'ball'", "smaller --level"});
    refuse({"--whole"}, {"--whole", "--level"});
    refuse({"--rays", "--level", "2"}, {"--rays", "no spheres", "--level"});
    refuse({"--rays", "--show", "spheres"}, {"--rays", "--show spheres"});
    refuse({"--show", "nothing"}, {"nothing", "meshes, spheres or both"});
    refuse({"--body", "three"}, {"--body three", "one, other"});
    refuse({"--eye", "1 2"}, {"--eye", "x y z"});
    refuse({"--look-at", "1 2 nan"}, {"--look-at", "not finite"});
    refuse({"--eye", "1 2 3", "--look-at", "1,2,3"}, {"--eye", "same point"});
    refuse({"--depth", "0"}, {"depth"});
    refuse({"--gpu", "99"}, {"gpu", "0 to 63"});
    refuse({"--out", "./apart.json"}, {"overwrite the input"});
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"apart.json", "touching.json"}));
}

TEST_F(Render, FailuresHaveTheirExitCodesAndLeaveNothing)
{
    expect_error(71, {"render", "apart.json", "--out", "x.png", "--gpu", "63"}, {"no GPU 63", "doctor"});
    expect_error(73, {"render", "apart.json", "--out", "no/folder/x.png"}, {"no/folder"});
    expect_error(73, {"render", "apart.json", "--size", "64x48", "--quiet", "--out", "/dev/full"}, {"No space left"});
    expect_error(66, {"render", "none.json", "--out", "x.png"}, {"none.json"});
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"apart.json", "touching.json"}));
}

} // namespace
} // namespace oncollide::test
