#include "cli/system.hpp"

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include <fcntl.h>
#include <fmt/format.h>
#include <io.h>
#include <windows.h>

#include <psapi.h>

#include <oncollide/base/files/output_file.hpp>
#include <oncollide/base/files/paths.hpp>

#include "cli/log.hpp"

namespace oncollide::tools {
namespace {

volatile std::sig_atomic_t catching = 0, stop = 0;

bool is_console(DWORD stream)
{
    DWORD mode = 0;
    return GetConsoleMode(GetStdHandle(stream), &mode);
}

/// Windows calls this in a thread of its own.
BOOL WINAPI on_interrupt(DWORD event)
{
    const bool asked = event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT;
    if (asked && catching && !stop) {
        stop = 1;
        return TRUE;
    }
    remove_unfinished_files();
    for (const std::string_view said : {program_name(), std::string_view(": interrupted\n")})
        [[maybe_unused]] const int written = ::_write(2, said.data(), static_cast<unsigned>(said.size()));
    TerminateProcess(GetCurrentProcess(), interrupted_code);
    return TRUE;
}

std::string utf8_of(std::wstring_view text)
{
    return std::filesystem::path(text).string();
}

/// A value of the registry below HKEY_LOCAL_MACHINE; empty: absent.
std::string registry(const wchar_t* key, const wchar_t* value)
{
    wchar_t text[256]{};
    DWORD bytes = sizeof text;
    const LSTATUS status = RegGetValueW(HKEY_LOCAL_MACHINE, key, value, RRF_RT_REG_SZ, nullptr, text, &bytes);
    return status == ERROR_SUCCESS ? utf8_of(text) : "";
}

PROCESS_MEMORY_COUNTERS memory_counters()
{
    PROCESS_MEMORY_COUNTERS counters{};
    GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters);
    return counters;
}

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

std::string file_identity(const std::string& path)
{
    const HANDLE file = CreateFileW(path_of(path).c_str(), 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                                    nullptr, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, nullptr);
    if (file == INVALID_HANDLE_VALUE) return "";
    BY_HANDLE_FILE_INFORMATION about{};
    const bool known = GetFileInformationByHandle(file, &about);
    CloseHandle(file);
    return known ? fmt::format("{}:{}:{}", about.dwVolumeSerialNumber, about.nFileIndexHigh, about.nFileIndexLow) : "";
}

bool stdout_is_terminal()
{
    return is_console(STD_OUTPUT_HANDLE);
}

bool stderr_is_terminal()
{
    return is_console(STD_ERROR_HANDLE);
}

std::size_t terminal_width()
{
    CONSOLE_SCREEN_BUFFER_INFO about{};
    if (!GetConsoleScreenBufferInfo(GetStdHandle(STD_OUTPUT_HANDLE), &about)) return 100;
    return std::clamp<std::size_t>(std::size_t(about.srWindow.Right - about.srWindow.Left + 1), 40, 100);
}

/// Results on standard output are bytes: the C library must not write "\r\n" for "\n".
void prepare_process()
{
    for (const int stream : {0, 1, 2}) ::_setmode(stream, _O_BINARY);
    SetConsoleCtrlHandler(on_interrupt, TRUE);
    SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX); // a fault ends the program without a window
    if (stdout_is_terminal() || stderr_is_terminal()) SetConsoleOutputCP(CP_UTF8);
    for (const DWORD stream : {STD_OUTPUT_HANDLE, STD_ERROR_HANDLE}) // colours
        if (DWORD mode = 0; GetConsoleMode(GetStdHandle(stream), &mode))
            SetConsoleMode(GetStdHandle(stream), mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
}

std::filesystem::path program_folder()
{
    std::wstring path(32768, L'\0'); // the longest name that Windows has
    path.resize(GetModuleFileNameW(nullptr, path.data(), static_cast<DWORD>(path.size())));
    return std::filesystem::path(path).parent_path();
}

std::string command_text()
{
    return utf8_of(GetCommandLineW());
}

std::string processor_name()
{
    const std::string name = registry(L"HARDWARE\\DESCRIPTION\\System\\CentralProcessor\\0", L"ProcessorNameString");
    return name.empty() ? "unknown" : name;
}

std::string system_name()
{
    constexpr const wchar_t* key = L"SOFTWARE\\Microsoft\\Windows NT\\CurrentVersion";
    return fmt::format("{}, build {}", registry(key, L"ProductName"), registry(key, L"CurrentBuildNumber"));
}

std::size_t system_memory()
{
    MEMORYSTATUSEX status{};
    status.dwLength = sizeof status;
    return GlobalMemoryStatusEx(&status) ? std::size_t(status.ullTotalPhys) : 0;
}

std::size_t memory_limit()
{
    return 0;
}

std::size_t peak_memory()
{
    return memory_counters().PeakWorkingSetSize;
}

void forget_peak_memory() {}

std::size_t resident_memory()
{
    return memory_counters().WorkingSetSize;
}

void trim_memory() {}

} // namespace oncollide::tools
