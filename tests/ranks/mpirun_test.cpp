// mpirun -n P oncollide run, as run by users. Only in builds with ONCOLLIDE_MPI.
#ifdef ONCOLLIDE_MPI
#include "tools/command_fixture.hpp"

#include <chrono>
#include <random>
#include <thread>

namespace oncollide::test {
namespace {

class Mpirun : public CommandLine {
protected:
    Outcome mpirun(int processes, std::vector<std::string> arguments, std::function<void(pid_t)> meanwhile = {},
                   const std::string& die_at = "")
    {
        arguments.insert(arguments.begin(), {"-n", std::to_string(processes), ONCOLLIDE_COMMAND});
        if (!die_at.empty())
            arguments.insert(arguments.begin(), {"-x", "LD_PRELOAD=" DIE_AT_LIBRARY, "-x", "DIE_AT=" + die_at, "-x",
                                                 "DIE_MARK=" + (folder_ / "died").string()});
        // Works as root in a container, with more processes than processors.
        return run_program(ONCOLLIDE_MPIRUN, arguments,
                           {.folder = folder_.path(),
                            .environment = {{"ONCOLLIDE_DATA", ""},
                                            {"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                                            {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                                            {"OMPI_MCA_rmaps_base_oversubscribe", "1"},
                                            {"OMPI_MCA_mpi_yield_when_idle", "1"},
                                            {"OMPI_MCA_hwloc_base_binding_policy", "none"}},
                            .meanwhile = std::move(meanwhile)});
    }
    static std::string hash(const Outcome& outcome)
    {
        const std::size_t at = outcome.out.rfind("hash       ");
        return at == std::string::npos ? outcome.out + outcome.err : outcome.out.substr(at, 27);
    }
    void expect_the_same(std::vector<std::string> scene)
    {
        scene.insert(scene.begin(), "run");
        const auto to = [&](const char* csv) {
            std::vector<std::string> arguments = scene;
            arguments.insert(arguments.end(), {"--csv", csv});
            return arguments;
        };
        const Outcome one = run(to("one.csv"));
        ASSERT_EQ(one.code, 0) << one.err;
        for (const int processes : {1, 2, 3, 4, 7}) {
            const Outcome many = mpirun(processes, to("many.csv"));
            EXPECT_EQ(many.code, 0) << many.err;
            EXPECT_EQ(hash(many), hash(one)) << processes << " processes, " << scene[1];
            EXPECT_TRUE(folder_.read("many.csv") == folder_.read("one.csv")) << processes << " processes, " << scene[1];
        }
    }
    /// Expects one line of oncollide itself.
    void expect_one_error(int code, const Outcome& outcome, const std::string& words)
    {
        EXPECT_EQ(outcome.code, code) << outcome.err;
        const std::size_t at = outcome.err.find("oncollide: ");
        ASSERT_NE(at, std::string::npos) << outcome.err;
        EXPECT_EQ(outcome.err.find("oncollide: ", at + 1), std::string::npos) << outcome.err;
        EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    }
    /// The processes that mpirun has started.
    static std::vector<pid_t> children(pid_t mpirun)
    {
        std::ifstream file("/proc/" + std::to_string(mpirun) + "/task/" + std::to_string(mpirun) + "/children");
        return {std::istream_iterator<pid_t>(file), {}};
    }
};

TEST_F(Mpirun, WritesTheFileAndTheHashOfOneProcess)
{
    expect_the_same({"city", "--bodies", "200", "--frames", "4"});
    expect_the_same({"hard", "--frames", "3", "--exact", "predicates"});
    expect_the_same({"octomap", "--bodies", "12", "--frames", "3"});
    expect_the_same({"boxes", "--bodies", "1500", "--frames", "4", "--clearance", "0.2", "--rebalance", "always"});
    expect_the_same({"boxes", "--bodies", "3", "--frames", "2"});
}

TEST_F(Mpirun, WritesTheFileAndTheHashOfOneProcessForBodiesOnTheirWays)
{
    expect_the_same({"city", "--bodies", "200", "--frames", "4", "--pace", "20", "--continuous"});
    expect_the_same({"boxes", "--bodies", "1500", "--frames", "4", "--continuous", "--rebalance", "always"});
    std::string bodies;
    for (int i = 0; i < 40; ++i)
        bodies += fmt::format(R"({{"geometry": "plate", "static": true, "position": [{}, 0, 0]}},
            {{"geometry": "bullet", "motion": {{"keys": [[0, {}, 0, 0, 0, 0, 0, 1], [1.5, {}, 0.5, 0, 0, 0, 0, 1],
                                                       [1.75, {}, 0, 0, 0, 0, 0, 1]]}}}},)",
                              2 * i, 2 * i - 1, 79 - 2 * i, 2 * i - 1);
    bodies.pop_back();
    folder_.write("range.json",
                  R"({"frames": 4, "geometries": {"plate": {"shape": {"kind": "box", "half": [0.01, 1, 1]}},
        "bullet": {"shape": {"kind": "sphere", "radius": 0.02}}}, "bodies": [)" +
                      bodies + "]}");
    expect_the_same({"range.json", "--continuous"});
    expect_one_error(64, mpirun(2, {"run", "city", "--view", "v.html"}), "--view: needs a single process");
}

/// Difficult cases for regions: faces that touch on cuts, duplicate
/// bodies, giants over all regions, all bodies at one position, no bodies.
TEST_F(Mpirun, TiesGiantsAndEmptyRegionsAreThoseOfOneProcess)
{
    std::string lattice, heap;
    // Cuts may go through centres: there, cubes shifted by half an edge touch each other.
    for (int i = 0; i < 432; ++i)
        for (int copies = i % 7 == 0 ? 2 : 1; copies > 0; --copies)
            lattice += fmt::format(R"({{"geometry": "cube", "position": [{}, {}, {}]}},)", i % 6 + 0.5 * (i / 216),
                                   i / 6 % 6 + 0.5 * (i / 216), i / 36 % 6 + 0.5 * (i / 216));
    for (int i = 0; i < 30; ++i) heap += R"({"geometry": "cube", "position": [1, 2, 3]},)";
    const auto write = [&](const char* name, std::string bodies) {
        if (!bodies.empty()) bodies.pop_back();
        folder_.write(name, R"({"frames": 3, "geometries": {"cube": {"shape": {"kind": "box", "half": [0.5, 0.5, 0.5]}},
            "giant": {"mesh": {"generate": {"kind": "sphere", "radius": 4, "triangles": 300}}}}, "bodies": [)" +
                                bodies + "]}");
    };
    const std::string giants =
        R"({"geometry": "giant", "position": [0, 0, 0]}, {"geometry": "giant", "position": [6, 6, 6], "motion":
        {"drift": {"velocity": [-0.5, 0, 0]}}},)";
    write("lattice.json", lattice), write("giants.json", giants + lattice), write("heap.json", heap);
    write("three.json", giants + R"({"geometry": "cube"},)"), write("one.json", R"({"geometry": "cube"},)");
    write("none.json", "");
    for (const char* rebalance : {"always", "never"}) expect_the_same({"lattice.json", "--rebalance", rebalance});
    for (const char* scene : {"giants.json", "heap.json", "three.json", "one.json", "none.json"})
        expect_the_same({scene});
}

