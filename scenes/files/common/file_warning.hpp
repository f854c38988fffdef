#pragma once
#include <string>

namespace oncollide {

/// Passes the warning "`file`: `what`" to the watcher of on_file_warning(), on this thread. Private to the readers.
void warn_of_file(const std::string& file, const std::string& what);

} // namespace oncollide
