// oncollide clash: duplicates, the tolerance of touching faces, and which parts are compared.
#include "plate_with_hole.hpp"
#include "tools/command/clash/clash_fixture.hpp"
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {
namespace {

class ClashKinds : public ClashCommand {
protected:
    void write_mesh(const std::string& name, const Mesh& mesh, const Eigen::Vector3d& by = Eigen::Vector3d::Zero())
    {
        std::string text = fmt::format("OFF\n{} {} 0\n", mesh.vertices.size(), mesh.triangles.size());
        for (const Eigen::Vector3d& v : mesh.vertices)
            text += fmt::format("{} {} {}\n", v.x() + by.x(), v.y() + by.y(), v.z() + by.z());
        for (const Triangle& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
        folder_.write(name, text);
    }
    static Mesh reordered(Mesh mesh)
    {
        const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
        std::ranges::reverse(mesh.vertices), std::ranges::reverse(mesh.triangles);
        for (Triangle& t : mesh.triangles) t = {last - t[2], last - t[0], last - t[1]};
        return mesh;
    }
    std::string kind_of(const std::string& a, const std::string& b, const std::string& tolerance)
    {
        run({"clash", a, b, "--touching", "--tolerance", tolerance, "-o", "k.json"});
        const nlohmann::json report = read_json("k.json");
        return report["clashes"].empty() ? "" : report["clashes"][0]["kind"].get<std::string>();
    }
};

TEST_F(ClashKinds, ACopyAtTheSamePlaceIsADuplicate)
{
    const Mesh knot = make_torus_knot_mesh(2, 3, 50, 20, 8, 2000);
    write_mesh("a.off", knot), write_mesh("copy.off", knot), write_mesh("order.off", reordered(knot));
    write_mesh("rounded.off", knot, {1e-9, 0, 0}), write_mesh("moved.off", knot, {0.01, 0, 0});
    Mesh less = knot;
    less.vertices[7].x() += 0.2;
    write_mesh("less.off", less);
    for (const char* other : {"copy.off", "order.off", "rounded.off"})
        EXPECT_EQ(kind_of("a.off", other, "0"), "duplicate") << other;
    EXPECT_EQ(kind_of("a.off", "moved.off", "0"), "crossing");
    EXPECT_EQ(kind_of("a.off", "moved.off", "0.02"), "duplicate");
    EXPECT_EQ(kind_of("a.off", "less.off", "0"), "crossing");
    // An open copy only touches, which is no clash; a duplicate is.
    folder_.write("sheet.off", "OFF\n4 2 0\n-5 -5 5\n5 -5 5\n5 5 5\n-5 5 5\n3 0 1 2\n3 0 2 3\n");
    folder_.write("sheet2.off", "OFF\n4 2 0\n5 5 5\n-5 5 5\n-5 -5 5\n5 -5 5\n3 1 2 0\n3 2 3 0\n");
    folder_.write("diagonal.off", "OFF\n4 2 0\n-5 -5 5\n5 -5 5\n5 5 5\n-5 5 5\n3 0 1 3\n3 1 2 3\n");
    const Outcome outcome = run({"clash", "sheet.off", "sheet2.off", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 1) << outcome.out;
    EXPECT_NE(outcome.out.find("1 clash: 1 duplicate"), std::string::npos) << outcome.out;
    EXPECT_EQ(pairs("r.json"), (Pairs{"sheet sheet2 duplicate new"}));
    EXPECT_EQ(kind_of("sheet.off", "diagonal.off", "0"), "touching") << "other triangles";
}

TEST_F(ClashKinds, FacesThatRoundingPartsOrOverlapsTouchWithinTheTolerance)
{
    constexpr double off = 1.3e-6;
    write_box("a.off", {0, 0, 0}, {10, 10, 10});
    write_box("gap.off", {10 + off, 0, 0}, {20, 10, 10});
    write_box("overlap.off", {10 - off, 0, 0}, {20, 10, 10});
    // Two prisms with a common slanted face, which one of them crosses by as much.
    const auto write_prism = [&](const std::string& name, double way, double by) {
        std::string text = "OFF\n6 8 0\n";
        for (const double y : {0.0, way * 10})
            text += fmt::format("{} {} 0\n{} {} 7\n{} {} {}\n", 10 + by, y, by, y, by + (way > 0 ? 0 : 10), y,
                                way > 0 ? 0 : 7);
        folder_.write(name, text + "3 0 1 2\n3 3 5 4\n3 0 3 1\n3 1 3 4\n3 1 4 2\n3 2 4 5\n3 2 5 0\n3 0 5 3\n");
    };
    write_prism("low.off", 1, 0), write_prism("high.off", -1, 0);
    // Open sheets have no inside; moving one of them parts them.
    folder_.write("sheet.off", "OFF\n4 2 0\n-5 -5 0\n5 -5 0\n5 5 0\n-5 5 0\n3 0 1 2\n3 0 2 3\n");
    folder_.write("upright.off", fmt::format("OFF\n4 2 0\n0 -1 {0}\n0 1 {0}\n0 1 4\n0 -1 4\n3 0 1 2\n3 0 2 3\n", -off));
    for (const auto& [other, without] : {std::pair("gap.off", "near"), std::pair("overlap.off", "crossing")}) {
        run({"clash", "a.off", other, "--clearance", "1", "--tolerance", "0", "-o", "r.json"});
        EXPECT_EQ(read_json("r.json")["clashes"][0]["kind"], without);
        EXPECT_EQ(run({"clash", "a.off", other}).code, 0) << "by default the tolerance is 2^-19 of 20 mm";
        for (const char* clearance : {"0", "1"}) {
            const Outcome outcome =
                run({"clash", "a.off", other, "--clearance", clearance, "--tolerance", "1e-5", "-o", "r.json"});
            EXPECT_EQ(outcome.code, 0) << outcome.out;
            EXPECT_NE(outcome.out.find(std::string_view(without) == "near"
                                           ? "1 pair touches: 1 with a gap within"
                                           : "1 pair touches: 1 with an overlap within the tolerance"),
                      std::string::npos)
                << outcome.out;
            EXPECT_EQ(read_json("r.json")["clashes"][0]["status"], "contact");
        }
        EXPECT_EQ(kind_of("a.off", other, "1e-5"), "touching");
        EXPECT_EQ(kind_of("a.off", other, "1e-6"), std::string_view(without) == "near" ? "" : "crossing");
    }
    EXPECT_EQ(kind_of("sheet.off", "upright.off", "0"), "crossing");
    EXPECT_EQ(kind_of("sheet.off", "upright.off", "1e-5"), "touching");
    // A gap of 0.5 stays near.
    write_box("far.off", {10.5, 0, 0}, {20, 10, 10});
    run({"clash", "a.off", "far.off", "--clearance", "1", "--tolerance", "1e-5", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json"), (Pairs{"a far near new"}));
    EXPECT_EQ(run({"clash", "a.off", "far.off", "--clearance", "0.1", "--tolerance", "0.2"}).out.find("far"),
              std::string::npos);
    // The distance of faces that are apart is reported.
    run({"clash", "a.off", "gap.off", "--touching", "--tolerance", "1e-5", "-o", "r.json"});
    EXPECT_NEAR(read_json("r.json")["clashes"][0]["distance"]["upper"].get<double>(), off, 1e-9);
}

TEST_F(ClashKinds, AWindowInItsOpeningTouchesAndPartsAreMended)
{
    // Each triangle has vertices of its own, up to twice `jitter` apart.
    const auto write_frame = [&](const std::string& name, double low, double high, double hole_low, double hole_high,
                                 double thick, double jitter) {
        const Mesh plate =
            plate_with_hole({low, low, 0}, {high, high, thick}, {hole_low, hole_low, 0}, {hole_high, hole_high, 0});
        std::string text = fmt::format("OFF\n{} {} 0\n", 3 * plate.triangles.size(), plate.triangles.size()), faces;
        for (std::uint32_t i = 0; i < plate.triangles.size(); ++i) {
            for (const int k : {0, 1, 2}) {
                const Eigen::Vector3d v = corners_of(plate, i)[std::size_t(k)];
                text += fmt::format("{} {} {}\n", v.x() + jitter * k, v.y(), v.z());
            }
            faces += fmt::format("3 {} {} {}\n", 3 * i, 3 * i + 1, 3 * i + 2);
        }
        folder_.write(name, text + faces);
    };
    write_frame("wall.off", 0, 3000, 1000, 2000, 200, 0);
    write_frame("window.off", 1000 - 1e-5, 2000 + 1e-5, 1050, 1950, 100, 2e-5);
    Outcome outcome = run({"clash", "wall.off", "window.off", "-o", "r.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.out;
    EXPECT_NE(outcome.out.find("1 pair touches: 1 with an overlap within the tolerance"), std::string::npos)
        << outcome.out;
    EXPECT_NE(outcome.out.find("1 part was mended ('window': "), std::string::npos) << outcome.out;
    const nlohmann::json report = read_json("r.json");
    EXPECT_EQ(report["mended"][0]["name"], "window");
    EXPECT_GT(report["mended"][0]["welded"], 0);
    EXPECT_EQ(report["open"], nlohmann::json::array());
    EXPECT_NEAR(report["tolerance"].get<double>(), 3000 * 0x1p-19, 1e-12);
    EXPECT_LE(report["clashes"][0]["ball"]["diameter"]["upper"], report["tolerance"]);
    outcome = run({"clash", "wall.off", "window.off", "--touching", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json"), (Pairs{"wall window touching new"})) << outcome.out;
    // Taken as they are, the window is open and crosses the wall.
    run({"clash", "wall.off", "window.off", "--tolerance", "0", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json"), (Pairs{"wall window crossing new"}));
    EXPECT_EQ(read_json("r.json")["open"], nlohmann::json{"window"});
    // An overlap that is worth a word stays.
    write_frame("large.off", 999, 2001, 1050, 1950, 100, 0);
    run({"clash", "wall.off", "large.off", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json"), (Pairs{"wall large crossing new"}));
    EXPECT_NEAR(read_json("r.json")["clashes"][0]["ball"]["diameter"]["lower"].get<double>(), 1.1, 0.11);
}

TEST_F(ClashKinds, OnlySetAAgainstSetBIsCompared)
{
    Outcome outcome = clash({"--clearance", "1", "--touching", "--set-a", "a", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json"), (Pairs{"a b crossing new", "a c touching new", "a d near new"})) << outcome.out;
    EXPECT_EQ(outcome.err, "");
    clash({"--clearance", "1", "--set-a", "a", "--set-a", "e", "--set-b", "f", "--set-b", "b", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json"), (Pairs{"e b enclosed new", "a b crossing new"})) << "the part of set A comes first";
    clash({"--set-a", "?", "--set-b", "?", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json").size(), 3u) << "parts of both sets are compared with each other";
    clash({"--set-a", "a.off", "--set-b", "?", "--group", "c", "--group", "b", "-o", "r.json"});
    EXPECT_EQ(read_json("r.json")["settings"], (nlohmann::json{{"touching", false},
                                                               {"group", {"c", "b"}},
                                                               {"set_a", {"a.off"}},
                                                               {"set_b", {"?"}},
                                                               {"tolerance", "precision of the files"}}));
    EXPECT_TRUE(pairs("r.json").contains("a b crossing new")) << "a path matches, too";
    for (const char* option : {"--set-a", "--set-b"})
        expect_error(64, {"clash", "a.off", "b.off", "--set-a", "a", "--set-b", "b", option, "robot*"},
                     {fmt::format("{} 'robot*': matches no part; the path of the first part is 'a.off'", option)});
    outcome = clash({"--group", "bolt", "--group", "node", "--group", "a", "--group", "?"});
    EXPECT_NE(outcome.err.find("warning: --group 'bolt' matches no part"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("warning: --group node: no part is below a node of an assembly"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(outcome.err.find("'a'"), std::string::npos) << "it is not the first to match, but it matches";
    expect_error(64, {"clash", "a.off", "b.off", "--set-b", "b"}, {"--set-b: needs --set-a"});
}

TEST_F(ClashKinds, AnEmptyComparisonIsAnError)
{
    small_assembly();
    const auto refused = [&](std::vector<std::string> more, const std::vector<std::string>& words) {
        more.insert(more.begin(), {"clash", "a.off", "b.off", "--units", "m"});
        expect_error(64, more, words);
    };
    refused({"--set-a", "*"}, {"--set-a *", "matches all 2 parts", "give --set-b"});
    refused({"--set-a", "robot*"}, {"--set-a robot*", "matches none of 2 parts"});
    refused({"--set-a", "a", "--set-b", "cell*"}, {"--set-b cell*", "matches none of 2 parts"});
    refused({"--set-a", "a", "--set-b", "a"}, {"--set-a and --set-b", "the same one of 2 parts"});
    refused({"--group", "*"}, {"--group", "no two of 2 parts", "of one group"});
    refused({"--set-a", "a", "--set-b", "b", "--group", "?"}, {"--group", "no two of 2 parts"});
    for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{{"--set-a", "*", "--set-b", "*"},
                                                                                      {"--set-a", "a", "--set-b", "?"},
                                                                                      {"--group", "a"},
                                                                                      {"--group", "file"}}) {
        std::vector<std::string> words{"clash", "a.off", "b.off", "--units", "m"};
        words.insert(words.end(), more.begin(), more.end());
        EXPECT_EQ(run(words).code, 1) << more[1] << ": the parts cross";
    }
}

TEST_F(ClashKinds, AnObjFileAloneIsDividedIntoItsObjects)
{
    // A box of quads between `low` and `high` along x, with corners counted backwards.
    const auto box = [](double low, double high) {
        std::string text;
        for (const double x : {low, high})
            for (const char* yz : {"0 0", "1 0", "1 1", "0 1"}) text += fmt::format("v {} {}\n", x, yz);
        return text + "f -8 -5 -6 -7\nf -4 -3 -2 -1\nf -8 -7 -3 -4\nf -7 -6 -2 -3\nf -6 -5 -1 -2\nf -5 -8 -4 -1\n";
    };
    folder_.write("one.obj", "o left arm\ng any\n" + box(0, 1) + "o right\n" + box(0.5, 2) + "o far\n" + box(5, 6) +
                                 "g more\no left arm\n" + box(7, 8) + "o empty\n");
    EXPECT_EQ(run({"clash", "one.obj", "-o", "r.json"}).code, 1);
    EXPECT_EQ(pairs("r.json"), (Pairs{"left arm right crossing new"}));
    EXPECT_EQ(read_json("r.json")["parts"], 3);
    EXPECT_EQ(read_json("r.json")["open"], nlohmann::json::array());
    EXPECT_EQ(read_json("r.json")["clashes"][0]["b"]["path"], "one.obj:right");
    folder_.write("groups.obj", box(0, 1) + "g b\n" + box(0.5, 2));
    EXPECT_EQ(run({"clash", "groups.obj", "-o", "r.json"}).code, 1);
    EXPECT_EQ(pairs("r.json"), (Pairs{"groups b crossing new"}));
    // Beside other files it is one part, as any file.
    folder_.write("two.obj", box(1.5, 3));
    run({"clash", "one.obj", "two.obj", "-o", "r.json"});
    EXPECT_EQ(pairs("r.json"), (Pairs{"one two crossing new"}));
    expect_error(65, {"clash", "two.obj"}, {"only one part ('two')", "an OBJ file of several objects"});
}

} // namespace
} // namespace oncollide::test