TEST_F(Mpirun, SaysOnceWhatIsWrong)
{
    expect_one_error(66, mpirun(3, {"run", "nowhere.json"}), "nowhere.json");
    expect_one_error(64, mpirun(3, {"run", "city", "--json", "r.json"}), "--json");
    expect_one_error(64, mpirun(2, {"run", "city", "--partitioner", "best"}), "valid: morton");
    expect_one_error(73, mpirun(2, {"run", "boxes", "--csv", "no/folder.csv"}), "no/folder.csv");
    // Two programs in one job.
    expect_one_error(
        65,
        mpirun(1, {"run", "boxes", "--seed", "1", ":", "-n", "1", ONCOLLIDE_COMMAND, "run", "boxes", "--seed", "2"}),
        "different scenes");
    EXPECT_TRUE(folder_.list().empty());
}

TEST_F(Mpirun, EndsWhenAProcessHangs)
{
    const Outcome outcome =
        mpirun(3, {"run", "boxes", "--bodies", "2000", "--frames", "100000", "--patience", "2", "--csv", "r.csv"},
               [](pid_t parent) {
                   std::this_thread::sleep_for(std::chrono::seconds(2));
                   if (const auto processes = children(parent); !processes.empty()) ::kill(processes.back(), SIGSTOP);
               });
    EXPECT_EQ(outcome.code, 70) << outcome.err;
    EXPECT_NE(outcome.err.find("another process hangs"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder_.read("r.csv"), "") << "nothing is published";
}

/// kill -9 of one process in every phase of a run; ONCOLLIDE_KILLS is the number of times (default: once in each).
TEST_F(Mpirun, GoesOnWhereverAProcessWasKilled)
{
    struct Death {
        const char* phase;
        int least, most; ///< range of the calls
        bool of_process_0 = false;
    };
    const std::vector<Death> deaths{{"load", 1, 1},    {"partition", 1, 9},    {"exchange", 1, 30},
                                    {"narrow", 6, 30}, {"write", 2, 12},       {"checkpoint", 1, 4},
                                    {"sync", 1, 8},    {"rename", 1, 4, true}, {"renamed", 1, 5, true}};
    ASSERT_EQ(run({"scene", "boxes", "--bodies", "1500", "--out", "r.json"}).code, 0);
    const std::vector<std::string> scene{"run", "r.json", "--frames", "14", "--quiet", "--csv"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), scene.begin(), scene.end());
        return more;
    };
    ASSERT_EQ(run(with({"one.csv"})).code, 0);
    const std::vector<std::string> kept =
        with({"r.csv", "--checkpoint", "check", "--checkpoint-every", "3", "--rebalance", "always"});
    const char* kills = std::getenv("ONCOLLIDE_KILLS");
    const std::size_t rounds = kills ? std::strtoul(kills, nullptr, 10) : deaths.size();
    std::mt19937 random(5);
    const auto draw = [&](int least, int most) { return least + int(random() % unsigned(most - least + 1)); };
    double slowest = 0;
    int resumed = 0;
    for (std::size_t round = 0; round < rounds; ++round) {
        const Death& death = deaths[round % deaths.size()];
        const int before = draw(2, 5), after = draw(1, 5);
        const std::string plan = fmt::format("{}:{}:{}", death.phase, draw(death.least, death.most),
                                             death.of_process_0 ? 0 : draw(0, before - 1));
        SCOPED_TRACE(fmt::format("round {}: {}, {} processes, then {}", round, plan, before, after));
        const Outcome killed = mpirun(before, kept, {}, plan);
        ASSERT_TRUE(std::filesystem::exists(folder_ / "died")) << killed.err;
        slowest = std::max(slowest, std::chrono::duration<double>(std::filesystem::file_time_type::clock::now() -
                                                                  std::filesystem::last_write_time(folder_ / "died"))
                                        .count());
        EXPECT_EQ(killed.code, 137) << killed.err;
        EXPECT_TRUE(!std::filesystem::exists(folder_ / "r.csv") || folder_.read("r.csv") == folder_.read("one.csv"))
            << "half of a file is published";
        std::vector<std::string> rest = kept;
        if (std::filesystem::exists(folder_ / "check.0")) rest.push_back("--resume"), ++resumed;
        const Outcome done = mpirun(after, rest);
        EXPECT_EQ(done.code, 0) << done.err;
        EXPECT_TRUE(folder_.read("r.csv") == folder_.read("one.csv"));
        for (const char* file : {"r.csv", "check.0", "check.1", "died", "check.0.part", "check.1.part"})
            std::filesystem::remove(folder_ / file);
    }
    EXPECT_GT(resumed, 0);
    if (kills) fmt::print("{} kills, {} resumed, the slowest end after {:.1f} s\n", rounds, resumed, slowest);
}

