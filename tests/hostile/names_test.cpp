// Names that would act on a terminal or break an output, numbers that overflow, byte-order marks.
#include <new>

#include "scenes/files/mesh_writers.hpp"
#include "tools/command_fixture.hpp"
#include <oncollide/base/error.hpp>
#include <oncollide/base/text/printable.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/samples/generators.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide::test {
namespace {

/// Escape sequence, line end, C1, right-to-left override, line separator.
const std::string evil = "\x1b[31mred\n\xc2\x9b\xe2\x80\xae\xe2\x80\xa8\x7f";
const std::string tame = "\\x1b[31mred\\x0a\\u009b\\u202e\\u2028\\x7f";

bool is_tame(const std::string& text)
{
    return printable_lines(text) == text;
}

class HostileNames : public CommandLine {
protected:
    void write_scene(const std::string& name, const std::string& geometry)
    {
        nlohmann::json scene;
        scene["name"] = name;
        scene["geometries"][name] = nlohmann::json::parse(geometry);
        scene["bodies"] = {{{"name", name}, {"geometry", name}}, {{"name", name + "2"}, {"geometry", name}}};
        folder_.write("s.json", scene.dump());
    }
};

TEST_F(HostileNames, WhatActsOnATerminalIsEscaped)
{
    EXPECT_EQ(printable(evil), tame);
    EXPECT_EQ(printable("plain 'text' \\ \xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80"),
              "plain 'text' \\ \xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80");
    EXPECT_EQ(printable("\xff\xc3"), "\\xff\\xc3");
    EXPECT_EQ(printable("\xc0\x80\xed\xa0\x80\xf4\x90\x80\x80\xe0\x80\x80"),
              "\\xc0\\x80\\xed\\xa0\\x80\\xf4\\x90\\x80\\x80\\xe0\\x80\\x80");
    EXPECT_EQ(printable_lines("a\nb\x1b"), "a\nb\\x1b");
    EXPECT_EQ(std::string(Error(ErrorKind::usage, evil).what()), tame);
}

TEST_F(HostileNames, NamesOfAFileReachNoTerminalRaw)
{
    write_scene(evil, R"({"mesh":{"vertices":[[0,0,0],[1,0,0],[2,0,0],[0,1,0]],"triangles":[[0,1,2],[0,1,3]]}})");
    for (const std::vector<std::string>& arguments :
         std::vector<std::vector<std::string>>{{"run", "s.json", "--picture", "p.svg", "--json", "r.json"},
                                               {"accuracy", "s.json"},
                                               {"bench", "scene", "s.json"}}) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_TRUE(is_tame(outcome.out)) << outcome.out;
        EXPECT_TRUE(is_tame(outcome.err)) << outcome.err;
        EXPECT_NE(outcome.out.find("\\x1b[31mred\\x0a"), std::string::npos) << arguments[0] << outcome.out;
    }
    EXPECT_NE(run({"run", "s.json"}).err.find("without area"), std::string::npos);
    EXPECT_NE(folder_.read("r.json").find(nlohmann::json(evil).dump()), std::string::npos) << "not escaped in JSON";
    EXPECT_TRUE(is_tame(folder_.read("p.svg")));
    write_scene(evil, R"({"mesh":{"file":"no\u001b.off"}})");
    expect_error(66, {"run", "s.json"}, {tame, "no\\x1b.off"});

