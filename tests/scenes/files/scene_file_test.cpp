#include <cmath>
#include <ctime>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "scenes/files/scene_file_fixture.hpp"
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::scene_file_test {
namespace {

TEST_F(SceneFile, LoadsTheExampleOfItsDocumentation)
{
    std::ifstream in(ONCOLLIDE_SOURCE_DIR "/docs/scene-format.md");
    const std::string page(std::istreambuf_iterator<char>(in), {});
    const std::size_t begin = page.find("```json\n") + 8;
    folder_.write("crane.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n");
    folder_.write("walk.tum", "0 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n");
    Scene scene = load(page.substr(begin, page.find("```", begin) - begin));
    EXPECT_GT(scene.size(), 4u);
    EXPECT_TRUE(scene.warnings.empty());
    save_scene(scene, folder_.path() / "copy.json");
    Scene copy = test::load_with_samples(folder_.path() / "copy.json");
    test::expect_same_scene(scene, copy);
}

TEST_F(SceneFile, FillsInDefaults)
{
    const Scene scene = load_body(ball);
    EXPECT_EQ(scene.name, "scene");
    EXPECT_EQ(scene.frames, 1);
    EXPECT_EQ(scene.poses[0].matrix(), Eigen::Matrix4d::Identity());
    EXPECT_EQ(scene.layers[0], 1u);
    EXPECT_EQ(scene.masks[0], 0xffffffffu);
    EXPECT_FALSE(scene.is_static[0]);
    EXPECT_TRUE(std::holds_alternative<Still>(scene.motions[0]));
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(load(R"({"geometries": {}, "bodies": []})").size(), 0u);
}

TEST_F(SceneFile, ReadsEveryMemberOfABody)
{
    const Scene scene =
        load_body(ball + R"(, "position": [1, 2.5, -3e2], "rotation": [0, 0, 0.6, 0.8], "layer": 4294967295,
                                   "mask": 0, "motion": {"drift": {"velocity": [1, 0, 0], "spin": [0, 0, 2],
                                   "walls": [[-1, -2, -300], [3, 4, 5]]}})");
    EXPECT_EQ(scene.poses[0].translation(), Vector3d(1, 2.5, -300));
    EXPECT_TRUE(scene.poses[0].linear().isApprox(Eigen::Quaterniond(0.8, 0, 0, 0.6).toRotationMatrix(), 1e-15));
    EXPECT_EQ(scene.layers[0], 0xffffffffu);
    EXPECT_EQ(scene.masks[0], 0u);
    const Drift& drift = std::get<Drift>(scene.motions[0]);
    EXPECT_EQ(drift.velocity, Vector3d(1, 0, 0));
    EXPECT_EQ(drift.spin, Vector3d(0, 0, 2));
    EXPECT_EQ(drift.walls.min, Vector3d(-1, -2, -300));
    EXPECT_EQ(drift.walls.max, Vector3d(3, 4, 5));
    EXPECT_TRUE(load_body(ball + R"(, "static": true)").is_static[0]);
}

TEST_F(SceneFile, KeepsGeometriesInTheOrderOfTheFile)
{
    const Scene scene = load(R"({"geometries": {"z": {"shape": {"kind": "sphere", "radius": 1}},
        "a": {"shape": {"kind": "sphere", "radius": 1}}, "m": {"shape": {"kind": "sphere", "radius": 1}}}, "bodies": []})");
    EXPECT_EQ(scene.geometries[0].name, "z");
    EXPECT_EQ(scene.geometries[1].name, "a");
    EXPECT_EQ(scene.geometries[2].name, "m");
}

TEST_F(SceneFile, PutsAKeyedBodyWhereItsKeysSayUnlessThePoseIsGiven)
{
    const std::string keys = R"(, "motion": {"keys": [[0, 1, 2, 3, 0, 0, 1, 0], [9, 2, 2, 3, 0, 0, 1, 0]]})";
    EXPECT_EQ(load_body(ball + keys).start_pose(0).translation(), Vector3d(1, 2, 3));
    EXPECT_EQ(load_body(ball + keys + R"(, "position": [7, 8, 9])").start_pose(0).translation(), Vector3d(7, 8, 9));
}

