#include <cmath>
#include <ctime>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "load_with_samples.hpp"
#include "scenes/same_scene.hpp"
#include "scenes/test_files.hpp"
#include <oncollide/base/numbers/random.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {
namespace {

using Eigen::Vector3d;
using test::expect_error;

class SceneFile : public testing::Test {
protected:
    Scene load(const std::string& content) { return test::load_with_samples(folder_.write("scene.json", content)); }

    /// A scene with the geometry "ball", and one body with these members.
    Scene load_body(const std::string& members)
    {
        return load(R"({"geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}}, "bodies": [{)" + members +
                    "}]}");
    }
    Scene load_geometry(const std::string& entry)
    {
        return load(R"({"geometries": {"thing": )" + entry + R"(}, "bodies": [{"name": "a", "geometry": "thing"}]})");
    }

    template <class... Parts>
    void refuses(const std::string& content, Parts... parts)
    {
        SCOPED_TRACE(content.substr(0, 200));
        expect_error(
            ErrorKind::bad_data, [&] { load(content); }, "scene.json: ", parts...);
    }
    template <class... Parts>
    void refuses_body(const std::string& members, Parts... parts)
    {
        SCOPED_TRACE(members);
        expect_error(
            ErrorKind::bad_data, [&] { load_body(members); }, "scene.json: bodies[0]", parts...);
    }
    template <class... Parts>
    void refuses_geometry(const std::string& entry, Parts... parts)
    {
        SCOPED_TRACE(entry);
        expect_error(
            ErrorKind::bad_data, [&] { load_geometry(entry); }, "scene.json: geometries.thing", parts...);
    }

