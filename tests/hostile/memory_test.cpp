// Memory out of proportion to the request, and endings that lose computed results.
#include <chrono>
#include <thread>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

class HostileMemory : public CommandLine {
protected:
    /// `count` bodies at one position, all overlapping.
    std::string heap(int count, const std::string& geometry, const std::function<std::string(int)>& more,
                     int frames = 1)
    {
        std::string text =
            fmt::format("{{\"frames\": {}, \"geometries\": {{\"g\": {}}}, \"bodies\": [", frames, geometry);
        for (int i = 0; i < count; ++i)
            text += fmt::format("{}{{\"geometry\": \"g\", \"position\": [{}, {}, {}]{}}}", i ? "," : "",
                                0.01 * (i % 29), 0.01 * (i % 31), 0.01 * (i % 37), more(i));
        folder_.write("heap.json", text + "]}");
        return "heap.json";
    }
    /// Runs with a limit of that many MB of data; if they do not suffice, the program ends with code 70.
    Outcome run_in(int megabytes, std::vector<std::string> arguments)
    {
        std::string line = fmt::format("ulimit -d {} && exec " ONCOLLIDE_COMMAND, megabytes * 1024);
        for (const std::string& argument : arguments) line += " " + argument;
        return run_program("/bin/sh", {"-c", line}, {.folder = folder_.path()});
    }
    void fits(int megabytes, const std::vector<std::string>& arguments)
    {
        const Outcome outcome = run_in(megabytes, arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
    }

    static constexpr const char* cube = R"({"mesh": {"generate": {"kind": "box", "half": [0.5, 0.5, 0.5]}}})";
    static constexpr const char* ball = R"({"shape": {"kind": "sphere", "radius": 0.5}})";
};

TEST_F(HostileMemory, AHeapOfCubesParksWalksOfBoundedSize)
{
    const std::string scene = heap(500, cube, [](int) { return ""; }); // 124,750 pairs
    fits(200, {"run", scene, "--quiet"});
    fits(150, {"run", scene, "--quiet", "--memory-budget", "1M"});
}

TEST_F(HostileMemory, PairsThatLayersForbidAreNotStored)
{
    const auto layers = [](int i) {
        return fmt::format(", \"layer\": {}, \"mask\": {}{}", i % 2 ? 2 : 1, i % 2 ? 4 : 2,
                           i % 10 ? "" : R"(, "motion": {"drift": {"velocity": [0.001, 0, 0]}})");
    };
    const auto groups = [](int i) {
        return std::string(", \"group\": 1") + (i % 10 ? "" : R"(, "motion": {"drift": {"velocity": [0.001, 0, 0]}})");
    };
    for (const std::function<std::string(int)>& forbid : {std::function<std::string(int)>(layers), {groups}}) {
        const std::string scene = heap(8000, ball, forbid, 2); // 32 million pairs
        for (const char* broad : {"kd", "octree", "brute"}) fits(40, {"run", scene, "--quiet", "--broad", broad});
        fits(40, {"run", scene, "--quiet", "--skip", "broad"});
        fits(40, {"run", scene, "--quiet", "--skip", "delimitation"});
    }
}

TEST_F(HostileMemory, ARunKeepsNothingThatNobodyRequested)
{
    const std::string scene = heap(
        12, ball, [](int) { return ""; }, 50'000); // 66 pairs per frame
    fits(40, {"run", scene, "--quiet"});
    fits(40, {"run", scene, "--quiet", "--picture", "p.svg"});
    fits(40, {"run", scene, "--quiet", "--csv", "r.csv"});
    fits(40, {"run", scene, "--quiet", "--json", "r.json", "--trace", "t.json"});
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"heap.json", "p.svg", "r.csv", "r.json", "t.json"}));
}

TEST_F(HostileMemory, CtrlCEndsAFrameOfManySecondsWithinOne)
{
    const std::string scene = heap(1000, cube, [](int) { return ""; }); // one frame of 10 s
    using Clock = std::chrono::steady_clock;
    Clock::time_point sent;
    Surroundings around;
    around.meanwhile = [&](pid_t child) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1000));
        sent = Clock::now();
        ::kill(child, SIGINT);
    };
    const Outcome outcome = run({"run", scene, "--depth", "6", "--quiet", "--json", "r.json"}, around);
    EXPECT_LT(Clock::now() - sent, std::chrono::seconds(5)) << "half a second, plus a margin for a busy machine";
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    EXPECT_NE(outcome.err.find("interrupted after 0 of 1 frames; their results are in r.json"), std::string::npos)
        << outcome.err;
    EXPECT_EQ(read_json("r.json").at("header").at("interrupted"), true);
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"heap.json", "r.json"}));
}

TEST_F(HostileMemory, ABodyThatLeavesTheWorldEndsTheRunWithTheFramesBeforeIt)
{
    const std::string scene = heap(
        3, ball, [](int i) { return i ? "" : R"(, "motion": {"drift": {"velocity": [2e13, 0, 0]}})"; }, 100);
    const Outcome outcome = run({"run", scene, "--quiet", "--json", "r.json", "--csv", "r.csv"});
    EXPECT_EQ(outcome.code, 65) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find("their results are in r.json, r.csv"), std::string::npos) << outcome.err;
    const nlohmann::json results = read_json("r.json");
    EXPECT_EQ(results.at("header").at("interrupted"), true);
    EXPECT_GT(results.at("frames").size(), 10u);
    EXPECT_LT(results.at("frames").size(), 100u);
    EXPECT_GT(folder_.read("r.csv").size(), 100u);
}

TEST_F(HostileMemory, AShortFileOfManyGeometriesIsRefused)
{
    const auto scene = [&](const std::string& geometry, int count) {
        std::string text = R"({"geometries": {)";
        for (int i = 0; i < count; ++i) text += fmt::format("{}\"g{}\": {}", i ? ", " : "", i, geometry);
        folder_.write("many.json", text + R"(}, "bodies": [{"geometry": "g0"}]})");
        return "many.json";
    };
    write_cube("cube.off");
    fits(60, {"run", scene(R"({"mesh": {"file": "cube.off"}})", 1000), "--quiet"});
    const std::vector<std::string> words{"too much for one scene", "10000000 cells", "20000000 triangles"};
    // 1.3 MB, which would expand to 8.7 GB.
    expect_error(65, {"run", scene(R"({"octomap": {"building": {"rooms": 2, "resolution": 0.25}}})", 16'000)}, words);
    expect_error(65,
                 {"run", scene(R"({"mesh": {"generate": {"kind": "sphere", "radius": 1, "triangles": 500000}}})", 50)},
                 words);
    std::string large = "OFF\n300 2000000 0\n";
    for (int i = 0; i < 300; ++i) large += fmt::format("{} {} 0\n", i, i % 7);
    for (int i = 0; i < 2'000'000; ++i) large += "3 0 1 2\n";
    folder_.write("large.off", large);
    expect_error(65, {"run", scene(R"({"mesh": {"file": "large.off"}})", 20)}, words);
}

TEST_F(HostileMemory, AMapOfTooManyNodesIsRefused)
{
    folder_.write("map.bt", "# Octomap OcTree binary file\nid OcTree\nsize 20000001\nres 0.1\ndata\n");
    write_cube("cube.off");
    expect_error(65, {"check", "map.bt", "cube.off"}, {"20000001 nodes", "at most 20000000"});
}

} // namespace
} // namespace oncollide::test
