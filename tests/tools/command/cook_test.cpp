// `oncollide cook`, and cooked files and their cache on the command line.
#include <fstream>

#include <sys/wait.h>

#include "tools/command_fixture.hpp"
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>
#include <oncollide/scenes/model/occupancy_map.hpp>

namespace oncollide::test {
namespace {

class Cook : public CommandLine {
protected:
    /// A wavy ground of `cells` cells per side, at z = 0.
    void write_ground(const std::string& name, int cells, double step = 0.1)
    {
        std::string text;
        for (int y = 0; y <= cells; ++y)
            for (int x = 0; x <= cells; ++x)
                text += fmt::format("v {} {} {}\n", x * step, y * step, 0.01 * ((x * 7 + y * 5) % 11));
        for (int y = 0; y < cells; ++y)
            for (int x = 0; x < cells; ++x) {
                const int v = y * (cells + 1) + x + 1;
                text +=
                    fmt::format("f {} {} {}\nf {} {} {}\n", v, v + 1, v + cells + 2, v, v + cells + 2, v + cells + 1);
            }
        folder_.write(name, text);
    }
    /// Two bodies that sink into the ground.
    void write_scene(const std::string& name, const std::string& ground)
    {
        folder_.write(name, R"({"geometries": {"ground": {"mesh": {"file": ")" + ground + R"("}},
            "ball": {"mesh": {"generate": {"kind": "sphere", "radius": 0.5, "triangles": 500}}}},
            "bodies": [{"geometry": "ground", "static": true},
            {"name": "a", "geometry": "ball", "position": [2, 2, 1], "motion": {"drift": {"velocity": [0.1, 0, -0.1]}}},
            {"name": "b", "geometry": "ball", "position": [6, 6, 0.9], "motion": {"drift": {"velocity": [0, 0.1, -0.1]}}}],
            "frames": 8})");
    }
    std::string hash_of(std::vector<std::string> arguments)
    {
        arguments.insert(arguments.begin(), "run"),
            arguments.insert(arguments.end(), {"--quiet", "--json", "result.json"});
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return nlohmann::json::parse(folder_.read("result.json"))["header"]["hash"].dump();
    }
};

TEST_F(Cook, ScenesAndChecksTakeCookedFiles)
{
    write_ground("ground.obj", 100);
    const Outcome cooked = run({"cook", "ground.obj", "-o", "ground.cooked"});
    EXPECT_EQ(cooked.code, 0) << cooked.err;
    EXPECT_NE(cooked.out.find("20000 triangles"), std::string::npos) << cooked.out;
    EXPECT_EQ(run({"cook", "--check", "ground.cooked"}).code, 0);
    write_scene("source.json", "ground.obj"), write_scene("cooked.json", "ground.cooked");
    for (const std::vector<std::string>& how :
         std::vector<std::vector<std::string>>{{"--exact", "predicates"},
                                               {"--max-error", "0.01"},
                                               {"--exact", "predicates", "--kinds"},
                                               {"--exact", "predicates", "--resident", "1M"}}) {
        std::vector<std::string> source{"source.json"}, cooked_scene{"cooked.json"};
        source.insert(source.end(), how.begin(), how.end());
        cooked_scene.insert(cooked_scene.end(), how.begin(), how.end());
        EXPECT_EQ(hash_of(source), hash_of(cooked_scene)) << how.back();
    }
    for (const char* file : {"ground.obj", "ground.cooked"}) {
        EXPECT_EQ(run({"check", file, file, "--pose-b", "0 0 0.5 0 0 0 1"}).code, 0);
        EXPECT_EQ(run({"check", file, file, "--pose-b", "0 0 0.5 0 0 0 1", "--max-error", "0.1"}).code, 0);
        EXPECT_EQ(run({"check", file, file, "--pose-b", "0.1 0 0 0 0 0 1"}).code, 1);
    }
}

