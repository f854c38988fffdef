#include <oncollide/base/files/program_output.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/files/paths.hpp>

namespace oncollide {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t most_errors = std::size_t{1} << 16; // bytes

/// A pipe from the program to this process.
class ProgramPipe {
public:
    ProgramPipe()
    {
#ifdef __linux__
        const bool made = ::pipe2(ends_.data(), O_CLOEXEC) == 0; // at once: other threads may start programs
#else
        const bool made = ::pipe(ends_.data()) == 0;
        for (const int end : ends_) ::fcntl(end, F_SETFD, FD_CLOEXEC);
#endif
        if (!made) throw Error(ErrorKind::no_input, "pipe: " + std::string(std::strerror(errno)));
    }
    ~ProgramPipe()
    {
        close(0), close(1);
    }
    ProgramPipe(const ProgramPipe&) = delete;
    ProgramPipe& operator=(const ProgramPipe&) = delete;

    void close(std::size_t end)
    {
        if (ends_[end] >= 0) ::close(ends_[end]);
        ends_[end] = -1;
    }
    int read_end() const
    {
        return ends_[0];
    }
    int write_end() const
    {
        return ends_[1];
    }
    bool is_open() const
    {
        return ends_[0] >= 0;
    }

    /// Appends a piece to `text`; closes the pipe at its end.
    void read_to(std::string& text)
    {
        std::array<char, 65536> piece;
        const ssize_t count = ::read(ends_[0], piece.data(), piece.size());
        if (count > 0)
            text.append(piece.data(), static_cast<std::size_t>(count));
        else if (count == 0 || errno != EINTR)
            close(0);
    }

private:
    std::array<int, 2> ends_{};
};

/// Runs in the new process. Other threads of the parent may have held locks at the fork, so only functions for signal
/// handlers are called. Writes errno to `fault` if the program does not start.
[[noreturn]] void become(char* const* arguments, int out, int err, int file, int fault, std::size_t bytes, pid_t parent)
{
#ifdef PR_SET_PDEATHSIG
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    if (::getppid() != parent) ::_exit(1); // it ended before the line above
    ::setpgid(0, 0);                       // to kill it with its children
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    for (const int signal : {SIGXFSZ, SIGPIPE}) ::signal(signal, SIG_DFL);
    const rlimit no_core{0, 0}, most{bytes, bytes};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::dup2(::open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    ::dup2(out, STDOUT_FILENO), ::dup2(err, STDERR_FILENO);
    constexpr int to = 3;
    if (file >= 0) {
        ::setrlimit(RLIMIT_FSIZE, &most);
        if (fault == to) fault = ::fcntl(fault, F_DUPFD_CLOEXEC, to + 1);
        if (file == to)
            ::fcntl(file, F_SETFD, 0);
        else
            ::dup2(file, to);
    }
    ::execv(arguments[0], arguments);
    const int why = errno;
    [[maybe_unused]] const ssize_t written = ::write(fault, &why, sizeof why);
    ::_exit(1);
}

pid_t start(const std::filesystem::path& program, std::vector<std::string>& arguments, const ProgramLimits& limits,
            const ProgramPipe& out, const ProgramPipe& err, int file)
{
    std::string name = program.string();
    std::vector<char*> argv{name.data()};
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    ProgramPipe fault;
    const pid_t parent = ::getpid(), child = ::fork();
    if (child == 0)
        become(argv.data(), out.write_end(), err.write_end(), file, fault.write_end(), limits.bytes, parent);
    fault.close(1);
    int why = child < 0 ? errno : 0;
    if (child > 0) {
        std::string text;
        while (fault.is_open()) fault.read_to(text); // it closes when the program starts
        if (text.size() == sizeof why) std::memcpy(&why, text.data(), sizeof why);
        if (why)
            while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {}
    }
    if (why) throw Error(ErrorKind::no_input, name + ": cannot be started: " + std::strerror(why));
    return child;
}

void keep_end(std::string& errors)
{
    errors.erase(0, errors.size() - std::min(errors.size(), most_errors));
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
                        const ProgramLimits& limits, int file)
{
    const SteadyClock::time_point until = SteadyClock::now() + limits.time;
    ProgramOutput result;
    ProgramPipe out, err;
    const pid_t child = start(program, arguments, limits, out, err, file);
    out.close(1), err.close(1);
    while (result.end == ProgramOutput::End::exited && (out.is_open() || err.is_open())) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - SteadyClock::now()).count();
        std::array<pollfd, 2> waiting = {
            {{out.read_end(), POLLIN, 0}, {err.read_end(), POLLIN, 0}}}; // below 0: ignored
        if (left <= 0 || ::poll(waiting.data(), 2, static_cast<int>(std::min<decltype(left)>(left, 1000))) < 0) {
            if (left <= 0) result.end = ProgramOutput::End::too_long;
            continue;
        }
        if (waiting[0].revents) out.read_to(result.output);
        if (result.output.size() > limits.bytes) result.end = ProgramOutput::End::too_much;
        if (waiting[1].revents) err.read_to(result.errors);
        if (result.errors.size() > 2 * most_errors) keep_end(result.errors); // not at each piece
    }
    keep_end(result.errors);
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