TEST_F(SceneFile, FindsFilesBesideTheSceneAndNotInTheCurrentFolder)
{
    std::filesystem::create_directory(folder_.path() / "meshes");
    folder_.write("meshes/flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 3 0 0\nf 1 2 3\nf 1 2 4\n");
    folder_.write("walk.tum", "5 1 2 3 0 0 0 1\n7 0 0 0 0 0 0 1\n");
    const Scene scene = load(R"({"geometries": {"flat": {"mesh": {"file": "meshes/flat.obj", "scale": 2}}}, "bodies":
        [{"name": "a", "geometry": "flat", "motion": {"tum": {"file": "walk.tum", "frames_per_second": 10}}}]})");
    EXPECT_EQ(bounds_of(scene.geometries[0]).max, Vector3d(6, 2, 0));
    EXPECT_EQ(std::get<Keyed>(scene.motions[0]).keys[1].time, 20);
    EXPECT_EQ(scene.start_pose(0).translation(), Vector3d(1, 2, 3));
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0], "flat: 1 triangle without area (kept)");
}

TEST_F(SceneFile, FitsAndCentresMeshesOfEverySource)
{
    folder_.write("corner.obj", "v 1 1 1\nv 2 1 1\nv 1 3 1\nv 1 1 3\nf 1 2 3\nf 1 2 4\n");
    const std::string fit = R"(, "fit_diagonal": 6, "centre": true}})";
    for (const std::string source :
         {R"("file": "corner.obj")", R"("vertices": [[1,1,1],[2,1,1],[1,3,1],[1,1,3]], "triangles": [[0,1,2],[0,1,3]])",
          R"("generate": {"kind": "box", "half": [0.5, 1, 1]})"}) {
        const Scene scene = load_geometry(R"({"mesh": {)" + source + fit);
        EXPECT_TRUE(bounds_of(scene.geometries[0]).max.isApprox(Vector3d(1, 2, 2), 1e-14)) << source;
        EXPECT_TRUE(bounds_of(scene.geometries[0]).min.isApprox(Vector3d(-1, -2, -2), 1e-14)) << source;
    }
    const Scene scaled = load_geometry(R"({"mesh": {"file": "corner.obj", "scale": 0.5}})");
    EXPECT_EQ(bounds_of(scaled.geometries[0]).max, Vector3d(1, 1.5, 1.5));
}

TEST_F(SceneFile, NormalisesQuaternionsAndWarnsWhenTheyAreFarOff)
{
    const Scene off = load_body(ball + R"(, "rotation": [0, 0, 0, 1.5])");
    EXPECT_EQ(off.poses[0].linear(), Eigen::Matrix3d::Identity());
    ASSERT_EQ(off.warnings.size(), 1u);
    EXPECT_NE(off.warnings[0].find("bodies[0].rotation: quaternion of length 1.5 normalised"), std::string::npos)
        << off.warnings[0];
    const Scene near = load_body(ball + R"(, "rotation": [0, 0, 0, 1.0000005])");
    EXPECT_EQ(near.poses[0].linear(), Eigen::Matrix3d::Identity());
    EXPECT_TRUE(near.warnings.empty());
}

TEST_F(SceneFile, SaysHowAMapIsRead)
{
    const MapCell occupied{0, 0, 0, 1}, free{3, 3, 3, 1};
    save_octomap(make_occupancy_map("map", 1, {&occupied, 1}, {&free, 1}), folder_.path() / "map.bt");
    const auto bounds = [&](const char* options) {
        return bounds_of(load_geometry(R"({"octomap": {"file": "map.bt")" + std::string(options) + "}}").geometries[0]);
    };
    EXPECT_EQ(bounds("").max, Vector3d::Constant(1));
    EXPECT_EQ(bounds(R"(, "unknown": "free")").max, Vector3d::Constant(1));
    EXPECT_EQ(bounds(R"(, "unknown": "occupied")").max, Vector3d::Constant(4));
    refuses_geometry(R"({"octomap": {"file": "map.bt", "unknown": "full"}})", "octomap.unknown: valid: free, occupied");
    refuses_geometry(R"({"octomap": {"file": "map.bt", "unknowns": "free"}})", "unknowns: unknown key");
    refuses_geometry(R"({"octomap": {"building": {"rooms": 2, "resolution": 1, "seed": 1}, "unknown": "free"}})",
                     "unknown");
    refuses_geometry(R"({"octomap": {"file": "map.bt", "occupancy_threshold": 0.7}})", "has no probabilities");
}