TEST_F(Cook, TerrainsAndMapsAreCookedAsWhatTheyAre)
{
    std::string pgm = "P5\n200 150\n255\n";
    for (int i = 0; i < 200 * 150; ++i) pgm += char(7 * (i % 200) % 40 + 5 * (i / 200) % 30);
    folder_.write("heights.pgm", pgm);
    save_octomap(make_building_map(3, 0.1, 3), folder_ / "building.bt");
    const std::vector<std::string> grid{"--spacing", "0.1", "--vertical-scale", "0.01"};
    std::vector<std::string> heights{"cook", "heights.pgm", "-o", "heights.cooked"};
    heights.insert(heights.end(), grid.begin(), grid.end());
    EXPECT_NE(run(heights).out.find("59302 triangles in 12 chunks"), std::string::npos) << run(heights).out;
    EXPECT_NE(run({"cook", "building.bt", "-o", "building.cooked"}).out.find("nodes in"), std::string::npos);
    for (const char* file : {"heights.cooked", "building.cooked"}) EXPECT_EQ(run({"cook", "--check", file}).code, 0);

    const auto write_pair = [&](const std::string& name, const std::string& terrain, const std::string& map) {
        folder_.write(name, R"({"geometries": {"ground": {"terrain": )" + terrain +
                                R"(}, "rooms": {"octomap": {"file": ")" + map + R"("}},
            "ball": {"mesh": {"generate": {"kind": "sphere", "radius": 0.5, "triangles": 500}}}},
            "bodies": [{"geometry": "ground", "static": true}, {"geometry": "rooms", "static": true, "position": [4, 4, 0.2]},
            {"name": "a", "geometry": "ball", "position": [2, 2, 1], "motion": {"drift": {"velocity": [0.4, 0.1, -0.1]}}},
            {"name": "b", "geometry": "ball", "position": [6, 6, 2], "motion": {"drift": {"velocity": [0, 0.1, -0.1]}}}],
            "frames": 8})");
    };
    write_pair("source.json", R"({"file": "heights.pgm", "spacing": 0.1, "vertical_scale": 0.01})", "building.bt");
    write_pair("cooked.json", R"({"file": "heights.cooked"})", "building.cooked");
    for (const std::vector<std::string>& how : std::vector<std::vector<std::string>>{
             {"--exact", "on"}, {"--max-error", "0.01", "--resident", "1M"}, {"--depth", "4"}, {"--exact", "fcl"}}) {
        std::vector<std::string> source{"source.json"}, cooked{"cooked.json"};
        source.insert(source.end(), how.begin(), how.end()), cooked.insert(cooked.end(), how.begin(), how.end());
        EXPECT_EQ(hash_of(source), hash_of(cooked)) << how[0];
    }
    EXPECT_EQ(run({"check", "building.cooked", "heights.cooked", "--pose-b", "2 2 0.5 0 0 0 1"}).code, 1);
    EXPECT_EQ(run({"check", "building.cooked", "heights.cooked", "--pose-b", "0 0 50 0 0 0 1"}).code, 0);

    // Unreadable data affects only the pairs that need it.
    std::string bytes = folder_.read("heights.cooked");
    for (std::size_t at = bytes.size() / 2; at < bytes.size(); at += 1000) bytes[at] ^= 1;
    folder_.write("damaged.cooked", bytes);
    write_pair("damaged.json", R"({"file": "damaged.cooked"})", "building.cooked");
    const Outcome damaged = run({"run", "damaged.json", "--exact", "on", "--quiet"});
    EXPECT_EQ(damaged.code, 65);
    EXPECT_NE(damaged.err.find("damaged.cooked: chunk"), std::string::npos) << damaged.err;
    expect_error(65, {"run", "damaged.json", "--exact", "on", "--mode", "solid"}, {"damaged.cooked", "checksum"});
    expect_error(65, {"cook", "--check", "damaged.cooked"}, {"damaged.cooked", "checksum"});

    write_pair("wrong.json", R"({"file": "building.cooked"})", "building.cooked");
    expect_error(65, {"run", "wrong.json"}, {"building.cooked", "holds a map, not a terrain"});
    write_pair("wrong.json", R"({"file": "heights.cooked", "spacing": 2})", "building.cooked");
    expect_error(65, {"run", "wrong.json"}, {"heights.cooked", "oncollide cook"});
    expect_error(64, {"cook", "heights.cooked", "-o", "again.cooked"}, {"is cooked already"});
    expect_error(64, {"cook", "building.bt", "--tiles", "2", "-o", "land"}, {"--tiles"});
    expect_error(64, {"cook", "building.bt", "--unknown", "maybe", "-o", "a.cooked"}, {"--unknown", "maybe"});
    expect_error(64, {"cook", "heights.pgm", "--unknown", "occupied", "-o", "a.cooked"}, {"--unknown"});
    expect_error(64, {"cook", "building.bt", "--spacing", "2", "-o", "a.cooked"}, {"--spacing"});
}

