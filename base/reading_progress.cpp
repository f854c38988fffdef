#include <oncollide/base/reading_progress.hpp>

namespace oncollide {

namespace {

ReadingWatcher reading_watcher = nullptr;
constexpr std::uint64_t least = 1 << 20, step = 1 << 20; // bytes: smallest file reported; interval of reports

} // namespace

void on_reading(ReadingWatcher watch)
{
    reading_watcher = watch;
}

ReadingProgress::ReadingProgress(std::string_view file, std::uint64_t total) : total_(total)
{
    if (reading_watcher && total >= least) file_ = file, next_ = step;
}

ReadingProgress::~ReadingProgress()
{
    if (next_ != never) reading_watcher(file_, total_, total_);
}

void ReadingProgress::tell(std::uint64_t bytes)
{
    next_ = bytes + step;
    if (bytes < total_) reading_watcher(file_, bytes, total_);
}

} // namespace oncollide
