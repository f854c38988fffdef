// The page of 'run --view', rendered if Chromium and three.js are installed.
#include "tools/page_in_browser.hpp"

namespace oncollide::test {
namespace {

bool is_within(const std::uint8_t* p)
{
    return p[0] > 150 && p[1] > 120 && p[0] > 2 * p[2];
}

using ViewInBrowser = InBrowser<View>;

TEST_F(ViewInBrowser, EveryViewShowsWhatItIsFor)
{
    write_scene("scene.json", 1.5);
    ASSERT_EQ(run({"run", "scene.json", "--exact", "predicates", "--separate", "--quiet", "--view", "x.html"}).code, 0);
    const Seen apart = look("x.html", "frame=0&theme=light"), hit = look("x.html", "frame=7&theme=light");
    EXPECT_EQ(apart.data("frame"), "0");
    EXPECT_EQ(hit.data("frame"), "7");
    EXPECT_GT(drawn(apart.picture), 8000) << "two balls";
    EXPECT_EQ(in_scene(apart.picture, is_colliding), 0);
    EXPECT_GT(in_scene(hit.picture, is_colliding), 8000);
    const Seen dark = look("x.html", "frame=7&theme=dark");
    EXPECT_LT(dark.picture.at(260, 4)[0], 80);
    EXPECT_GT(in_scene(dark.picture, is_colliding), 8000);
    for (const char* kind : {"spheres", "boxes"}) {
        const Seen trees = look("x.html", fmt::format("frame=7&pair=0,1&trees={}&level=3&theme=light", kind));
        EXPECT_GT(in_scene(trees.picture, is_blue), 1000) << kind << " of the first body";
        EXPECT_GT(in_scene(trees.picture, is_colliding), 300) << kind << " that touch";
        EXPECT_NE(trees.document.find("touch, off by"), std::string::npos);
    }
    const Seen phone = look("x.html", "frame=7&theme=light&tab=stages", "390,844");
    EXPECT_GT(phone.picture.count(is_colliding), 2000);
    EXPECT_NE(phone.document.find("Boxes of the bodies"), std::string::npos);
}

TEST_F(ViewInBrowser, TheSliderAndKeysChangeTheFrame)
{
    write_scene("scene.json", 1.5, "</script><script>document.title='owned'</script>");
    ASSERT_EQ(run({"run", "scene.json", "--exact", "off", "--quiet", "--view", "x.html"}).code, 0);
    folder_.write("y.html", folder_.read("x.html") + R"(<script>
const root = document.documentElement, slider = document.getElementById("scrub"), key = (k) => dispatchEvent(new KeyboardEvent("keydown", {key: k}));
slider.value = 6, slider.dispatchEvent(new Event("input"));
root.dataset.scrubbed = root.dataset.frame;
key("ArrowLeft"), root.dataset.left = root.dataset.frame;
key("Home"), root.dataset.home = root.dataset.frame;
key("End"), root.dataset.end = root.dataset.frame;
const canvas = document.getElementById("scene"), box = canvas.getBoundingClientRect();
for (const what of ["pointerdown", "pointerup"])
  canvas.dispatchEvent(new PointerEvent(what, {clientX: box.left + box.width / 4, clientY: box.top + box.height / 2}));
</script>)");
    const Seen seen = look("y.html", "frame=0&theme=light");
    EXPECT_EQ(seen.data("scrubbed"), "6");
    EXPECT_EQ(seen.data("left"), "5");
    EXPECT_EQ(seen.data("home"), "0");
    EXPECT_EQ(seen.data("end"), "7");
    EXPECT_NE(seen.document.find("class=\"body-link\""), std::string::npos) << "the clicked body is selected";
    EXPECT_EQ(seen.document.find("<title>owned"), std::string::npos);
    EXPECT_GT(in_scene(seen.picture, is_within), 8000) << "without an exact level they may touch";
}

TEST_F(ViewInBrowser, DetailIsLessWhileItPlaysAndReturnsAtRest)
{
    ASSERT_EQ(run({"run", "city", "--bodies", "400", "--frames", "30", "--quiet", "--view", "x.html"}).code, 0);
    folder_.write("y.html", folder_.read("x.html") + R"(<script>
const root = document.documentElement, play = () => dispatchEvent(new KeyboardEvent("keydown", {key: " "}));
play();
const wait = () => {
  if (+root.dataset.drawn < 3) return requestAnimationFrame(wait);
  for (const name of ["bodies", "triangles", "pixels"]) root.setAttribute("data-played-" + name, root.dataset[name]);
  play();
};
wait();
</script>)");
    Seen seen;
    const auto rest = [&](const char* name) { return std::stoi(seen.data(name)); };
    const auto played = [&](const char* name) { return std::stoi(seen.data(std::string("played-") + name)); };
    for (int tries = 0; tries < 3; ++tries) { // a loaded machine may not draw the page at rest in time
        seen = look("y.html", "frame=0&theme=light", "900,640", 60000);
        if (played("triangles") < rest("triangles")) break;
    }
    EXPECT_GT(rest("frame"), 0);
    EXPECT_GT(rest("bodies"), 300);
    EXPECT_EQ(played("bodies"), rest("bodies")) << "nothing disappears";
    EXPECT_LT(played("triangles"), rest("triangles") / 2);
    EXPECT_LT(played("pixels"), rest("pixels") / 2 + 1);
    const Seen never = look("x.html", fmt::format("frame={}&theme=light", rest("frame")));
    EXPECT_EQ(seen.data("triangles"), never.data("triangles"));
    EXPECT_EQ(seen.data("pixels"), never.data("pixels"));
}

TEST_F(ViewInBrowser, SmallBodiesHaveTheirColoursAndHideWhatIsBehind)
{
    // A wall of 24 x 16 colliding pairs of spheres, and behind the first sphere of each pair, as seen in the page, one
    // that does not collide.
    std::string placed;
    const auto put = [&](double x, double y, double z) {
        placed += fmt::format(R"(,{{"geometry": "ball", "position": [{}, {}, {}]}})", x, y, z);
    };
    for (int row = 0; row < 16; ++row)
        for (int column = 0; column < 24; ++column) {
            const double x = 2.5 * column, z = 1.5 * row;
            put(x, 0, z), put(x + 0.9, 0, z), put(x + 1.1, 2, z - 1.24);
        }
    folder_.write("wall.json", R"({"geometries": {"ball": {"mesh": {"generate": {"kind": "sphere", "radius": 0.5,
        "triangles": 512}}}}, "bodies": [)" +
                                   placed.substr(1) + "]}");
    ASSERT_EQ(run({"run", "wall.json", "--exact", "on", "--quiet", "--view", "x.html"}).code, 0);
    folder_.write("y.html", folder_.read("x.html") + R"(<script>
for (const key of ["l", "c"]) dispatchEvent(new KeyboardEvent("keydown", {key})); // hides the marks
</script>)");
    const Seen seen = look("y.html", "theme=light");
    EXPECT_EQ(seen.data("bodies"), "1152");
    EXPECT_EQ(seen.data("triangles"), "2304") << "they are drawn as sprites";
    EXPECT_GT(in_scene(seen.picture, is_colliding), 30'000) << "24,000 if the spheres behind were drawn first";
}