TEST_F(Cook, NumbersThatMakeNoGridAreErrors)
{
    folder_.write("h.pgm", std::string("P5\n2 2\n255\n\1\2\3\4"));
    write_cube("cube.off");
    const auto refuse = [&](const char* file, const char* option, const char* value, const char* word) {
        expect_error(64, {"cook", file, option, value, "-o", "a.cooked"}, {word});
    };
    for (const char* value : {"0", "-1", "nan", "inf", "1e300"}) refuse("h.pgm", "--spacing", value, "spacing");
    for (const char* value : {"0", "-1", "nan", "inf"}) {
        refuse("h.pgm", "--vertical-scale", value, "vertical scale");
        refuse("cube.off", "--scale", value, "scale");
    }
    for (const char* value : {"inf", "-inf", "1e999"}) refuse("h.pgm", "--no-data", value, "no-data");
    save_octomap(make_building_map(1, 0.5, 3), folder_ / "b.bt");
    for (const char* value : {"0", "1", "nan"}) refuse("b.bt", "--occupancy-threshold", value, "threshold");
    refuse("cube.off", "--spacing", "0", "apply only to files of heights");
    EXPECT_EQ(run({"cook", "h.pgm", "--no-data", "nan", "-o", "a.cooked"}).code, 0);
    folder_.write("s.json", R"({"geometries":{"g":{"terrain":{"file":"h.pgm","spacing":0}}},"bodies":[]})");
    expect_error(65, {"run", "s.json"}, {"s.json: geometries.g.terrain.file: ", "a spacing of 0 and 0"});
}

TEST_F(Cook, AWorldOfTilesIsNamedByItsIndex)
{
    write_ground("ground.obj", 100);
    const Outcome cooked = run({"cook", "ground.obj", "--tiles", "5x4", "-o", "land"});
    EXPECT_EQ(cooked.code, 0) << cooked.err;
    EXPECT_NE(cooked.out.find("20000 triangles in 20 tiles"), std::string::npos) << cooked.out;
    EXPECT_EQ(run({"cook", "--check", "land/tiles.json"}).code, 0);
    const auto scene_with = [](const std::string& index) {
        return R"({"geometries": {"ball": {"mesh": {"generate": {"kind": "sphere", "radius": 0.5, "triangles": 500}}}},
            "bodies": [{"name": "a", "geometry": "ball", "position": [2, 2, 1], "motion": {"drift": {"velocity": [0.3, 0, -0.1]}}}],
            "tiles": [{"file": ")" +
               index + R"(", "name": "land", "position": [0, 0, 0.1]}], "frames": 12})";
    };
    folder_.write("scene.json", scene_with("land/tiles.json"));
    const std::string hash = hash_of({"scene.json", "--exact", "on"});
    EXPECT_EQ(hash_of({"scene.json", "--exact", "on", "--resident", "1M", "--look-ahead", "5", "--threads", "2"}),
              hash);
    const Outcome outcome = run({"run", "scene.json", "--exact", "on"});
    EXPECT_NE(outcome.out.find("'land/1-0'"), std::string::npos) << outcome.out;

    // Wrong bounds, for the tiles near the ball and for all tiles: results that depend on them are undecided.
    const std::string index = folder_.read("land/tiles.json");
    auto wrong = nlohmann::json::parse(index);
    for (auto& tile : wrong["tiles"]) tile["bounds"][1][2] = tile["bounds"][1][2].get<double>() + 0.5;
    folder_.write("land/wrong.json", wrong.dump());
    folder_.write("wrong-scene.json", scene_with("land/wrong.json"));
    const Outcome undecided = run({"run", "wrong-scene.json", "--exact", "on", "--quiet", "--json", "wrong.out.json"});
    EXPECT_EQ(undecided.code, 65);
    EXPECT_NE(undecided.err.find("does not match the index of its tiles"), std::string::npos) << undecided.err;
    const auto verdicts = nlohmann::json::parse(folder_.read("wrong.out.json"))["frames"][6]["verdicts"];
    EXPECT_EQ(verdicts["colliding"], 0) << verdicts.dump();
    expect_error(65, {"cook", "--check", "land/wrong.json"}, {"0-0.cooked", "does not match the index"});
    const std::vector<std::pair<std::string, std::string>> damaged{
        {"", "empty"},
        {index.substr(0, index.size() / 2), "line"},
        {R"({"oncollide_tiles": 2, "tiles": []})", "version 2"},
        {R"({"oncollide_tiles": 1})", "tiles"},
        {R"({"oncollide_tiles": 1, "tiles": [{"file": "a.cooked"}]})", "bounds"},
        {R"({"oncollide_tiles": 1, "tiles": [{"file": "a.obj"}]})", ".cooked"},
        {R"({"oncollide_tiles": 1, "tiles": [{"file": "a.cooked", "bounds": [[1, 0, 0], [0, 1, 1]], "radius": 1,
            "triangles": 1, "vertices": 3, "zero_area": 0, "header": 5}]})",
         "bounds without an inside"},
    };
    for (const auto& [text, what] : damaged) {
        folder_.write("land/damaged.json", text);
        folder_.write("damaged-scene.json", scene_with("land/damaged.json"));
        expect_error(65, {"run", "damaged-scene.json"}, {"damaged.json", what.c_str()});
    }
    expect_error(64, {"cook", "ground.obj", "--tiles", "5y4", "-o", "land"}, {"--tiles", "5y4"});
    expect_error(64, {"cook", "ground.obj", "--tiles", "5"}, {"--out"});
    expect_error(73, {"cook", "ground.obj", "--tiles", "5", "-o", "ground.obj"}, {"ground.obj"});
}