TEST_F(SceneFile, TakesBodiesWithoutNamesAndCallsThemByTheirNumbers)
{
    const std::string shapes = R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}}, "bodies": [)";
    const Scene scene = load(shapes + R"({"geometry": "ball"}, {"geometry": "ball", "name": ""},
                                         {"geometry": "ball", "name": "a"}]})");
    EXPECT_EQ(scene.names[0], "");
    EXPECT_EQ(scene.names[1], "");
    EXPECT_EQ(scene.names[2], "a");
    EXPECT_EQ(scene.label(SceneBodyId{1}), "body 1");
    EXPECT_EQ(scene.label(SceneBodyId{2}), "a");
    refuses(shapes + R"({"geometry": "ball"}, {"geometry": "ball", "static": true, "motion": {"drift": {}}}]})",
            "bodies[1]: body 1: is static");
}

TEST_F(SceneFile, ReadsGroupsAndExcludedPairs)
{
    const Scene scene = load(R"({"exclude": [["b", "a"], [2, "a"], [1, 2]], "bodies": [
        {"name": "a", "geometry": "ball", "group": 7}, {"name": "b", "geometry": "ball", "group": 4294967295},
        {"geometry": "ball"}], "geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}}})");
    EXPECT_TRUE(std::ranges::equal(scene.groups, std::vector<std::uint32_t>{7, 0xffffffffu, 0}));
    EXPECT_EQ(scene.excluded, (std::vector<ExcludedPair>{{0, 1}, {0, 2}, {1, 2}}));
}

TEST_F(SceneFile, RefusesGroupsAndExcludedPairsWithoutMeaning)
{
    refuses_body(ball + R"(, "group": -1)", "bodies[0].group: is -1, must be a whole number from 0 to 4294967295");
    refuses_body(ball + R"(, "group": "robot")", "bodies[0].group: is a string");
    const auto refuses_exclude = [&](const std::string& list, auto... parts) {
        refuses(R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}}, "bodies": [
            {"name": "a", "geometry": "ball"}, {"name": "b", "geometry": "ball"}], "exclude": )" +
                    list + "}",
                parts...);
    };
    refuses_exclude(R"([["a", "b"], ["a", "c"]])", "exclude[1][1]: no body named 'c'");
    refuses_exclude(R"([["a", "a"]])", "exclude[0]: ", "body 'a' with itself");
    refuses_exclude(R"([["a", 0]])", "exclude[0]: ", "body 'a' with itself");
    refuses_exclude(R"([["a", 2]])", "exclude[0][1]: is 2, must be a whole number from 0 to 1");
    refuses_exclude(R"([["", "a"]])", "exclude[0][0]: is empty");
    refuses_exclude(R"([["a"]])", "exclude[0]: has 1 bodies, must have two");
    refuses_exclude(R"([["a", null]])", "exclude[0][1]: must be the name of a body, or its number");
    refuses_exclude(R"({})", "exclude: is an object, must be an array");
    refuses(R"({"geometries": {}, "bodies": [], "exclude": [[0, 1]]})", "exclude[0][0]: the scene has no bodies");
}

TEST_F(SceneFile, RefusesEveryDamageToItsListOfBodies)
{
    // Bodies are read one by one, separately from the rest of the file.
    const std::string head = R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}}, "bodies": )";
    const std::string one = R"({"name": "a]", "geometry": "ball"})", two = R"({"geometry": "ball"})";
    EXPECT_EQ(load(head + " [ " + one + " , " + two + " ] }").size(), 2u);
    EXPECT_EQ(load(head + "[\n]}").size(), 0u);
    for (const std::string& list :
         {"[" + one + two + "]", "[" + one + ",]", "[," + one + "]", "[" + one + ",," + two + "]", "[" + one + "}",
          "[" + one, "[" + one + "]]", std::string("[}"), std::string("[,]"), "[" + one + ", {\"a]}",
          "[" + one + ":" + two + "]", "[" + one + "] []"})
        refuses(head + list + "}", "line 1, column");
    refuses(head + "[" + one + ", {\"geometry\": \"ball\", \"mask\": 01}]}", "line 1, column");
    refuses(head + "[" + one + "], \"bodies\": []}", "bodies: the key 'bodies' is given twice");
    refuses(head + "[{\"geometry\": " + std::string(31, '[') + std::string(31, ']') + "}]}", "bodies[0].geometry[0]",
            "nested deeper than 32 levels");
    refuses(head + "[{\"geometry\": " + std::string(29, '[') + std::string(29, ']') + "}]}",
            "bodies[0].geometry: is an array, must be a text");
}

