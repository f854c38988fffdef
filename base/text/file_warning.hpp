#pragma once
#include <string>

namespace oncollide {

/// Passes the warning "`file`: `what`" to the watcher, on this thread.
void warn_of_file(const std::string& file, const std::string& what);

/// Calls `watch` with each warning; see on_file_warning() of scenes/files. Null: warnings are dropped.
void watch_file_warnings(void (*watch)(const std::string& line));

} // namespace oncollide
