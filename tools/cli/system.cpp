#include "cli/system.hpp"

#include <csignal>
#include <fstream>

#ifdef __linux__
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace oncollide::tools {
namespace {

volatile std::sig_atomic_t stop = 0;

} // namespace

bool interrupted()
{
    return stop;
}

#ifdef __linux__

bool stderr_is_terminal()
{
    return ::isatty(STDERR_FILENO);
}

void catch_interrupts()
{
    for (int signal : {SIGINT, SIGTERM}) {
        struct sigaction old {};
        sigaction(signal, nullptr, &old);
        if (old.sa_handler == SIG_IGN) continue;
        struct sigaction action {};
        action.sa_handler = [](int) { stop = 1; };
        action.sa_flags = int(SA_RESETHAND) | SA_RESTART;
        sigaction(signal, &action, nullptr);
    }
}

void release_interrupts()
{
    for (int signal : {SIGINT, SIGTERM}) {
        struct sigaction old {};
        sigaction(signal, nullptr, &old);
        if (old.sa_handler != SIG_IGN) std::signal(signal, SIG_DFL);
    }
}

std::string processor_name()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name") && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

std::size_t peak_memory()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

std::size_t resident_memory()
{
    std::ifstream file("/proc/self/statm");
    std::size_t pages = 0;
    file >> pages >> pages;
    return pages * std::size_t(sysconf(_SC_PAGESIZE));
}

void trim_memory()
{
    malloc_trim(0);
}

#else

bool stderr_is_terminal()
{
    return false;
}

void catch_interrupts()
{
    // The default action comes back by itself when the handler is called.
    for (int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop = 1; });
}

void release_interrupts()
{
    for (int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
}

std::string processor_name()
{
    return "unknown";
}

std::size_t peak_memory()
{
    return 0;
}

std::size_t resident_memory()
{
    return 0;
}

void trim_memory() {}

#endif

} // namespace oncollide::tools
