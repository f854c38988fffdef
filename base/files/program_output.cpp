#include <oncollide/base/files/program_output.hpp>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>

extern char** environ; // NOLINT: POSIX leaves its declaration to the program

namespace oncollide {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t most_errors = std::size_t{1} << 16; // bytes

/// A pipe from the program to this process.
class ProgramPipe {
public:
    ProgramPipe()
    {
        if (::pipe(ends_.data()) != 0) throw Error(ErrorKind::no_input, "pipe: " + std::string(std::strerror(errno)));
        for (const int end : ends_) ::fcntl(end, F_SETFD, FD_CLOEXEC);
    }
    ~ProgramPipe() { close(0), close(1); }
    ProgramPipe(const ProgramPipe&) = delete;
    ProgramPipe& operator=(const ProgramPipe&) = delete;

    void close(std::size_t end)
    {
        if (ends_[end] >= 0) ::close(ends_[end]);
        ends_[end] = -1;
    }
    int read_end() const { return ends_[0]; }
    int write_end() const { return ends_[1]; }
    bool is_open() const { return ends_[0] >= 0; }

    /// Appends a piece to `text`, up to `most` bytes in all. False: the limit was reached.
    bool read_to(std::string& text, std::size_t most)
    {
        std::array<char, 65536> piece;
        const ssize_t count = ::read(ends_[0], piece.data(), piece.size());
        if (count < 0 && errno == EINTR) return true;
        if (count <= 0) {
            close(0);
            return true;
        }
        const auto bytes = static_cast<std::size_t>(count);
        text.append(piece.data(), std::min(bytes, most - text.size()));
        return text.size() < most || bytes == 0;
    }

private:
    std::array<int, 2> ends_{};
};

pid_t start(const std::filesystem::path& program, std::vector<std::string>& arguments, const ProgramPipe& out,
            const ProgramPipe& err)
{
    std::string name = program.string();
    std::vector<char*> argv{name.data()};
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files), posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, out.write_end(), 1);
    posix_spawn_file_actions_adddup2(&files, err.write_end(), 2);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setpgroup(&attributes, 0); // of its own, to kill it with its children
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
    pid_t child = -1;
    const int fault = ::posix_spawn(&child, name.c_str(), &files, &attributes, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files), posix_spawnattr_destroy(&attributes);
    if (fault) throw Error(ErrorKind::no_input, name + ": cannot be started: " + std::strerror(fault));
    return child;
}

} // namespace

std::filesystem::path find_program(std::string_view name)
{
    const char* const found = std::getenv("PATH");
    std::string_view folders = found ? found : "";
    while (!folders.empty()) {
        const std::size_t end = std::min(folders.find(':'), folders.size());
        const std::filesystem::path folder(folders.substr(0, end));
        folders.remove_prefix(std::min(end + 1, folders.size()));
        if (!folder.is_absolute()) continue;
        std::filesystem::path program = folder / name;
        if (is_regular(program) && ::access(program.c_str(), X_OK) == 0) return program;
    }
    return {};
}

ProgramOutput output_of(const std::filesystem::path& program, std::vector<std::string> arguments,
                        const ProgramLimits& limits)
{
    const SteadyClock::time_point until = SteadyClock::now() + limits.time;
    ProgramOutput result;
    ProgramPipe out, err;
    const pid_t child = start(program, arguments, out, err);
    out.close(1), err.close(1);
    while (result.end == ProgramOutput::End::exited && (out.is_open() || err.is_open())) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - SteadyClock::now()).count();
        std::array<pollfd, 2> waiting = {
            {{out.read_end(), POLLIN, 0}, {err.read_end(), POLLIN, 0}}}; // below 0: ignored
        if (left <= 0 || ::poll(waiting.data(), 2, static_cast<int>(std::min<decltype(left)>(left, 1000))) < 0) {
            if (left <= 0) result.end = ProgramOutput::End::too_long;
            continue;
        }
        if (waiting[0].revents && !out.read_to(result.output, limits.bytes + 1))
            result.end = ProgramOutput::End::too_much;
        if (waiting[1].revents && !err.read_to(result.errors, most_errors)) result.errors.resize(most_errors - 1);
    }
    int status = 0;
    while (result.end == ProgramOutput::End::exited && ::waitpid(child, &status, WNOHANG) == 0) {
        if (SteadyClock::now() > until) result.end = ProgramOutput::End::too_long;
        std::this_thread::sleep_for(std::chrono::milliseconds(1)); // it has closed both pipes, and ends soon
    }
    if (result.end != ProgramOutput::End::exited) {
        ::kill(-child, SIGKILL);
        while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    }
    if (result.end != ProgramOutput::End::exited) return result;
    if (WIFSIGNALED(status)) result.end = ProgramOutput::End::killed;
    result.code = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
    return result;
}

} // namespace oncollide