    write_cube("cube.off");
    const std::string name = "\x1b[31m\n.off";
    folder_.write(name, folder_.read("cube.off"));
    const Outcome outcome = run({"check", name, "cube.off", "--distance", "0.1"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_TRUE(is_tame(outcome.out)) << outcome.out;
    EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 2);
    expect_error(64, {"run", "city", "--\x1b[31m"}, {"\\x1b[31m"});
}

TEST_F(HostileNames, NamesThatAreNotUtf8EndInNoInternalFault)
{
    const std::string name = "\xff\xfe.off";
    write_cube(name);
    Outcome outcome = run({"check", name, name, "--json", "r.json"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_TRUE(is_tame(outcome.out)) << outcome.out;
    EXPECT_EQ(read_json("r.json").at("header").is_object(), true);
    EXPECT_NE(folder_.read("r.json").find("\xef\xbf\xbd"), std::string::npos) << "U+FFFD replaces them";
    outcome = run({"spheres", name, "--json", "s.json", "--csv", "s.csv", "--directions", "10", "--depth", "2"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(is_tame(outcome.out)) << outcome.out;
    EXPECT_TRUE(nlohmann::json::accept(folder_.read("s.json")));
    write_scene("plain", R"({"shape":{"kind":"sphere","radius":1}})");
    std::filesystem::rename(folder_ / "s.json", folder_ / "\xff.json");
    for (const char* option : {"--json", "--csv", "--trace", "--picture"}) {
        outcome = run({"run", "\xff.json", option, "out"});
        EXPECT_EQ(outcome.code, 0) << option << outcome.err;
    }
}

TEST_F(HostileNames, SeedsThatWrapAroundAreRefused)
{
    for (const char* seed : {"-1", "18446744073709551616", "1e3", "x", ""})
        expect_error(64, {"run", "city", "--frames", "1", "--seed", seed}, {"--seed"});
    const Outcome outcome = run({"run", "city", "--bodies", "20", "--frames", "1", "--seed", "18446744073709551615"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(HostileNames, ByteOrderMarksBeforeTextAreSkipped)
{
    const std::string mark = "\xef\xbb\xbf";
    const Mesh box = make_box_mesh({1, 1, 1});
    const std::pair<const char*, std::string> files[] = {{"a.obj", as_obj(box)},
                                                         {"a.off", as_off(box)},
                                                         {"text.ply", as_text_ply(box)},
                                                         {"text.stl", as_text_stl(box)},
                                                         {"binary.ply", as_binary_ply(box, false)}};
    for (const auto& [name, text] : files) {
        folder_.write(name, mark + text);
        EXPECT_EQ(load_mesh(folder_ / name).triangles.size(), 12u) << name;
    }
    folder_.write("w.tum", mark + "0 1 2 3 0 0 0 1\n");
    folder_.write("s.json", mark + R"({"geometries":{"g":{"mesh":{"file":"a.obj"}}},"bodies":[{"geometry":"g",)"
                                   R"("motion":{"tum":{"file":"w.tum","frames_per_second":1}}}]})");
    const Outcome outcome = run({"run", "s.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(HostileNames, APlaceIsSaidOnce)
{
    const auto said_once = [&](const std::string& geometry, const std::string& place) {
        write_scene("g", geometry);
        const Outcome outcome = run({"run", "s.json"});
        EXPECT_EQ(outcome.code, 65);
        const std::size_t first = outcome.err.find(place);
        EXPECT_NE(first, std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.err.find("s.json", outcome.err.find("s.json") + 1), std::string::npos) << outcome.err;
    };
    said_once(R"({"mesh":{"generate":{"kind":"teapot"}}})", "s.json: geometries.g.mesh.generate.kind: ");
    said_once(R"({"mesh":{"generate":{"kind":"sphere","radius":-1,"triangles":9}}})",
              "geometries.g.mesh.generate.radius: ");
    said_once(R"({"mesh":{"vertices":[[0,0,0]],"triangles":[[0,0]]}})", "s.json: geometries.g.mesh.triangles[0]: ");
    said_once(R"({"shape":{"kind":"sphere"}})", "s.json: geometries.g.shape: ");
    said_once(R"({"octomap":{"building":{"rooms":0,"resolution":1}}})",
              "s.json: geometries.g.octomap.building.rooms: ");
}

TEST(HostileWorkers, WantOfMemoryInAWorkerIsThrownToTheCaller)
{
    for (const int threads : {1, 4})
        for (Executor* executor : {&thread_pool(), &openmp_executor()}) {
            const ExecutorScope scope(executor);
            EXPECT_THROW(parallel_chunks(1000, 1, threads,
                                         [](std::size_t begin, std::size_t, int) {
                                             if (begin >= 500 || begin == 0) throw std::bad_alloc();
                                         }),
                         std::bad_alloc);
            std::atomic<int> done{0}; // the next loop runs normally
            parallel_chunks(1000, 1, threads, [&](std::size_t b, std::size_t e, int) { done += int(e - b); });
            EXPECT_EQ(done, 1000);
        }
}

TEST_F(HostileNames, OutOfMemoryIsOneLineAndCode70InEveryThread)
{
    int short_of_memory = 0;
    for (const char* how : {"--threads 1", "--threads 4", "--threads 4 --exact predicates", "--threads 2 --exact fcl"})
        for (int megabytes = 50; megabytes <= 98; megabytes += 8) {
            const auto within = [&](const std::string& command) {
                return run_program(
                    "/bin/sh",
                    {"-c", fmt::format("ulimit -v {}; exec {} {}", megabytes * 1024, ONCOLLIDE_COMMAND, command)},
                    {.folder = folder_.path(), .environment = {{"ONCOLLIDE_DATA", ""}, {"OMP_NUM_THREADS", "1"}}});
            };
            if (within("--version").code != 0) continue; // too little for the libraries and their static objects
            const Outcome outcome = within(fmt::format("run many --bodies 40000 --frames 1 --quiet {}", how));
            if (outcome.code == 0) continue; // enough
            EXPECT_EQ(outcome.code, 70) << how << " " << megabytes << ": " << outcome.err;
            // FCL may print a line first.
            EXPECT_TRUE(outcome.err.ends_with("oncollide: out of memory\n")) << how << " " << megabytes << outcome.err;
            EXPECT_TRUE(outcome.err.starts_with("oncollide: ") || outcome.err.starts_with("BVH Error! "))
                << outcome.err;
            ++short_of_memory;
        }
    EXPECT_GE(short_of_memory, 4);
}

} // namespace
} // namespace oncollide::test
