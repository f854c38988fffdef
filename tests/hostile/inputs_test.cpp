// Inputs that are not files: one error instead of blocking.
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include "tools/command_fixture.hpp"

namespace oncollide::test {
namespace {

class HostileInputs : public CommandLine {
protected:
    void SetUp() override
    {
        write_cube("cube.off");
        ASSERT_EQ(::mkfifo((folder_ / "pipe.off").c_str(), 0600), 0);
        ASSERT_EQ(::mkfifo((folder_ / "pipe.bt").c_str(), 0600), 0);
        ASSERT_EQ(::mkfifo((folder_ / "pipe.json").c_str(), 0600), 0);
        std::filesystem::create_directory(folder_ / "folder.off");
        std::filesystem::create_symlink("/dev/zero", folder_ / "zero.off");
        const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        const std::string path = folder_ / "socket.off";
        ASSERT_LT(path.size(), sizeof address.sun_path);
        std::copy(path.begin(), path.end(), address.sun_path);
        ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        ::close(socket);
    }
    /// Code 66 and one line, within ten seconds.
    void refused(std::vector<std::string> arguments, const std::vector<std::string>& words)
    {
        arguments.insert(arguments.begin(), {"10", ONCOLLIDE_COMMAND});
        const Outcome outcome = run_program("/usr/bin/timeout", arguments, {.folder = folder_.path()});
        EXPECT_EQ(outcome.code, 66) << arguments[3] << ": " << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        for (const std::string& word : words) EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    }
    std::string scene_with(const std::string& geometry, const std::string& more = "")
    {
        folder_.write("scene.json",
                      fmt::format(R"({{"geometries":{{"g":{}}},"bodies":[{{"geometry":"g"{}}}]}})", geometry, more));
        return "scene.json";
    }
};

TEST_F(HostileInputs, PipesDevicesSocketsAndFoldersBlockNothing)
{
    refused({"check", "pipe.off", "cube.off"}, {"pipe.off: is not a readable file: it is a pipe"});
    refused({"check", "cube.off", "pipe.bt"}, {"pipe.bt: is not a readable file: it is a pipe"});
    refused({"check", "socket.off", "cube.off"}, {"socket.off: is not a readable file: it is a socket"});
    refused({"check", "zero.off", "cube.off"}, {"zero.off: is not a readable file: it is a device"});
    refused({"check", "folder.off", "cube.off"}, {"folder.off: is a folder"});
    refused({"spheres", "pipe.off"}, {"it is a pipe"});
    refused({"run", "pipe.json"}, {"pipe.json: is not a readable file: it is a pipe"});
    refused({"run", "/dev/zero"}, {"it is a device"});
    refused({"run", scene_with(R"({"mesh":{"file":"pipe.off"}})")}, {"scene.json", "it is a pipe"});
    refused({"run", scene_with(R"({"octomap":{"file":"pipe.bt"}})")}, {"scene.json", "it is a pipe"});
    refused({"run", scene_with(R"({"mesh":{"file":"cube.off"}})",
                               R"(,"motion":{"tum":{"file":"pipe.off","frames_per_second":1}})")},
            {"scene.json", "it is a pipe"});
    refused({"run", scene_with(R"({"mesh":{"file":"cube.off\u0000"}})")}, {"zero byte"});
    refused({"run", scene_with(R"({"mesh":{"file":"-"}})")}, {"./-: no such file"});
}

TEST_F(HostileInputs, ADashAloneIsStandardInput)
{
    const auto with_input = [&](const std::string& file, const std::vector<std::string>& arguments) {
        return run(arguments, {.folder = {}, .in = folder_ / file});
    };
    Outcome outcome = with_input("cube.off", {"check", "-", "cube.off", "--exact", "predicates", "--json", "-"});
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_EQ(with_input("cube.off", {"check", "-", "-", "--exact", "predicates"}).code, 1);
    scene_with(R"({"mesh":{"file":"cube.off"}})");
    outcome = with_input("scene.json", {"run", "-", "--quiet"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    folder_.write("noise", "v 0 0 zero\n");
    outcome = with_input("noise", {"check", "-", "cube.off"});
    EXPECT_EQ(outcome.code, 65);
    EXPECT_NE(outcome.err.find("standard input: line 1: "), std::string::npos) << outcome.err;
    outcome = run({"run", "-"});
    EXPECT_EQ(outcome.code, 65);
    EXPECT_NE(outcome.err.find("standard input: the file is empty"), std::string::npos) << outcome.err;
}

} // namespace
} // namespace oncollide::test
