#include "league/adapter.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <oncollide/base/error.hpp>
#include <oncollide/base/text/printable.hpp>

namespace oncollide::tools {

std::vector<const league_library*> open_adapter(const std::filesystem::path& file)
{
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::absolute(file, error); // dlopen searches for bare names
    void* const handle = dlopen(whole.c_str(), RTLD_NOW | RTLD_LOCAL);
    const auto reason = [] { return printable(std::string(dlerror())); };
    if (!handle) throw Error(ErrorKind::no_input, fmt::format("--adapter {}: {}", printable(file.string()), reason()));
    const auto open = reinterpret_cast<const league_library* (*)(int)>(dlsym(handle, "league_open"));
    if (!open) throw Error(ErrorKind::no_input, fmt::format("--adapter {}: {}", printable(file.string()), reason()));
    std::vector<const league_library*> libraries;
    for (int number = 0; number < 64; ++number) {
        const league_library* const library = open(number);
        if (!library) break;
        if (library->version != LEAGUE_VERSION)
            throw Error(ErrorKind::bad_data,
                        fmt::format("--adapter {}: library {} has LEAGUE_VERSION {}, this is {}; compile it anew",
                                    printable(file.string()), number, library->version, LEAGUE_VERSION));
        if (!library->name || !library->supports || !library->prepare || !library->answer || !library->release ||
            (library->bits != 32 && library->bits != 64))
            throw Error(ErrorKind::bad_data,
                        fmt::format("--adapter {}: library {} lacks a name or a function, or its bits are not 32 or 64",
                                    printable(file.string()), number));
        libraries.push_back(library);
    }
    return libraries;
}

void try_to_open(const std::filesystem::path& file)
{
    const pid_t child = ::fork();
    if (child < 0) return; // the adapter is opened without a trial
    if (child == 0) {
        for (const int signal : {SIGALRM, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(signal, SIG_DFL);
        ::alarm(20);
        const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
        ::dup2(nowhere, STDOUT_FILENO), ::dup2(nowhere, STDERR_FILENO);
        try {
            open_adapter(file);
        } catch (const std::exception&) { // the caller finds the same error
        }
        ::_exit(0);
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    const std::string place = fmt::format("--adapter {}: ", printable(file.string()));
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGALRM)
        throw Error(ErrorKind::bad_data, place + "league_open() does not return within 20 s");
    if (WIFSIGNALED(status))
        throw Error(ErrorKind::bad_data, place + fmt::format("crashes as it is loaded or in league_open(): {}",
                                                             ::strsignal(WTERMSIG(status))));
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw Error(ErrorKind::bad_data, place + "ends the program as it is loaded or in league_open()");
}

std::vector<std::filesystem::path> known_adapters()
{
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
    std::vector<fs::path> files;
    for (const fs::path& folder : {here / "league", here.parent_path() / "lib/oncollide-league"})
        for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
            if (entry->path().extension() == ".so") files.push_back(entry->path());
    std::ranges::sort(files);
    return files;
}

} // namespace oncollide::tools