    std::string content_of(const std::string& name) const
    {
        std::ifstream in(folder_.path() / name);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    test::TemporaryFolder folder_;
};

const std::string ball = R"("name": "a", "geometry": "ball")";

// Reading valid files

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

// Refusing invalid files

TEST_F(SceneFile, NamesThePlaceAndTheValidKeysForAnUnknownKey)
{
    refuses_body(ball + R"(, "motin": {})", "bodies[0].motin: unknown key; did you mean 'motion'? valid: name, "
                                            "geometry, position, rotation, layer, mask, static, motion");
    refuses(R"({"geometries": {}, "bodies": [], "body": []})",
            "body: unknown key; valid: name, frames, geometries, bodies");
    refuses_geometry(R"({"mesh": {"fil": "a.obj"}})", "geometries.thing.mesh.fil: unknown key", "file, generate");
    refuses_geometry(R"({"meshes": {}})",
                     "geometries.thing.meshes: unknown key; did you mean 'mesh'? valid: mesh, shape, octomap");
    refuses_body(ball + R"(, "motion": {"drift": {"speed": 1}})", "bodies[0].motion.drift.speed",
                 "velocity, spin, walls");
    refuses_body(ball + R"(, "motion": {"jitter": {"step": 1, "sed": 1}})", "bodies[0].motion.jitter.sed");
    refuses_body(ball + R"(, "motion": {"fly": {}})",
                 "bodies[0].motion.fly: unknown key; valid: keys, tum, drift, jitter");
    refuses_geometry(R"({"shape": {"kind": "sphere", "radius": 1, "half": 2}})",
                     "shape.half: unknown key; valid: kind, radius");
}

TEST_F(SceneFile, KeepsAMessageOnOneLineWhateverAKeyHolds)
{
    refuses_body(ball + R"(, "two\nlines\u001b": 1)", R"(two\x0alines\x1b: unknown key)");
    refuses(R"({"geometries": {"a\rb": {"shape": {"kind": "x"}}}, "bodies": []})", R"(geometries.a\x0db)");
}

TEST_F(SceneFile, NamesWhatIsMissing)
{
    refuses(R"({"bodies": []})", "the key 'geometries' is missing");
    refuses(R"({"geometries": {}})", "the key 'bodies' is missing");
    refuses_body(R"("name": "a")", "bodies[0]: the key 'geometry' is missing");
    refuses_geometry("{}", "exactly one of: mesh, shape, octomap");
    refuses_geometry(R"({"mesh": {}})", "exactly one of: file, generate, vertices with triangles");
    refuses_geometry(R"({"mesh": {"vertices": [[0,0,0]]}})", "the key 'triangles' is missing");
    refuses_geometry(R"({"shape": {"kind": "box"}})", "the key 'half' is missing");
    refuses_geometry(R"({"shape": {"kind": "capsule", "radius": 1}})", "the key 'length' is missing");
    refuses_geometry(R"({"mesh": {"generate": {"kind": "torus", "major": 2, "minor": 1}}})",
                     "the key 'triangles' is missing");
    refuses_body(ball + R"(, "motion": {})", "exactly one of: keys, tum, drift, jitter");
    refuses_body(ball + R"(, "motion": {"tum": {"file": "a.tum"}})", "frames_per_second");
    refuses_body(ball + R"(, "motion": {"jitter": {}})", "'step' is missing");
}

TEST_F(SceneFile, NamesWhatHasTheWrongType)
{
    refuses("[]", "is an array, must be an object");
    refuses("3", "is a number, must be an object");
    refuses(R"({"geometries": [], "bodies": []})", "geometries: must be an object");
    refuses(R"({"geometries": {}, "bodies": {}})", "bodies: is an object, must be an array");
    refuses(R"({"geometries": {}, "bodies": [3]})", "bodies[0]: is a number, must be an object");
    refuses(R"({"geometries": {}, "bodies": [], "frames": "many"})", "frames: is a string, must be a whole number");
    refuses(R"({"geometries": {}, "bodies": [], "name": 3})", "name: is a number, must be a text");
    refuses_body(R"("name": null, "geometry": "ball")", "bodies[0].name: is a null");
    refuses_body(ball + R"(, "position": [1, 2])", "bodies[0].position: is [1,2], must be an array of 3 numbers");
    refuses_body(ball + R"(, "position": [1, 2, "3"])", "array of 3 numbers");
    refuses_body(ball + R"(, "rotation": [1, 0, 0])", "bodies[0].rotation: must be a quaternion");
    refuses_body(ball + R"(, "rotation": [[1, 0, 0], [0, 1, 0], [0, 1]])", "bodies[0].rotation[2]");
    refuses_body(ball + R"(, "static": 1)", "bodies[0].static: is a number, must be true or false");
    refuses_body(ball + R"(, "layer": 1.5)", "bodies[0].layer: is 1.5, must be a whole number from 0 to 4294967295");
    refuses_body(ball + R"(, "motion": {"keys": {}})", "motion.keys: is an object, must be an array");
    refuses_body(ball + R"(, "motion": {"keys": [[0, 0, 0, 0, 0, 0, 1]]})", "motion.keys[0]", "8 numbers");
    refuses_body(ball + R"(, "motion": {"drift": {"walls": [[0, 0, 0]]}})", "motion.drift.walls: must be two points");
    refuses_geometry(R"({"mesh": {"file": 3}})", "mesh.file: is a number");
    refuses_geometry(R"({"mesh": {"vertices": [[0,0,0]], "triangles": [[0,0]]}})", "triangles[0]: has 2 vertices");
}

TEST_F(SceneFile, ListsTheRightNamesForAWrongOne)
{
    refuses(R"({"geometries": {"bunny": {"shape": {"kind": "sphere", "radius": 1}}, "cow": {"shape": {"kind": "sphere",
        "radius": 1}}}, "bodies": [{"name": "a", "geometry": "bunnny"}]})",
            "bodies[0].geometry: no geometry named 'bunnny'; did you mean 'bunny'? this scene has: bunny, cow");
    refuses(R"({"geometries": {}, "bodies": [{"name": "a", "geometry": "b"}]})", "this scene has: none");
    refuses_geometry(R"({"shape": {"kind": "torus"}})", "no shape named 'torus'; valid: sphere, box, capsule");
    refuses_geometry(R"({"mesh": {"generate": {"kind": "cube"}}})", "no generator named 'cube'; valid: box, sphere");
}

