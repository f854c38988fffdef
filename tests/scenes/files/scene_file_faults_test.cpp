// Invalid scene files are refused: the message names the place and the valid values.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <oncollide/base/numbers/random.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

#include "scenes/files/scene_file_fixture.hpp"

namespace oncollide::scene_file_test {
namespace {

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

} // namespace
} // namespace oncollide::scene_file_test
