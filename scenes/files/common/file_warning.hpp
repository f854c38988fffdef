#pragma once
#include <string>

namespace oncollide {

// Private to the readers of files.

/// Passes the warning "`file`: `what`" to the watcher, on this thread.
void warn_of_file(const std::string& file, const std::string& what);

/// on_file_warning()
void watch_file_warnings(void (*watch)(const std::string& line));

} // namespace oncollide