TEST_F(SceneFile, RefusesNamesGivenTwice)
{
    const std::string one = R"({"shape": {"kind": "sphere", "radius": 1}})";
    refuses(R"({"geometries": {"ball": )" + one + R"(, "ball": )" + one + R"(}, "bodies": []})",
            "geometries.ball: the key 'ball' is given twice");
    refuses(R"({"geometries": {"ball": )" + one + R"(}, "bodies": [{"name": "b", "geometry": "ball"},
        {"name": "a", "geometry": "ball"}, {"name": "a", "geometry": "ball"}]})",
            "bodies[2]: body 'a': the scene has another body of this name");
    refuses(R"({"geometries": {"ball": )" + one + R"(}, "bodies": [{"name": "b", "geometry": "ball"},
        {"name": "a", "geometry": "ball", "name": "c"}]})",
            "bodies[1].geometry: the key 'name' is given twice");
}

TEST_F(SceneFile, RefusesNumbersWithoutMeaning)
{
    for (const char* frames : {"0", "-3", "1000000001", "2.5", "99999999999999999999", "-99999999999999999999"})
        refuses(fmt::format(R"({{"geometries": {{}}, "bodies": [], "frames": {}}})", frames), "frames: is ");
    refuses_geometry(R"({"shape": {"kind": "sphere", "radius": 0}})", "radius");
    refuses_geometry(R"({"shape": {"kind": "sphere", "radius": -1}})", "radius");
    refuses_geometry(R"({"shape": {"kind": "box", "half": [1, 0, 1]}})", "thing");
    refuses_geometry(R"({"shape": {"kind": "cylinder", "radius": 1, "length": -1}})", "length");
    refuses_geometry(R"({"shape": {"kind": "convex_hull", "points": [[0,0,0],[1,0,0],[0,1,0],[1,1,0]]}})", "thing");
    refuses_geometry(R"({"mesh": {"file": "a.obj", "scale": 0}})", "mesh.scale: is 0, must be above 0");
    refuses_geometry(R"({"mesh": {"file": "a.obj", "fit_diagonal": -2}})", "mesh.fit_diagonal: is -2, must be above 0");
    refuses_geometry(R"({"mesh": {"generate": {"kind": "sphere", "radius": -1, "triangles": 100}}})",
                     "generate.radius");
    refuses_geometry(R"({"mesh": {"generate": {"kind": "sphere", "radius": 1, "triangles": 1000000000}}})",
                     "generate.triangles: is 1000000000, must be a whole number from 1 to 10000000");
    refuses_geometry(R"({"mesh": {"generate": {"kind": "torus", "major": 1, "minor": 2, "triangles": 100}}})",
                     "generate: torus");
    refuses_geometry(R"({"mesh": {"generate": {"kind": "terrain", "size": 1, "height": 1, "cells": 3, "seed": -1}}})",
                     "seed");
    refuses_geometry(R"({"octomap": {"building": {"rooms": 2, "resolution": 0, "seed": 1}}})", "building.resolution");
    refuses_geometry(R"({"octomap": {"building": {"rooms": 100000, "resolution": 1, "seed": 1}}})", "building.rooms");
    refuses_body(ball + R"(, "layer": -1)", "bodies[0].layer: is -1");
    refuses_body(ball + R"(, "layer": 4294967296)", "bodies[0].layer: is 4294967296");
    refuses_body(ball + R"(, "mask": 18446744073709551615)", "bodies[0].mask: is 18446744073709551615");
    refuses_body(ball + R"(, "rotation": [0, 0, 0, 0])",
                 "bodies[0].rotation: the quaternion (0, 0, 0, 0) has length 0");
    refuses_body(ball + R"(, "rotation": [1e200, 0, 0, 1e200])", "bodies[0].rotation", "length inf");
    refuses_body(ball + R"(, "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, -1]])", "bodies[0]: body 'a'", "mirrors");
    refuses_body(ball + R"(, "rotation": [[2, 0, 0], [0, 1, 0], [0, 0, 1]])", "not rigid");
    refuses_body(ball + R"(, "motion": {"keys": []})", "no key");
    refuses_body(ball + R"(, "motion": {"keys": [[1, 0,0,0, 0,0,0,1], [1, 0,0,0, 0,0,0,1]]})", "motion.keys",
                 "key 1: time 1");
    refuses_body(ball + R"(, "motion": {"keys": [[1, 0,0,0, 0,0,0,0]]})", "motion.keys[0]", "length 0");
    refuses_body(ball + R"(, "motion": {"drift": {"walls": [[0, 0, 0], [1, -1, 1]]}})", "walls: the first point");
    refuses_body(ball + R"(, "motion": {"drift": {"velocity": [1e16, 0, 0]}})", "bodies[0]", "velocity");
    refuses_body(ball + R"(, "motion": {"jitter": {"step": -1}})", "bodies[0]", "step -1");
    refuses_body(ball + R"(, "motion": {"jitter": {"step": 1, "seed": -5}})", "jitter.seed: is -5");
    refuses_body(ball + R"(, "static": true, "motion": {"drift": {}})", "bodies[0]: body 'a': is static");
}