TEST_F(ViewInBrowser, MeshesDeformFromFrameToFrame)
{
    folder_.write("s.json",
                  R"({"frames": 9, "geometries": {"cloth": {"mesh": {"generate": {"kind": "sheet", "size": [2, 1],
        "cells": [40, 20]}}, "deformation": {"flutter": {"edge": [-1, 0, 0], "along": [1, 0, 0], "normal": [0, 0, 1],
        "growth": 0.1, "waves": [[1, 3, 12, 0, 0]]}}}},
        "bodies": [{"geometry": "cloth"}, {"geometry": "cloth", "position": [0, 0, 3]}]})");
    ASSERT_EQ(run({"run", "s.json", "--quiet", "--view", "x.html"}).code, 0);
    folder_.write("y.html", folder_.read("x.html") + R"(<script>
const slider = document.getElementById("scrub");
const wait = () => {
  if (+document.documentElement.dataset.drawn < 3) return (slider.value = 1 - slider.value, slider.dispatchEvent(new Event("input"))), requestAnimationFrame(wait);
  slider.value = 6, slider.dispatchEvent(new Event("input"));
};
wait();
</script>)");
    const std::string camera = "&theme=light&at=0,0,1.5,3,0.1,-1,0.2";
    const auto first = look("x.html", "frame=0" + camera), sixth = look("x.html", "frame=6" + camera),
               moved = look("y.html", "frame=0" + camera, "900,640", 6000);
    EXPECT_EQ(moved.data("frame"), "6");
    const auto differ = [&](const Seen& a, const Seen& b) {
        int count = 0;
        for (int y = 60; y < 420; ++y)
            for (int x = 0; x < 520; ++x) {
                const std::uint8_t *p = a.picture.at(x, y), *q = b.picture.at(x, y);
                count += std::abs(p[0] - q[0]) + std::abs(p[1] - q[1]) + std::abs(p[2] - q[2]) > 60;
            }
        return count;
    };
    EXPECT_GT(drawn(first.picture), 5000);
    EXPECT_GT(differ(first, sixth), 3000);
    EXPECT_LT(differ(moved, sixth), 100) << "the frame is the same however it is reached";
}

TEST_F(ViewInBrowser, RegionsAndMarksOfALargeScene)
{
    ASSERT_EQ(
        run({"run", "city", "--bodies", "400", "--frames", "4", "--exact", "predicates", "--quiet", "--view", "x.html"})
            .code,
        0);
    const Seen plain = look("x.html", "frame=3&theme=light"), regions = look("x.html", "frame=3&theme=light&regions");
    EXPECT_GT(drawn(plain.picture), 5000);
    EXPECT_EQ(plain.data("frame"), "3");
    EXPECT_GT(std::stoi(plain.data("bodies")), 100);
    EXPECT_EQ(regions.data("error"), "");
}

} // namespace
} // namespace oncollide::test
