#include "cli/system.hpp"

#include <algorithm>
#include <cctype>
#include <csignal>
#include <fstream>

#include <fmt/format.h>

#include <oncollide/base/files/output_file.hpp>

#include "cli/log.hpp"

#ifdef __linux__
#include <fcntl.h>
#include <gnu/libc-version.h>
#include <malloc.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>
#endif

namespace oncollide::tools {
namespace {

volatile std::sig_atomic_t catching = 0, stop = 0;

} // namespace

void catch_interrupts()
{
    catching = 1;
}

void release_interrupts()
{
    catching = 0;
}

bool interrupted()
{
    return stop;
}

#ifdef __linux__

std::string file_identity(const std::string& path)
{
    struct stat status {};
    return ::stat(path.c_str(), &status) == 0 ? fmt::format("{}:{}", status.st_dev, status.st_ino) : "";
}

bool stdout_is_terminal()
{
    return ::isatty(STDOUT_FILENO);
}

bool stderr_is_terminal()
{
    return ::isatty(STDERR_FILENO);
}

std::size_t terminal_width()
{
    winsize size{};
    if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return 100;
    return std::clamp<std::size_t>(size.ws_col, 40, 100);
}

void prepare_process()
{
    // open() returns the lowest free number. If standard output is opened for reading, writing to it fails.
    for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::fcntl(file, F_GETFD) < 0) [[maybe_unused]]
            const int opened = ::open("/dev/null", file == STDERR_FILENO ? O_WRONLY : O_RDONLY);
    std::signal(SIGXFSZ, SIG_IGN);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGQUIT, SIGXCPU}) {
        struct sigaction old {};
        sigaction(signal, nullptr, &old);
        if (old.sa_handler == SIG_IGN) continue;
        struct sigaction action {};
        action.sa_handler = [](int number) {
            if (catching && !stop && (number == SIGINT || number == SIGTERM)) {
                stop = 1;
                return;
            }
            remove_unfinished_files();
            if (number == SIGINT || number == SIGTERM || number == SIGHUP) {
                for (const std::string_view said : {program_name(), std::string_view(": interrupted\n")})
                    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, said.data(), said.size());
            }
            std::signal(number, SIG_DFL);
            std::raise(number); // takes effect when this handler returns
        };
        action.sa_flags = SA_RESTART;
        sigaction(signal, &action, nullptr);
    }
}

std::filesystem::path program_folder()
{
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

std::string command_text()
{
    std::ifstream file("/proc/self/cmdline");
    std::string text, word;
    while (std::getline(file, word, '\0')) {
        if (text.empty()) word = std::filesystem::path(word).filename();
        const bool plain = !word.empty() && std::ranges::all_of(word, [](unsigned char c) {
            return std::isalnum(c) || std::string_view("-_./,:=+@%").find(char(c)) != std::string_view::npos;
        });
        if (!text.empty()) text += ' ';
        if (plain) {
            text += word;
            continue;
        }
        text += '\'';
        for (const char c : word) c == '\'' ? text += "'\\''" : text += c;
        text += '\'';
    }
    return text;
}

std::string processor_name()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name") && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown";
}

std::string system_name()
{
    std::string name;
    std::ifstream file("/etc/os-release");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("PRETTY_NAME=\"") && line.size() > 14) name = line.substr(13, line.size() - 14) + ", ";
    utsname kernel{};
    uname(&kernel);
    return fmt::format("{}{} {} {}, glibc {}", name, kernel.sysname, kernel.release, kernel.machine,
                       gnu_get_libc_version());
}

std::size_t system_memory()
{
    return std::size_t(sysconf(_SC_PHYS_PAGES)) * std::size_t(sysconf(_SC_PAGESIZE));
}

std::size_t memory_limit()
{
    rlimit most{};
    const bool limited = ::getrlimit(RLIMIT_AS, &most) == 0 && most.rlim_cur != RLIM_INFINITY;
    return limited ? std::size_t(most.rlim_cur) : 0;
}

std::size_t peak_memory()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

void forget_peak_memory()
{
    std::ofstream("/proc/self/clear_refs") << 5;
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

std::string file_identity(const std::string& path)
{
    std::error_code error;
    return std::filesystem::canonical(path, error).string();
}

bool stdout_is_terminal()
{
    return false;
}

bool stderr_is_terminal()
{
    return false;
}

std::size_t terminal_width()
{
    return 100;
}

void prepare_process()
{
    // Calling the handler restores the default action.
    for (int signal : {SIGINT, SIGTERM})
        std::signal(signal, [](int number) {
            if (catching) {
                stop = 1;
                return;
            }
            remove_unfinished_files();
            std::raise(number);
        });
}

std::filesystem::path program_folder()
{
    return {};
}

std::string command_text()
{
    return {};
}

std::string processor_name()
{
    return "unknown";
}

std::string system_name()
{
    return "unknown";
}

std::size_t system_memory()
{
    return 0;
}

std::size_t memory_limit()
{
    return 0;
}

std::size_t peak_memory()
{
    return 0;
}

void forget_peak_memory() {}

std::size_t resident_memory()
{
    return 0;
}

void trim_memory() {}

#endif

} // namespace oncollide::tools