TEST_F(SceneFile, RefusesNumbersThatADoubleCannotHold)
{
    for (const char* number : {"1e999", "-1e999"})
        refuses(
            fmt::format(R"({{"geometries": {{}}, "bodies": [{{"name": "x"}}, {{"position": [0, {}, 0]}}]}})", number),
            "bodies[1].position[1]: ", "overflow", number);
    refuses(R"({"frames": NaN})", "line 1, column");
    refuses(R"({"frames": Infinity})", "line 1, column");
}

TEST_F(SceneFile, RefusesMeshesThatAreNotMeshes)
{
    refuses_geometry(R"({"mesh": {"vertices": [[0,0,0],[1,0,0]], "triangles": [[0,1,2]]}})",
                     "geometries.thing.mesh: thing: triangle 0 uses vertex 2, but the mesh has 2 vertices");
    refuses_geometry(R"({"mesh": {"vertices": [[0,0,0]], "triangles": []}})", "no triangle");
    refuses_geometry(R"({"mesh": {"vertices": [[0,0,0]], "triangles": [[0,0,-1]]}})", "triangles[0][2]: is -1");
    refuses_geometry(R"({"mesh": {"vertices": [[1,1,1]], "triangles": [[0,0,0]], "fit_diagonal": 1}})", "thing");
    refuses_geometry(R"({"mesh": {"file": "a.obj", "generate": {"kind": "box"}}})", "exactly one of");
    folder_.write("bad.obj", "v 0 0 0\nf 1 2 3\n");
    refuses_geometry(R"({"mesh": {"file": "bad.obj"}})", "geometries.thing.mesh.file: ", "bad.obj: ");
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

TEST_F(SceneFile, NamesAFileThatTheSceneLacks)
{
    const auto lacks = [&](auto action, const char* place, const char* name) {
        expect_error(ErrorKind::no_input, action, place, name);
    };
    lacks([&] { load_geometry(R"({"mesh": {"file": "none.obj"}})"); }, "geometries.thing.mesh.file: ", "none.obj");
    lacks([&] { load_geometry(R"({"octomap": {"file": "none.bt"}})"); }, "geometries.thing.octomap.file: ", "none.bt");
    lacks([&] { load_body(ball + R"(, "motion": {"tum": {"file": "none.tum", "frames_per_second": 1}})"); },
          "bodies[0].motion.tum: ", "none.tum");
}

TEST_F(SceneFile, GivesLineAndColumnOfASyntaxError)
{
    refuses("{\n  \"frames\": 3,\n  \"bodies\" []\n}", "not valid JSON", "line 3, column 12");
    refuses("{\"geometries\": {}, \"bodies\": [", "line 1, column 31", "unexpected end of input");
    refuses("{\"geometries\": {}, \"bodies\": []} x", "line 1");
    refuses("{\"name\": \"\xff\", \"geometries\": {}, \"bodies\": []}", "line 1, column 11");
    refuses(" \n ", "line 2");
    refuses("not json at all", "line 1");
}

TEST_F(SceneFile, RefusesFilesThatAreNoScene)
{
    refuses("", "empty");
    expect_error(
        ErrorKind::no_input, [&] { test::load_with_samples(folder_.path() / "none.json"); }, "none.json: ");
    expect_error(
        ErrorKind::no_input, [&] { test::load_with_samples(folder_.path()); }, "folder");
    for (const char* name : {"bunny.obj", "bunny.PLY", "bunny.stl", "bunny.gltf"})
        expect_error(
            ErrorKind::bad_data, [&] { test::load_with_samples(folder_.write(name, "v 0 0 0\n")); }, name,
            "is a mesh, not a scene file");
    expect_error(
        ErrorKind::bad_data, [&] { test::load_with_samples(folder_.write("map.bt", "#")); }, "map.bt", "is an OctoMap");
}

TEST_F(SceneFile, RefusesEveryTruncationOfAScene)
{
    const std::string whole =
        R"({"name": "t", "frames": 2, "geometries": {"ball": {"shape": {"kind": "sphere", "radius": 1}}},
        "bodies": [{"name": "a", "geometry": "ball", "motion": {"keys": [[0, 0,0,0, 0,0,0,1]]}}]})";
    EXPECT_NO_THROW(load(whole));
    for (std::size_t length = 1; length < whole.size(); ++length) refuses(whole.substr(0, length));
}

