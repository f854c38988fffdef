#include "convert/child_program.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>

namespace oncollide::tools {
namespace {

using Clock = std::chrono::steady_clock;

/// Runs in the new process. Other threads of the parent may have held locks at the fork, so only
/// functions for signal handlers are called.
[[noreturn]] void become(char* const* arguments, int output, int messages, std::uint64_t most_bytes, ::pid_t parent)
{
#ifdef PR_SET_PDEATHSIG
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    if (::getppid() != parent) ::_exit(cannot_start); // the parent ended before the line above
    for (const int signal : {SIGXFSZ, SIGPIPE}) ::signal(signal, SIG_DFL);
    const rlimit no_core{0, 0}, file{most_bytes, most_bytes};
    ::setrlimit(RLIMIT_CORE, &no_core), ::setrlimit(RLIMIT_FSIZE, &file);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO), ::dup2(messages, STDOUT_FILENO), ::dup2(messages, STDERR_FILENO);
    constexpr int to = 3;
    if (output == to)
        ::fcntl(output, F_SETFD, 0);
    else
        ::dup2(output, to);
    ::execv(arguments[0], arguments);
    ::_exit(cannot_start);
}

/// Appends the bytes of the pipe `from`, and keeps the last ones. False: it was not closed before the deadline.
bool read_until_closed(int from, Clock::time_point deadline, std::string& text)
{
    constexpr std::size_t most = 1 << 16;
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
        if (left <= 0) return false;
        ::pollfd ready{from, POLLIN, 0};
        const int count = ::poll(&ready, 1, int(std::min<long long>(left, 1 << 30)));
        if (count < 0 && errno != EINTR) return false;
        if (count <= 0) continue;
        char piece[4096];
        const ::ssize_t got = ::read(from, piece, sizeof piece);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return true;
        text.append(piece, std::size_t(got));
        if (text.size() > 2 * most) text.erase(0, text.size() - most);
    }
}

} // namespace

ProgramEnd run_program(std::vector<std::string> command, int output, const ProgramLimits& limits)
{
    std::vector<char*> arguments;
    for (std::string& argument : command) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    int ends[2];
    const ::pid_t parent = ::getpid();
    const ::pid_t child = ::pipe2(ends, O_CLOEXEC) == 0 ? ::fork() : -1;
    if (child == 0) become(arguments.data(), output, ends[1], limits.bytes, parent);
    if (child < 0)
        throw Error(ErrorKind::internal, fmt::format("{}: no process for it: {}", command[0], std::strerror(errno)));
    ::close(ends[1]);
    ProgramEnd end;
    const auto allowed = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits.seconds));
    end.late = !read_until_closed(ends[0], Clock::now() + allowed, end.messages);
    ::close(ends[0]);
    if (end.late) ::kill(child, SIGKILL);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
    if (WIFEXITED(status)) end.code = WEXITSTATUS(status);
    return end;
}

} // namespace oncollide::tools
