// mpirun -n P oncollide run, as users meet it. Only in builds with ONCOLLIDE_MPI.
#ifdef ONCOLLIDE_MPI
#include "tools/command_fixture.hpp"

#include <chrono>
#include <random>
#include <thread>

namespace oncollide::test {
namespace {

class Mpirun : public CommandLine {
protected:
    Outcome mpirun(int processes, std::vector<std::string> arguments, std::function<void(pid_t)> meanwhile = {})
    {
        arguments.insert(arguments.begin(), {"-n", std::to_string(processes), ONCOLLIDE_COMMAND});
        // As root in a container, with more processes than processors.
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
            EXPECT_EQ(many.err.find("Zoltan"), std::string::npos) << many.err;
            EXPECT_EQ(hash(many), hash(one)) << processes << " processes, " << scene[1];
            EXPECT_TRUE(folder_.read("many.csv") == folder_.read("one.csv")) << processes << " processes, " << scene[1];
        }
    }
    /// The one line that is oncollide's own.
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

TEST_F(Mpirun, SaysOnceWhatIsWrong)
{
    expect_one_error(66, mpirun(3, {"run", "nowhere.json"}), "nowhere.json");
    expect_one_error(64, mpirun(3, {"run", "city", "--json", "r.json"}), "--json");
    expect_one_error(64, mpirun(2, {"run", "city", "--partitioner", "best"}), "valid: zoltan, morton");
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

TEST_F(Mpirun, GoesOnAfterProcessesWereKilled)
{
    std::vector<std::string> scene{"run",   "boxes", "--bodies",     "1500",  "--frames",           "30",
                                   "--csv", "r.csv", "--checkpoint", "check", "--checkpoint-every", "2"};
    std::mt19937 random(5);
    Outcome outcome{};
    for (int round = 0; round < 6; ++round) {
        const int processes = 2 + int(random() % 4);
        const int wait_ms = round < 5 ? 400 + int(random() % 1000) : 0;
        outcome = mpirun(processes, scene, [&](pid_t parent) {
            if (!wait_ms) return;
            std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
            const auto running = children(parent);
            if (!running.empty()) ::kill(running[random() % running.size()], SIGKILL);
        });
        if (outcome.code == 0) break;
        EXPECT_EQ(outcome.code, 137) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / "r.csv"));
        if (scene.back() != "--resume" && std::filesystem::exists(folder_ / "check.0")) scene.push_back("--resume");
    }
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    ASSERT_EQ(run({"run", "boxes", "--bodies", "1500", "--frames", "30", "--csv", "one.csv", "--quiet"}).code, 0);
    EXPECT_TRUE(folder_.read("r.csv") == folder_.read("one.csv"));
}

} // namespace
} // namespace oncollide::test
#endif
