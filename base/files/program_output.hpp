#pragma once
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace oncollide {

/// The program of that name in the folders of PATH; empty: there is none. Relative folders of PATH are left out, so
/// that no file beside a document is run.
std::filesystem::path find_program(std::string_view name);

struct ProgramLimits {
    std::size_t bytes = std::size_t{64} << 20; ///< of its standard output, and of a file that it fills
    std::chrono::milliseconds time{60'000};
};

/// The text that a program wrote, and its end.
struct ProgramOutput {
    enum class End { exited, killed, too_long, too_much };

    std::string output;
    std::string errors; ///< the last 64 KiB of its standard error
    End end = End::exited;
    int code = 0; ///< exited: the exit code; killed: the signal

    bool is_good() const { return end == End::exited && code == 0; }
};

/// Runs a program without a shell, with an empty standard input, and waits for it. It ends with the calling thread. At
/// a limit, it is killed with its children. Several threads may call at once. Throws Error{no_input} if the program
/// cannot be started.
/// @param file  an open file, which the program has as /dev/fd/3 and may fill; beyond the limit SIGXFSZ ends the
///              program; -1: none
ProgramOutput output_of(const std::filesystem::path& program, std::vector<std::string> arguments,
                        const ProgramLimits& limits = {}, int file = -1);

} // namespace oncollide
