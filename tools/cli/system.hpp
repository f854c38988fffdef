#pragma once
#include <cstddef>
#include <string>

// What only the operating system can say or do. Systems other than Linux have less of it; nothing depends on it.
namespace oncollide::tools {

/// Says which file that is, whatever name or link leads to it; empty: there is none.
std::string file_identity(const std::string& path);

/// Does somebody see what goes to standard output, to standard error?
bool stdout_is_terminal();
bool stderr_is_terminal();
/// Of the terminal that standard output is; otherwise, and of very wide ones, 100. At least 40.
std::size_t terminal_width();
/// To be called first. Standard input, output and error are open afterwards, on /dev/null where they were closed: else
/// the next file opened would be one of them. Signals that end the program remove unfinished files before. A file that
/// outgrows its limit (ulimit -f) is an error of writing, no signal. What the parent wants to be ignored (nohup,
/// background jobs) stays so.
void prepare_process();
/// From now on the first Ctrl-C or SIGTERM only sets interrupted(); a second one ends the program.
void catch_interrupts();
bool interrupted();
/// They end the program at once again: nothing waits for interrupted() any more.
void release_interrupts();

/// The processor's name, or "unknown".
std::string processor_name();
/// The operating system and its version, and the machine's memory in bytes; "unknown" and 0 where nothing says.
std::string system_name();
std::size_t system_memory();
/// The most memory that this process has held, and what it holds now, bytes; 0: unknown.
std::size_t peak_memory();
/// From now on peak_memory() is the most since now. Where the system cannot do that, nothing happens.
void forget_peak_memory();
std::size_t resident_memory();
/// Gives freed memory back, so that resident_memory() tells what is in use.
void trim_memory();

} // namespace oncollide::tools
