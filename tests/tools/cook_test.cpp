// `oncollide cook`, and cooked files and their cache on the command line.
#include <fstream>

#include <sys/wait.h>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

class Cook : public CommandLine {
protected:
    /// A wavy ground of so many cells a side, at z = 0.
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
    EXPECT_NE(outcome.err.find("the checksum is another one"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("undecided"), std::string::npos) << outcome.err;
    EXPECT_EQ(nlohmann::json::parse(folder_.read("result.json"))["frames"].size(), 8u);
}

TEST_F(Cook, RefusesWhatMakesNoSense)
{
    write_ground("ground.obj", 2);
    expect_error(64, {"cook", "ground.obj"}, {"--out"});
    expect_error(64, {"cook", "ground.obj", "-o", "ground.bin"}, {".cooked"});
    expect_error(64, {"cook", "--check", "ground.obj", "-o", "a.cooked"}, {"--check"});
    expect_error(66, {"cook", "none.obj", "-o", "a.cooked"}, {"none.obj"});
    folder_.write("wrong.cooked", "v 0 0 0\n");
    expect_error(65, {"check", "wrong.cooked", "ground.obj"}, {"wrong.cooked", "no cooked file"});
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
    // Several at once, on an empty folder.
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
    // Found again; not by another content; and one that is damaged is made anew.
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
    EXPECT_EQ(cached().size(), 1u);
    expect_error(73, {"run", "scene.json", "--cache", "ground.obj/cache"}, {"--cache"});
}

} // namespace
} // namespace oncollide::test
