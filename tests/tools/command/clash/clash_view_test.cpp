// The page of 'clash --view', in Chromium where it is installed.
#include <oncollide/samples/generators.hpp>

#include "tools/command/clash/clash_fixture.hpp"
#include "tools/page_in_browser.hpp"

namespace oncollide::test {
namespace {

/// Yellow, as the second part is drawn.
bool is_yellow(const std::uint8_t* p)
{
    return p[0] > 150 && p[1] > 110 && p[2] + 40 < p[1];
}

class ClashFiles : public ClashCommand {
protected:
    /// Writes v.html and r.html of these files.
    void write_view(const std::vector<std::string>& files)
    {
        files_ = files;
        EXPECT_EQ(clash({"--quiet", "--view", "v.html", "-o", "r.json"}).code, 1);
        report_ = read_json("r.json");
    }
    std::string id(std::size_t number) { return report_["clashes"][number]["id"]; }

    nlohmann::json report_;
};

using ClashViewInBrowser = InBrowser<ClashFiles>;

TEST_F(ClashViewInBrowser, AClashIsSeenFromNearWithItsCommonPartInRed)
{
    write_box("left.off", {0, 0, 0}, {100, 100, 100}), write_box("right.off", {95, 20, 20}, {200, 80, 80});
    write_box("far.off", {50'000, 0, 0}, {50'100, 100, 100});
    write_view({"left.off", "right.off", "far.off"});
    const Seen all = look("v.html", "theme=light");
    EXPECT_EQ(all.data("parts"), "3");
    EXPECT_EQ(all.data("clash"), "");
    EXPECT_EQ(all.data("red"), "0");
    EXPECT_LT(in_scene(all.picture, is_colliding), 1000) << "a mark";
    EXPECT_NE(all.document.find("3 parts, 1 clash<"), std::string::npos);
    const Seen near = look("v.html", "theme=light&clash=" + id(0)),
               alone = look("v.html", "theme=dark&isolate&clash=" + id(0));
    for (const Seen* seen : {&near, &alone}) {
        EXPECT_EQ(seen->data("clash"), id(0));
        EXPECT_GE(std::stoi(seen->data("red")), 12) << "a box";
        EXPECT_GT(in_scene(seen->picture, is_colliding), 2000);
    }
    EXPECT_GT(in_scene(near.picture, is_blue), 5000);
    EXPECT_GT(in_scene(near.picture, is_yellow), 5000);
    EXPECT_EQ(near.data("parts"), "3");
    EXPECT_EQ(alone.data("parts"), "2");
    EXPECT_LT(alone.picture.at(260, 4)[0], 80) << "dark";
    const Seen part = look("v.html", "part=2");
    EXPECT_NE(part.document.find("0 of 1"), std::string::npos) << "the list of its clashes";
}

TEST_F(ClashViewInBrowser, RowsKeysAndTheSectionPlaneWork)
{
    // Two clashes, the larger one first.
    write_box("a.off", {0, 0, 0}, {10, 10, 10}), write_box("b.off", {8, 2, 2}, {20, 8, 8}),
        write_box("left.off", {-9, 3, 3}, {1, 7, 7});
    write_view({"a.off", "b.off", "left.off"});
    std::string page = folder_.read("v.html");
    page.insert(page.rfind("</body>"), R"(<script>
const seen = [], root = document.documentElement, $ = (id) => document.getElementById(id);
const note = (words) => seen.push(words + " " + [root.dataset.clash, root.dataset.parts, root.dataset.hidden, root.dataset.section, $("rows").childElementCount].join(" "));
const press = (key, shiftKey) => (dispatchEvent(new KeyboardEvent("keydown", {key, shiftKey})), note(key));
$("row1").click(), note("row");
for (const key of ["n", "n", "p", "h"]) press(key);
press("H", true), press("i"), press("Escape"), press("z"), press("z");
$("search").value = "left", $("search").dispatchEvent(new Event("input")), note("search");
$("search").value = "", $("search").dispatchEvent(new Event("input")), press("n"), press("s");
root.dataset.seen = seen.join("; ");
</script>
)");
    folder_.write("w.html", page);
    const Seen cut = look("w.html", "theme=light"), whole = look("v.html", "theme=light&clash=" + id(0));
    const std::string first = id(0), second = id(1);
    EXPECT_EQ(cut.data("seen"),
              fmt::format("row {1} 3 0  2; n {0} 3 0  2; n {1} 3 0  2; p {0} 3 0  2; h {0} 2 1  2; H {0} 3 0  2; "
                          "i {0} 2 0  2; Escape  3 0  2; z  3 0 z 2; z  3 0  2; search  3 0  1; n {0} 3 0  2; "
                          "s {0} 3 0 y 2",
                          first, second));
    EXPECT_LT(drawn(cut.picture), drawn(whole.picture)) << "nothing is drawn before the plane";
}

/// The page's own time from the beginning of its loading to its first picture.
TEST_F(ClashViewInBrowser, AThousandPartsOpenSoon)
{
    // A grid of 10 x 10 x 10 tori; each crosses the next one along x.
    const Mesh torus = make_torus_mesh(1, 0.4, 600);
    std::filesystem::create_directory(folder_ / "parts");
    for (int k = 0; k < 1000; ++k) {
        std::string text = fmt::format("OFF\n{} {} 0\n", torus.vertices.size(), torus.triangles.size());
        for (const Eigen::Vector3d& v : torus.vertices)
            text += fmt::format("{} {} {}\n", v.x() + 1.9 * (k % 10), v.y() + 3 * (k / 10 % 10), v.z() + 3 * (k / 100));
        for (const Triangle& t : torus.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
        folder_.write(fmt::format("parts/p{}.off", k), text);
    }
    write_view({"parts"});
    EXPECT_EQ(report_["clashes"].size(), 900);
    const Seen seen = look("v.html", "theme=light", "900,640", 6000);
    EXPECT_EQ(seen.data("parts"), "1000");
    EXPECT_NE(seen.document.find("900, the worst first"), std::string::npos);
    EXPECT_NE(seen.document.find("id=\"row299\""), std::string::npos);
    EXPECT_GT(drawn(seen.picture), 2000);
    RecordProperty("opened_ms", seen.data("opened"));
    EXPECT_LT(std::stoi(seen.data("opened")), 20'000) << "2 s on a quiet machine";
}

TEST_F(ClashFiles, ThePageKeepsItsLimitAndSaysSo)
{
    std::vector<std::string> files;
    for (int k = 0; k < 60; ++k) {
        files.push_back(fmt::format("p{}.off", k));
        write_box(files.back(), {9. * k, 0, 0}, {9. * k + 10, 10, 10});
    }
    files_ = files;
    std::filesystem::create_directories(folder_ / "lib/examples/js/controls");
    folder_.write("lib/examples/js/controls/OrbitControls.js", "/* three */");
    folder_.write("lib/three.min.js", "/*" + std::string(1'850'000, ' ') + "*/");
    Surroundings around;
    around.environment = {{"ONCOLLIDE_THREE", (folder_.path() / "lib").string()}};
    const auto view = [&](const std::string& limit) {
        std::vector<std::string> arguments{"clash", "--view", "v.html", "--view-limit", limit};
        arguments.insert(arguments.end(), files_.begin(), files_.end());
        return run(arguments, around);
    };
    const Outcome small = view("2"), large = view("40");
    EXPECT_EQ(small.code, 64);
    EXPECT_NE(small.err.find("--view-limit: a page of 60 parts needs at least 2."), std::string::npos) << small.err;
    EXPECT_EQ(large.code, 1);
    EXPECT_NE(large.err.find("60 parts, 59 clashes\n"), std::string::npos) << large.err;
    EXPECT_LT(std::filesystem::file_size(folder_ / "v.html"), 3'000'000);
}

} // namespace
} // namespace oncollide::test
