#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

// Access to the operating system; Windows: windows/system.cpp. Systems other than Linux support fewer of these
// functions; nothing depends on them.
namespace oncollide::tools {

/// Identifies a file independent of the name or link that leads to it; empty: the file does not exist.
std::string file_identity(const std::string& path);

/// True if standard output, or standard error, is a terminal.
bool stdout_is_terminal();
bool stderr_is_terminal();
/// Columns of the terminal on standard output, from 40 to 100; 100 if it is not a terminal.
std::size_t terminal_width();
/// Must be called first. Opens standard input, output and error on /dev/null if they are closed; otherwise the next
/// file opened would take their place. Writing to a standard output that was closed still fails. Signals that end the
/// program first remove unfinished files, and say so on standard error if a person or a scheduler sent them. A file
/// that outgrows its limit (ulimit -f) is a write error, not a signal. Signals that the parent ignores (nohup,
/// background jobs) stay ignored.
void prepare_process();
/// After this call the first Ctrl-C or SIGTERM only sets interrupted(); a second one ends the program.
void catch_interrupts();
bool interrupted();
/// The exit code of a command that was interrupted and has written the results so far: the shells' code for Ctrl-C.
constexpr int interrupted_code = 130;
/// From now on these signals end the program at once again, because nothing polls interrupted() any more.
void release_interrupts();

/// The folder of this program; empty: unknown.
std::filesystem::path program_folder();
/// The command line of this process as one would type it, without the folder of the program; empty: not available.
std::string command_text();
/// The processor's name, or "unknown".
std::string processor_name();
/// The operating system and its version, and the machine's memory in bytes; "unknown" and 0 if not available.
std::string system_name();
std::size_t system_memory();
/// The limit of this process's address space (ulimit -v), in bytes; 0: none, or unknown.
std::size_t memory_limit();
/// The most memory that this process has held, and the memory it holds now, in bytes; 0: unknown.
std::size_t peak_memory();
/// Restarts the maximum of peak_memory(). Does nothing if the system does not support it.
void forget_peak_memory();
std::size_t resident_memory();
/// Returns freed memory to the system, so that resident_memory() reports the memory in use.
void trim_memory();

} // namespace oncollide::tools
