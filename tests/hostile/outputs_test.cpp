// Outputs that would destroy data: an input, another user's permissions, a folder full of leftovers.
#include <sys/stat.h>

#include "scenes/files/mesh_writers.hpp"
#include "tools/command_fixture.hpp"
#include <oncollide/base/files/output_file.hpp>
#include <oncollide/samples/generators.hpp>

namespace oncollide::test {
namespace {

class HostileOutputs : public CommandLine {
protected:
    /// Exit code 64, one line, and `file` unchanged.
    void keeps(const std::string& file, const std::vector<std::string>& arguments)
    {
        const std::string before = folder_.read(file);
        expect_error(64, arguments, {"would overwrite"});
        EXPECT_EQ(folder_.read(file), before);
    }
};

TEST_F(HostileOutputs, AnOutputThatIsAnInputIsRefusedByEveryCommand)
{
    folder_.write("c.obj", as_obj(make_box_mesh({1, 1, 1})));
    std::filesystem::create_symlink("c.obj", folder_ / "link.obj");
    std::filesystem::create_hard_link(folder_ / "c.obj", folder_ / "hard.obj");
    const std::string absolute = folder_ / "c.obj";
    for (const std::string& out :
         {std::string("c.obj"), std::string("./c.obj"), std::string("link.obj"), std::string("hard.obj"), absolute}) {
        keeps("c.obj", {"check", "c.obj", "c.obj", "--exact", "predicates", "--contacts", out});
        keeps("c.obj", {"check", "c.obj", "link.obj", "--json", out});
        keeps("c.obj", {"spheres", "c.obj", "--csv", out});
        keeps("c.obj", {"bench", "narrow", "c.obj", "c.obj", "--csv", out});
        keeps("c.obj", {"accuracy", "study", "c.obj", "hard.obj", "--html", out});
    }
    expect_error(64, {"check", "c.obj", "c.obj", "--exact", "predicates", "--contacts", "-", "--json", "-"},
                 {"both go"});
}

TEST_F(HostileOutputs, AnOutputThatASceneNamesInsideIsRefused)
{
    folder_.write("c.obj", as_obj(make_box_mesh({1, 1, 1})));
    const Mesh box = make_box_mesh({1, 1, 1});
    folder_.write("b.bin", gltf_buffer(box));
    folder_.write("c.gltf", gltf_json(box, R"("uri":"b.bin",)"));
    folder_.write("w.tum", "0 1 2 3 0 0 0 1\n1 2 2 3 0 0 0 1\n");
    std::filesystem::create_symlink("c.obj", folder_ / "link.obj");
    folder_.write("s.json", R"({"geometries":{"a":{"mesh":{"file":"c.obj"}},"b":{"mesh":{"file":"c.gltf"}}},)"
                            R"("bodies":[{"geometry":"a"},{"geometry":"b"},)"
                            R"({"geometry":"a","motion":{"tum":{"file":"w.tum","frames_per_second":1}}}]})");
    for (const char* option : {"--json", "--csv", "--trace"})
        for (const char* file : {"s.json", "c.obj", "link.obj", "c.gltf", "b.bin", "w.tum"})
            keeps(file, {"run", "s.json", option, file});
    for (const char* file : {"s.json", "c.obj", "w.tum"}) {
        keeps(file, {"accuracy", "s.json", "--json", file});
        keeps(file, {"bench", "scene", "s.json", "--csv", file});
        keeps(file, {"render", "s.json", "--out", file});
    }
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"b.bin", "c.gltf", "c.obj", "link.obj", "s.json", "w.tum"}));
    EXPECT_EQ(run({"run", "s.json", "--json", "out.json"}).code, 0);
}

TEST_F(HostileOutputs, TemporaryFilesOfOtherRunsBlockNobody)
{
    const std::string out = folder_ / "out.csv";
    {
        const OutputFile first(out), second(out); // as in two runs with the same process id
        EXPECT_EQ(folder_.list().size(), 2u);
        const OutputFile longest(folder_ / (std::string(251, 'n') + ".csv"));
        EXPECT_EQ(folder_.list().size(), 3u);
    }
    EXPECT_TRUE(folder_.list().empty());
}