TEST_F(SceneFile, SaysThatAFileIsNoJsonBeforeItSaysWhatABodyLacks)
{
    refuses(R"({"geometries": {}, "bodies": [{"geometry": "none"}, {"geometry": "none]}]})", "not valid JSON");
    refuses(R"({"geometries": {}, "bodies": [{"geometry": "none"}, {"name": "a", "name": "b"}]})",
            "bodies[1].name: the key 'name' is given twice");
}

TEST_F(SceneFile, ReadsNumbersAsTheyAreRoundedCorrectly)
{
    const auto position = [&](const std::string& numbers) -> Vector3d {
        return load_body(ball + R"(, "position": [)" + numbers + "]").poses[0].translation();
    };
    EXPECT_FALSE(std::signbit(position("-0, 0, 0").x())) << "an integer has only one zero";
    EXPECT_TRUE(std::signbit(position("-0.0, 0, 0").x()));
    EXPECT_EQ(position("18446744073709551615, 18446744073709551616, -9223372036854775809"),
              Vector3d(0x1p64, 0x1p64, -0x1p63));
    EXPECT_EQ(position("9007199254740993, -9007199254740993, 9007199254740993.0"), Vector3d(0x1p53, -0x1p53, 0x1p53));
    EXPECT_EQ(position("5e-324, 1e-400, 1E+0"), Vector3d(5e-324, 0, 1));
    for (const char* number : {"01", "1.", ".5", "+1", "1e", "1e+", "-", "0x1", "1_0", "--1"})
        refuses(fmt::format(R"({{"frames": {}, "geometries": {{}}, "bodies": []}})", number), "line 1, column");
}

TEST_F(SceneFile, DecodesTextsAndRefusesThoseThatAreNotUtf8)
{
    const auto name = [&](const std::string& text) {
        return load("{\"name\": \"" + text + "\", \"geometries\": {}, \"bodies\": []}").name;
    };
    EXPECT_EQ(name(R"(a\"\\\/\b\u00e9\ud83d\ude00)"), "a\"\\/\b\xc3\xa9\xf0\x9f\x98\x80");
    EXPECT_EQ(name("\xc3\xa9"), "\xc3\xa9");
    for (const char* text : {"\x01", "\t", "\\x", "\\u12", "\\ud83d", "\xc3", "\xed\xa0\x80", "\xf8"})
        EXPECT_THROW(name(text), Error) << text;
    EXPECT_EQ(load("\xef\xbb\xbf{\"geometries\": {}, \"bodies\": []}").size(), 0u) << "a byte-order mark";
}

/// CPU seconds of this process.
double cpu_time()
{
    return double(std::clock()) / CLOCKS_PER_SEC;
}

TEST_F(SceneFile, ReadsBodiesAndGeometriesInLinearTime)
{
    // Ten times as many used to take a hundred times as long.
    const auto time_of = [&](int bodies, int geometries) {
        std::string text = R"({"geometries": {)";
        for (int i = 0; i < geometries; ++i)
            text += fmt::format(R"({}"g{}": {{"shape": {{"kind": "sphere", "radius": 1}}}})", i ? "," : "", i);
        text += R"(}, "bodies": [)";
        for (int i = 0; i < bodies; ++i)
            text += fmt::format(R"({}{{"name": "b{}", "geometry": "g{}"}})", i ? "," : "", i, i % geometries);
        const auto path = folder_.write("many.json", text + "]}");
        const double begin = cpu_time();
        EXPECT_EQ(test::load_with_samples(path).size(), std::size_t(bodies));
        return cpu_time() - begin;
    };
    EXPECT_LT(time_of(100'000, 1), 30 * time_of(10'000, 1) + 0.05);
    EXPECT_LT(time_of(1, 100'000), 30 * time_of(1, 10'000) + 0.05);
}

} // namespace
} // namespace oncollide::scene_file_test
