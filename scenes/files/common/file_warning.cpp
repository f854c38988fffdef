#include <oncollide/scenes/files/common/file_warning.hpp>

#include <oncollide/base/text/printable.hpp>
#include <oncollide/scenes/files/geometry_file.hpp>

namespace oncollide {

namespace {

FileWarningWatcher watcher = nullptr;

} // namespace

void on_file_warning(FileWarningWatcher watch)
{
    watcher = watch;
}

void warn_of_file(const std::string& file, const std::string& what)
{
    if (watcher) watcher(printable(file + ": " + what));
}

} // namespace oncollide