TEST_F(Cook, TheSceneOfTilesIsTheSameFromDiskAndMemory)
{
    const std::vector<std::string> scene{"tiles", "--bodies", "24", "--frames", "40", "--exact", "on"};
    const std::string hash = hash_of(scene);
    std::vector<std::string> cached = scene;
    cached.insert(cached.end(), {"--cache", "cache"});
    EXPECT_EQ(hash_of(cached), hash);
    cached.insert(cached.end(), {"--resident", "1M", "--look-ahead", "10"});
    EXPECT_EQ(hash_of(cached), hash);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "cache"), {}), 1);
}

TEST_F(Cook, WhatIsDamagedEndsWith65AndTheRestIsWritten)
{
    write_ground("ground.obj", 100), write_scene("scene.json", "ground.cooked");
    ASSERT_EQ(run({"cook", "ground.obj", "-o", "ground.cooked", "--quiet"}).code, 0);
    std::string bytes = folder_.read("ground.cooked");
    bytes.resize(bytes.size() - 1);
    folder_.write("cut.cooked", bytes);
    expect_error(65, {"cook", "--check", "cut.cooked"}, {"cut.cooked", "cut off"});
    expect_error(65, {"check", "cut.cooked", "ground.obj"}, {"cut.cooked", "cut off"});
    bytes = folder_.read("ground.cooked");
    for (std::size_t at = bytes.size() / 4; at < bytes.size(); at += 1000) bytes[at] ^= 1;
    folder_.write("ground.cooked", bytes);
    expect_error(65, {"cook", "--check", "ground.cooked"}, {"ground.cooked", "chunk", "checksum"});
    const Outcome outcome = run({"run", "scene.json", "--exact", "predicates", "--quiet", "--json", "result.json"});
    EXPECT_EQ(outcome.code, 65);
    EXPECT_NE(outcome.err.find("the checksum does not match"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("undecided"), std::string::npos) << outcome.err;
    EXPECT_EQ(nlohmann::json::parse(folder_.read("result.json"))["frames"].size(), 8u);

    // Also if another error ends the run: this body leaves the world.
    std::string scene = folder_.read("scene.json");
    scene.insert(scene.rfind(']'), R"(, {"name": "rocket", "geometry": "ball", "position": [0, 0, 500],
        "motion": {"drift": {"velocity": [0, 0, 3e14]}}})");
    folder_.write("ended.json", scene);
    const Outcome ended = run({"run", "ended.json", "--exact", "predicates", "--quiet"});
    EXPECT_EQ(ended.code, 65);
    for (const char* part :
         {"ground.cooked: chunk", "the checksum does not match", "rocket", "ended after 4 of 8 frames"})
        EXPECT_NE(ended.err.find(part), std::string::npos) << ended.err;
}

