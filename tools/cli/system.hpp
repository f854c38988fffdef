#pragma once
#include <cstddef>
#include <string>

// What only the operating system can say or do. Systems other than Linux have less of it; nothing depends on it.
namespace oncollide::tools {

/// Does somebody see what goes to standard error?
bool stderr_is_terminal();
/// Makes Ctrl-C and SIGTERM set interrupted(); a second one ends the program at once. Signals that the parent wants to
/// be ignored (nohup, background jobs) stay so.
void catch_interrupts();
bool interrupted();
/// They end the program at once again: nothing waits for interrupted() any more.
void release_interrupts();

/// The processor's name, or "unknown".
std::string processor_name();
/// The most memory that this process has held, and what it holds now, bytes; 0: unknown.
std::size_t peak_memory();
std::size_t resident_memory();
/// Gives freed memory back, so that resident_memory() tells what is in use.
void trim_memory();

} // namespace oncollide::tools
