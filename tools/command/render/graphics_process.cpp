#include "render/graphics_process.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <new>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>

#include "cli/log.hpp"
#include "cli/system.hpp"

#if __has_include(<sys/wait.h>)
#include <csignal>

#include <fcntl.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace oncollide::tools {
namespace {

/// A served request: 0 and the result, or the exit code of an Error and its message.
std::string served(const GraphicsProcess::Serve& serve, std::string_view request)
{
    const auto fault = [](ErrorKind kind, const char* what) { return char(kind) + std::string(what); };
    try {
        return '\0' + serve(request);
    } catch (const Error& error) {
        return fault(error.kind(), error.what());
    } catch (const std::bad_alloc&) {
        return fault(ErrorKind::no_gpu, "the graphics driver ran out of memory");
    } catch (const std::exception& error) {
        return fault(ErrorKind::no_gpu, error.what());
    }
}

/// The likely cause of any failure of the driver; empty: memory has no limit.
std::string limit_text()
{
    const std::size_t most = memory_limit();
    return most ? fmt::format(" (memory is limited to {} MB, by ulimit -v; a software renderer needs up to 1,000)",
                              most / 1'000'000)
                : "";
}

std::string result_of(std::string_view reply)
{
    const std::string text(reply.substr(1));
    if (const auto kind = ErrorKind(reply[0]); reply[0])
        throw Error(kind, kind == ErrorKind::no_gpu ? text + limit_text() : text);
    return text;
}

#if __has_include(<sys/wait.h>)

bool send_all(int socket, std::string_view bytes)
{
    while (!bytes.empty()) {
        const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return false;
        bytes.remove_prefix(std::size_t(sent));
    }
    return true;
}

bool receive_all(int socket, char* to, std::size_t count)
{
    while (count > 0) {
        const ssize_t got = ::recv(socket, to, count, 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        to += got, count -= std::size_t(got);
    }
    return true;
}

bool send_message(int socket, std::span<const std::string_view> parts)
{
    std::uint64_t size = 0;
    for (const std::string_view part : parts) size += part.size();
    bool sent = send_all(socket, {reinterpret_cast<const char*>(&size), sizeof size});
    for (const std::string_view part : parts) sent = sent && send_all(socket, part);
    return sent;
}

bool receive_message(int socket, std::string& message)
{
    std::uint64_t size = 0;
    if (!receive_all(socket, reinterpret_cast<char*>(&size), sizeof size)) return false;
    message.resize(size);
    return receive_all(socket, message.data(), size);
}

/// The first process decides about interrupts, because pictures may still follow one.
void leave_signals_and_messages()
{
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(signal, SIG_IGN);
    for (const int signal : {SIGPIPE, SIGXCPU}) std::signal(signal, SIG_DFL);
#ifdef PR_SET_PDEATHSIG
    ::prctl(PR_SET_PDEATHSIG, SIGKILL); // a driver that hangs must not outlive the first process
#endif
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    if (nowhere < 0) return;
    ::dup2(nowhere, STDIN_FILENO), ::dup2(nowhere, STDOUT_FILENO);
    if (!logged(LogLevel::debug)) ::dup2(nowhere, STDERR_FILENO);
}

[[noreturn]] void serve_all(int socket, const GraphicsProcess::Serve& serve)
{
    leave_signals_and_messages();
    try {
        for (std::string request; receive_message(socket, request);) {
            const std::string reply = served(serve, request);
            const std::string_view parts[] = {reply};
            if (!send_message(socket, parts)) break;
        }
    } catch (const std::bad_alloc&) { // the request does not fit
        const std::string_view parts[] = {"\x47the graphics driver ran out of memory"};
        static_assert(int(ErrorKind::no_gpu) == 0x47);
        send_message(socket, parts);
    }
    ::_exit(0);
}

std::string end_of(int process)
{
    int status = 0;
    while (::waitpid(process, &status, 0) < 0)
        if (errno != EINTR) return "the process of the graphics driver ended";
    return WIFSIGNALED(status) ? fmt::format("the graphics driver crashed ({})", ::strsignal(WTERMSIG(status)))
                               : fmt::format("the graphics driver ended (exit code {})", WEXITSTATUS(status));
}

#endif

} // namespace

#if __has_include(<sys/wait.h>)

GraphicsProcess::GraphicsProcess(Serve serve) : serve_(std::move(serve))
{
    int ends[2] = {-1, -1};
    const bool connected = ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0;
    const int process = connected ? ::fork() : -1;
    if (process == 0) {
        ::close(ends[0]);
        serve_all(ends[1], serve_);
    }
    if (process < 0) fault_ = fmt::format("no process for the graphics driver: {}", std::strerror(errno));
    process_ = std::max(process, 0);
    socket_ = ends[0];
    ::close(ends[1]);
}

GraphicsProcess::~GraphicsProcess()
{
    ::close(socket_);
    if (process_) end_of(process_);
}

void GraphicsProcess::fail()
{
    if (process_) fault_ = end_of(std::exchange(process_, 0)) + limit_text();
    throw Error(ErrorKind::no_gpu, fault_);
}

std::string GraphicsProcess::request(std::span<const std::string_view> parts)
{
    std::string reply;
    if (!process_ || !send_message(socket_, parts) || !receive_message(socket_, reply) || reply.empty()) fail();
    return result_of(reply);
}

#else

GraphicsProcess::GraphicsProcess(Serve serve) : serve_(std::move(serve)) {}
GraphicsProcess::~GraphicsProcess() = default;

void GraphicsProcess::fail()
{
    throw Error(ErrorKind::no_gpu, fault_);
}

std::string GraphicsProcess::request(std::span<const std::string_view> parts)
{
    std::string request;
    for (const std::string_view part : parts) request += part;
    return result_of(served(serve_, request));
}

#endif

} // namespace oncollide::tools
