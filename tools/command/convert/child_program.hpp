#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace oncollide::tools {

/// The limits of a program.
struct ProgramLimits {
    double seconds;
    std::uint64_t bytes; ///< size of a file that it writes
};

/// How a program ended.
struct ProgramEnd {
    int code = 0;         ///< its exit code; cannot_start: the system did not start it
    int signal = 0;       ///< the signal that ended it, or 0
    bool late = false;    ///< it was stopped, because it needed more than the seconds allowed
    std::string messages; ///< the last 64 KiB that it wrote to standard output and standard error
};
constexpr int cannot_start = 127;

/// Runs a program, without a shell, and waits for it. It ends with this process. It gets an empty standard input, and
/// writes its result to `output`, which it has as /dev/fd/3. Callable from several threads. Throws Error{internal} if
/// the system allows no further process.
/// @param command  the path of the program and its arguments
/// @param output   an open file
ProgramEnd run_program(std::vector<std::string> command, int output, const ProgramLimits& limits);

} // namespace oncollide::tools
