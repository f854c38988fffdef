#include <oncollide/base/text/file_warning.hpp>

#include <oncollide/base/text/printable.hpp>

namespace oncollide {

namespace {

void (*warning_watcher)(const std::string&) = nullptr;

} // namespace

void watch_file_warnings(void (*watch)(const std::string&))
{
    warning_watcher = watch;
}

void warn_of_file(const std::string& file, const std::string& what)
{
    if (warning_watcher) warning_watcher(printable(file + ": " + what));
}

} // namespace oncollide