TEST_F(SceneFile, AnswersAnyChangedValueWithASceneOrAnErrorOfOneLine)
{
    folder_.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder_.write("walk.tum", "0 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n");
    using nlohmann::json;
    const json whole = json::parse(R"({"name": "x", "frames": 5, "geometries": {
        "file": {"mesh": {"file": "flat.obj", "scale": 2, "fit_diagonal": 3, "centre": true}},
        "list": {"mesh": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]}},
        "gear": {"mesh": {"generate": {"kind": "gear", "teeth": 5, "root_radius": 2, "tip_radius": 3, "thickness": 1,
                 "bore_radius": 1}}},
        "knot": {"mesh": {"generate": {"kind": "torus_knot", "p": 2, "q": 3, "major": 2, "minor": 1, "tube": 0.1,
                 "triangles": 100}}},
        "land": {"mesh": {"generate": {"kind": "terrain", "size": 2, "height": 3, "cells": 4, "seed": 5}}},
        "soup": {"mesh": {"generate": {"kind": "soup", "count": 4, "edge": 3, "size": 2, "seed": 1}}},
        "pins": {"mesh": {"generate": {"kind": "needles", "count": 4, "length": 3, "aspect": 9, "size": 2, "seed": 1}}},
        "hull": {"shape": {"kind": "convex_hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
        "pill": {"shape": {"kind": "capsule", "radius": 1, "length": 2}},
        "home": {"octomap": {"building": {"rooms": 1, "resolution": 1, "seed": 1}}}}, "bodies": [
        {"name": "a", "geometry": "file", "position": [1, 2, 3], "rotation": [0, 0, 0, 1], "layer": 1, "mask": 2,
         "static": true},
        {"name": "b", "geometry": "pill", "motion": {"keys": [[0, 0, 0, 0, 0, 0, 0, 1]]}},
        {"name": "c", "geometry": "pill", "motion": {"tum": {"file": "walk.tum", "frames_per_second": 9}}},
        {"name": "d", "geometry": "pill", "motion": {"jitter": {"step": 1, "seed": 1, "index": 1}}},
        {"name": "e", "geometry": "pill", "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
         "motion": {"drift": {"velocity": [1, 0, 0], "spin": [0, 0, 1], "walls": [[0, 0, 0], [1, 1, 1]]}}}]})");
    EXPECT_NO_THROW(load(whole.dump()));
    const json values = json::parse(
        R"([null, -1, 0, 1e300, 18446744073709551615, "", [], {"file": "flat.obj"}, [[1, 0, 0], [0, 1, 0]]])");
    std::vector<json::json_pointer> places{json::json_pointer("")};
    for (std::size_t i = 0; i < places.size(); ++i) // appends while it iterates
        for (const auto& [key, value] : whole[places[i]].items())
            if (whole[places[i]].is_structured()) places.push_back(places[i] / key);
    int loaded = 0;
    for (const json::json_pointer& place : places)
        for (const json& value : values) {
            json changed = whole;
            changed[place] = value;
            try {
                load(changed.dump());
                ++loaded;
            } catch (const Error& error) {
                EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
                EXPECT_NE(int(error.kind()), int(ErrorKind::internal)) << error.what();
                EXPECT_NE(int(error.kind()), int(ErrorKind::usage)) << error.what();
            }
        }
    EXPECT_GT(places.size(), 150u);
    EXPECT_GT(loaded, 50);
}

