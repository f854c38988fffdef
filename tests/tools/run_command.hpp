#pragma once
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "temporary_folder.hpp"

namespace oncollide::test {

struct Outcome {
    int code; ///< exit status; 1000 + signal if it was killed
    std::string out, err;
};

struct Surroundings {
    std::filesystem::path folder; ///< where it runs
    std::string in = "/dev/null"; ///< file that is standard input
    std::string out = {};         ///< file to which standard output goes instead of Outcome::out
    std::string err = {};         ///< the same for standard error
    std::vector<std::pair<std::string, std::string>> environment = {};
    std::function<void(pid_t)> meanwhile = {}; ///< called while it runs
};

/// Runs a program with `arguments` and waits for it.
inline Outcome run_program(const std::string& program, std::vector<std::string> arguments, const Surroundings& around)
{
    TemporaryFolder catcher;
    const std::string out = around.out.empty() ? (catcher / "out").string() : around.out;
    const std::string err = around.err.empty() ? (catcher / "err").string() : around.err;
    arguments.insert(arguments.begin(), program);
    const pid_t child = ::fork();
    if (child == 0) {
        for (const auto& [name, value] : around.environment) ::setenv(name.c_str(), value.c_str(), 1);
        const int in_file = ::open(around.in.c_str(), O_RDONLY);
        const int out_file = ::open(out.c_str(), O_WRONLY | O_CREAT, 0600);
        const int err_file = ::open(err.c_str(), O_WRONLY | O_CREAT, 0600);
        ::dup2(in_file, 0), ::dup2(out_file, 1), ::dup2(err_file, 2);
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        if (::chdir(around.folder.c_str()) == 0) ::execv(program.c_str(), argv.data());
        ::_exit(127);
    }
    if (around.meanwhile) around.meanwhile(child);
    int status = 0;
    ::waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status),
            around.out.empty() ? catcher.read("out") : "", around.err.empty() ? catcher.read("err") : ""};
}

} // namespace oncollide::test