TEST_F(Cook, RefusesWhatMakesNoSense)
{
    write_ground("ground.obj", 2);
    expect_error(64, {"cook", "ground.obj"}, {"--out"});
    expect_error(64, {"cook", "ground.obj", "-o", "ground.bin"}, {".cooked"});
    expect_error(64, {"cook", "--check", "ground.obj", "-o", "a.cooked"}, {"--check"});
    expect_error(66, {"cook", "none.obj", "-o", "a.cooked"}, {"none.obj"});
    folder_.write("wrong.cooked", "v 0 0 0\n");
    expect_error(65, {"check", "wrong.cooked", "ground.obj"}, {"wrong.cooked", "not a cooked file"});
}

TEST_F(Cook, TheCacheIsKeyedByContentBoundedAndShared)
{
    write_ground("ground.obj", 100), write_scene("scene.json", "ground.obj");
    const std::string plain = hash_of({"scene.json", "--exact", "predicates"});
    const auto cached = [&] {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder_ / "cache"))
            names.push_back(entry.path().filename());
        std::sort(names.begin(), names.end());
        return names;
    };
    // Several processes at once, on an empty folder.
    std::vector<pid_t> others;
    for (int i = 0; i < 4; ++i) {
        const pid_t child = ::fork();
        if (child == 0) {
            const Outcome outcome = run({"run", "scene.json", "--exact", "predicates", "--quiet", "--cache", "cache",
                                         "--json", fmt::format("result-{}.json", i)});
            ::_exit(outcome.code);
        }
        others.push_back(child);
    }
    for (const pid_t child : others) {
        int status = 0;
        ::waitpid(child, &status, 0);
        EXPECT_EQ(status, 0);
    }
    for (int i = 0; i < 4; ++i)
        EXPECT_EQ(nlohmann::json::parse(folder_.read(fmt::format("result-{}.json", i)))["header"]["hash"].dump(),
                  plain);
    ASSERT_EQ(cached().size(), 1u);
    const std::string first = cached()[0];
    // Found again; not found for other content; and a damaged file is made again.
    EXPECT_EQ(hash_of({"scene.json", "--exact", "predicates", "--cache", "cache"}), plain);
    EXPECT_EQ(cached().size(), 1u);
    std::filesystem::resize_file(folder_ / "cache" / first, 100);
    EXPECT_EQ(hash_of({"scene.json", "--exact", "predicates", "--cache", "cache"}), plain);
    EXPECT_GT(std::filesystem::file_size(folder_ / "cache" / first), 100u);
    write_ground("ground.obj", 100, 0.11);
    hash_of({"scene.json", "--exact", "predicates", "--cache", "cache"});
    EXPECT_EQ(cached().size(), 2u);
    write_ground("ground.obj", 100, 0.12);
    hash_of({"scene.json", "--exact", "predicates", "--cache", "cache", "--cache-size", "0"});
    ASSERT_EQ(cached().size(), 1u) << "the newest file stays, although it alone is too large";
    // The limit allows two files of that size, or one.
    const std::uintmax_t bytes = std::filesystem::file_size(folder_ / "cache" / cached()[0]);
    write_ground("ground.obj", 100, 0.13);
    hash_of({"scene.json", "--exact", "predicates", "--cache", "cache", "--cache-size", fmt::format("{}", 3 * bytes)});
    EXPECT_EQ(cached().size(), 2u);
    write_ground("ground.obj", 100, 0.14);
    hash_of({"scene.json", "--exact", "predicates", "--cache", "cache", "--cache-size",
             fmt::format("{}", bytes + bytes / 2)});
    EXPECT_EQ(cached().size(), 1u) << "the newest file counts, too";
    expect_error(73, {"run", "scene.json", "--cache", "ground.obj/cache"}, {"--cache"});
}

} // namespace
} // namespace oncollide::test
