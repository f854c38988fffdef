#include <oncollide/base/reading_progress.hpp>

namespace oncollide {

namespace {

ReadingWatcher watcher = nullptr;
constexpr std::uint64_t least = 1 << 20, step = 1 << 20; // bytes: smallest file reported; interval of reports

} // namespace

void on_reading(ReadingWatcher watch)
{
    watcher = watch;
}

ReadingProgress::ReadingProgress(std::string_view file, std::uint64_t total) : total_(total)
{
    if (watcher && total >= least) file_ = file, next_ = step;
}

ReadingProgress::~ReadingProgress()
{
    if (next_ != never) watcher(file_, total_, total_);
}

void ReadingProgress::tell(std::uint64_t bytes)
{
    next_ = bytes + step;
    if (bytes < total_) watcher(file_, bytes, total_);
}

} // namespace oncollide