/// After the run, when interrupted() is no longer checked, and slow results are partly written.
TEST_F(HostileOutputs, AnInterruptWhileResultsAreWrittenLeavesNoTemporaryFile)
{
    const std::string program = ONCOLLIDE_COMMAND;
    Surroundings around{.folder = folder_.path()};
    around.environment.emplace_back("ONCOLLIDE_DATA", "");
    around.meanwhile = [&](pid_t child) {
        const auto begun = [&] { // a mere test of write access leaves files empty
            for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
                if (std::error_code gone; entry.file_size(gone) > 0 && !gone) return true;
            return false;
        };
        for (int k = 0; k < 60'000 && !begun(); ++k) ::usleep(500);
        ::kill(child, SIGINT);
    };
    const Outcome outcome = run_program(
        program, {"run", "many", "--bodies", "2000", "--frames", "40", "--separate", "--json", "out.json", "--quiet"},
        around);
    if (outcome.code == 0) GTEST_SKIP() << "it was written too soon";
    EXPECT_EQ(outcome.code, 1000 + SIGINT);
    EXPECT_TRUE(folder_.list().empty());
}

class Ended : public HostileOutputs, public ::testing::WithParamInterface<int> {};

TEST_P(Ended, ASignalLeavesNoTemporaryFile)
{
    const std::string program = ONCOLLIDE_LAB;
    Surroundings around{.folder = folder_.path()};
    around.environment.emplace_back("ONCOLLIDE_DATA", "");
    around.meanwhile = [&](pid_t child) {
        for (int k = 0; k < 1000 && folder_.list().empty(); ++k) ::usleep(10'000);
        ::usleep(100'000);
        EXPECT_FALSE(folder_.list().empty()) << "it has not begun to write";
        ::kill(child, GetParam());
    };
    const Outcome outcome = run_program(program, {"bench", "shapes", "--csv", "out.csv"}, around);
    EXPECT_EQ(outcome.code, 1000 + GetParam());
    EXPECT_EQ(outcome.err.ends_with("oncollide-lab: interrupted\n"), GetParam() != SIGPIPE) << outcome.err;
    EXPECT_TRUE(folder_.list().empty()) << folder_.list().front();
}

INSTANTIATE_TEST_SUITE_P(Signals, Ended, ::testing::Values(SIGINT, SIGTERM, SIGHUP, SIGPIPE));

TEST_F(HostileOutputs, AFileSizeLimitIsAnErrorOfWritingAndLeavesTheOldFile)
{
    folder_.write("out.json", "old");
    const Outcome outcome =
        run_program("/bin/sh",
                    {"-c", std::string("ulimit -f 1; exec ") + ONCOLLIDE_COMMAND +
                               " run city --bodies 200 --frames 20 --quiet --separate --json out.json"},
                    {.folder = folder_.path(), .environment = {{"ONCOLLIDE_DATA", ""}}});
    EXPECT_EQ(outcome.code, 73) << outcome.err;
    EXPECT_NE(outcome.err.find("out.json: cannot write: File too large"), std::string::npos) << outcome.err;
    EXPECT_EQ(folder_.list(), (std::vector<std::string>{"out.json"}));
    EXPECT_EQ(folder_.read("out.json"), "old");
}

TEST_F(HostileOutputs, AReplacedFileKeepsItsPermissionsAndOwner)
{
    write_cube("c.off");
    folder_.write("out.json", "old");
    const std::string out = folder_ / "out.json";
    const bool root = ::geteuid() == 0;
    if (root) {
        ASSERT_EQ(::chown(out.c_str(), 12345, 23456), 0);
    }
    ASSERT_EQ(::chmod(out.c_str(), 0640), 0);
    EXPECT_EQ(run({"check", "c.off", "c.off", "--json", "out.json"}).code, 1);
    struct stat status {};
    ASSERT_EQ(::stat(out.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 07777, 0640u);
    if (root) {
        EXPECT_EQ(status.st_uid, 12345u);
        EXPECT_EQ(status.st_gid, 23456u);
    }
    EXPECT_NE(folder_.read("out.json"), "old");
}

TEST_F(HostileOutputs, ASymbolicLinkIsFollowed)
{
    write_cube("c.off");
    std::filesystem::create_directory(folder_ / "there");
    for (const char* link : {"there/old.json", "there/new.json"}) {
        if (std::string(link) == "there/old.json") folder_.write(link, "old");
        std::filesystem::create_symlink(link, folder_ / "out.json");
        EXPECT_EQ(run({"check", "c.off", "c.off", "--json", "out.json"}).code, 1);
        EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "out.json"));
        EXPECT_TRUE(nlohmann::json::accept(folder_.read(link))) << link;
        std::filesystem::remove(folder_ / "out.json");
    }
    std::filesystem::create_symlink("loop.json", folder_ / "loop.json");
    expect_error(73, {"check", "c.off", "c.off", "--json", "loop.json"}, {"loop.json: cannot write"});
}

TEST_F(HostileOutputs, AStandardErrorThatCannotBeWrittenLeavesTheExitCode)
{
    write_cube("c.off");
    folder_.write("warns.json", R"({"geometries": {"b": {"shape": {"kind": "box", "half": [1, 1, 1]}}},
                                    "bodies": [{"geometry": "b", "rotation": [0, 0, 0, 2]}]})");
    folder_.write("damaged.obj", "v 0 0");
    const auto code = [&](std::vector<std::string> arguments, const char* level = "note") {
        return run(std::move(arguments), {.folder = {}, .err = "/dev/full", .environment = {{"ONCOLLIDE_LOG", level}}})
            .code;
    };
    EXPECT_EQ(code({"run", "none.json"}), 66);
    EXPECT_EQ(code({"check", "c.off", "damaged.obj"}), 65);
    EXPECT_EQ(code({"run"}), 64);
    EXPECT_EQ(code({"run", "many"}, "everything"), 64);
    EXPECT_EQ(code({"check", "c.off", "c.off", "--json", "none/out.json"}), 73);
    EXPECT_EQ(code({"check", "c.off", "c.off"}, "debug"), 1);
    EXPECT_EQ(code({"run", "warns.json"}, "debug"), 0);
    // The table of results goes to standard error where a file of results takes standard output.
    EXPECT_EQ(code({"check", "c.off", "c.off", "--json", "-"}), 1);
    EXPECT_EQ(code({"spheres", "c.off", "--json", "-"}), 0);
    EXPECT_EQ(code({"run", "many", "--bodies", "20", "--frames", "2", "--json", "-"}), 0);
}

TEST_F(HostileOutputs, ClosedStandardFilesAreNotTakenByOutputs)
{
    write_cube("c.off");
    const Outcome outcome = run_program(
        "/bin/sh", {"-c", std::string(ONCOLLIDE_COMMAND) + " check c.off c.off --json out.json <&- >&- 2>&-"},
        {.folder = folder_.path()});
    EXPECT_EQ(outcome.code, 73) << "the verdict was not printed";
    EXPECT_TRUE(nlohmann::json::accept(folder_.read("out.json"))) << folder_.read("out.json");
}

} // namespace
} // namespace oncollide::test