TEST_F(Mpirun, AFullDiskOfOneProcessIsOneErrorAndLeavesNothing)
{
    const Outcome outcome =
        mpirun(3, {"run", "boxes", "--bodies", "1500", "--frames", "9", "--quiet", "--csv", "r.csv"}, {}, "full:4:1");
    expect_one_error(73, outcome, "process 1 of 3: r.csv: cannot write: No space left");
    EXPECT_EQ(folder_.list(), std::vector<std::string>{});
}

TEST_F(Mpirun, TakesACheckpointOfThisSceneAndVersionAlone)
{
    const auto play = [&](const char* bodies, std::vector<std::string> more) {
        more.insert(more.begin(), {"run", "boxes", "--bodies", bodies, "--frames", "5", "--quiet", "--checkpoint", "c",
                                   "--checkpoint-every", "2"});
        return mpirun(2, more);
    };
    ASSERT_EQ(play("300", {}).code, 0);
    expect_one_error(65, play("301", {"--resume"}), "another scene");
    for (const char* file : {"c.0", "c.1"}) { // of a future version, with a valid checksum
        std::fstream stream(folder_ / file, std::ios::in | std::ios::out | std::ios::binary);
        stream.seekp(8);
        stream.put(77);
    }
    expect_one_error(65, play("300", {"--resume"}), "another version");
    EXPECT_NE(play("2", {}).code, 1) << "more processes than bodies";
}

} // namespace
} // namespace oncollide::test
#endif