TEST_F(SceneFile, RefusesNestingBombsQuickly)
{
    refuses(std::string(1'000'000, '['), "nested deeper than 32 levels");
    std::string objects;
    for (int i = 0; i < 100'000; ++i) objects += R"({"a":)";
    refuses(objects, "nested deeper than 32 levels");
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

// Writing

Scene made_in_code()
{
    Scene scene;
    scene.name = "quotes \" and \\ and \xc3\xa9";
    scene.frames = 77;
    Mesh soup = make_soup_mesh(40, 0.7, 3, 5);
    soup.vertices[0] = {-0.0, 1.0 / 3, 5e-324};
    const GeometryId mesh = scene.add("soup", make_mesh("soup", soup.vertices, soup.triangles));
    scene.add("sphere", Sphere{0.1});
    scene.add("box", Box{{0.1, 1 / 3.0, 2e-7}});
    scene.add("capsule", Capsule{0.3, 0});
    scene.add("ellipsoid", Ellipsoid{{0.1, 0.2, 0.3}});
    scene.add("cone", Cone{0.3, 0.7});
    scene.add("half-space", HalfSpace{});
    scene.add("cylinder", Cylinder{0.3, 1e9 / 7});
    scene.add("hull", ConvexHull{{{0, 0, 0}, {1, 0.1, 0}, {0, 1 / 7.0, 0}, {0, 0, 1}, {1, 1, 1}}});
    scene.add("map", make_building_map(1, 0.25, 3));
    for (std::uint64_t i = 0; i < 60; ++i) {
        BodyInit body{.name = "body \t" + std::to_string(i), .geometry = GeometryId(i % 7), .motion = Still{}};
        Eigen::Vector4d q(u01(1, i, 0) - 0.5, u01(1, i, 1) - 0.5, u01(1, i, 2) - 0.5, u01(1, i, 3) - 0.5);
        if (i % 6 == 0) q = {0, 0, 0, i % 12 ? -1.0 : 1.0};
        body.pose.linear() = Eigen::Quaterniond(q.normalized()).toRotationMatrix();
        if (i % 5 == 0) body.pose.linear()(0, 1) += 1e-9; // a rotation that no quaternion represents exactly
        body.pose.translation() = Vector3d(u01(2, i, 0) / 3, -0.0, 1e6 * u01(2, i, 1));
        const Aabb walls{{-1, -1.1, 0}, {2, 2 / 3.0, 1e6}};
        const Eigen::Quaterniond unit(Eigen::Vector4d(q.normalized()));
        if (i % 7 == 1) body.motion = Keyed{{{0.1, {1, 2, 1 / 3.0}, unit}, {9.7, {0, -0.0, 1}, unit.conjugate()}}};
        if (i % 7 == 2) body.motion = Drift{{0.1, 1 / 9.0, -0.3}, {0, 0.1, 1 / 7.0}, walls};
        if (i % 7 == 3) body.motion = Drift{{0.1, 0, -0.3}, Vector3d::Zero(), {}};
        if (i % 7 == 4) body.motion = Jitter{1 / 3.0, 0xffffffffffffffffu, i, walls};
        if (i % 7 == 5) body.motion = Jitter{0.3, 5, i, {}};
        if (i % 7 == 6) body.is_static = true;
        body.layer = i % 4 == 0 ? 0x80000000u : 1u;
        body.mask = i % 3 == 0 ? 0u : 0xffffffffu;
        body.group = static_cast<std::uint32_t>(i % 4);
        if (i % 10 == 9) body.name.clear();
        scene.add_body(std::move(body));
    }
    scene.exclude(SceneBodyId{9}, SceneBodyId{3});
    scene.exclude(SceneBodyId{19}, SceneBodyId{29});
    scene.exclude(SceneBodyId{0}, SceneBodyId{1});
    scene.set_geometry(SceneBodyId{0}, mesh);
    return scene;
}

TEST_F(SceneFile, GivesBackASceneMadeInCodeBitForBit)
{
    Scene scene = made_in_code();
    save_scene(scene, folder_.path() / "made.json");
    Scene read = test::load_with_samples(folder_.path() / "made.json");
    test::expect_same_scene(scene, read);
    EXPECT_TRUE(read.warnings.empty());
}

TEST_F(SceneFile, WritesAQuaternionWhereItGivesTheMatrixBackAndElseTheMatrix)
{
    save_scene(made_in_code(), folder_.path() / "made.json");
    int quaternions = 0, matrices = 0;
    const auto json = nlohmann::json::parse(content_of("made.json"));
    for (const auto& body : json["bodies"])
        if (body.contains("rotation")) ++(body["rotation"].size() == 4 ? quaternions : matrices);
    EXPECT_GT(quaternions, 0);
    EXPECT_GT(matrices, 0);
}

TEST_F(SceneFile, SavesTheStartNotTheCurrentPoses)
{
    Scene scene = made_in_code(), moved = made_in_code();
    Mover().move(moved, 33);
    save_scene(scene, folder_.path() / "a.json");
    save_scene(moved, folder_.path() / "a2.json");
    Scene again = test::load_with_samples(folder_.path() / "a2.json");
    test::expect_same_scene(scene, again);
}

TEST_F(SceneFile, NamesMeshFilesRelativeToWhereItIsWritten)
{
    std::filesystem::create_directories(folder_.path() / "deep" / "er");
    folder_.write("tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    Scene scene = load_geometry(R"({"mesh": {"file": "tri.obj", "fit_diagonal": 3}})");
    save_scene(scene, folder_.path() / "deep" / "er" / "moved.json");
    EXPECT_NE(content_of("deep/er/moved.json").find("\"../../tri.obj\""), std::string::npos)
        << content_of("deep/er/moved.json");
    Scene read = test::load_with_samples(folder_.path() / "deep" / "er" / "moved.json");
    test::expect_same_scene(scene, read);

    // The pair of files may move together.
    std::filesystem::rename(folder_.path() / "deep", folder_.path() / "depth");
    Scene moved = test::load_with_samples(folder_.path() / "depth" / "er" / "moved.json");
    test::expect_same_scene(scene, moved);
}

TEST_F(SceneFile, LeavesNothingBehindWhenItCannotWrite)
{
    const Scene scene = made_in_code();
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(scene, folder_.path() / "none" / "a.json"); }, "a");
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(scene, folder_.path()); }, "folder");
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(scene, "/dev/full/a.json"); }, "a");
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
    Scene bad = made_in_code();
    bad.name = "\xff";
    expect_error(
        ErrorKind::cannot_write, [&] { save_scene(bad, folder_.path() / "a.json"); }, "UTF-8");
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(SceneFile, ReplacesAnOldFileInOneStep)
{
    folder_.write("old.json", "old");
    const Scene scene = load_body(ball);
    save_scene(scene, folder_.path() / "old.json");
    EXPECT_EQ(test::load_with_samples(folder_.path() / "old.json").size(), 1u);
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
        EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
}

} // namespace
} // namespace oncollide
