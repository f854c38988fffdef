#include "cli/progress.hpp"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "cli/system.hpp"

namespace oncollide::tools {

Progress::Progress(std::string what, std::size_t total, bool quiet)
    : what_(std::move(what)), total_(total), seen_(!quiet && stderr_is_terminal())
{
}

Progress::~Progress()
{
    if (shown_ != start_) fmt::print(stderr, "\r\033[K");
}

void Progress::step()
{
    ++done_;
    if (!seen_) return;
    const auto now = Clock::now();
    if (now - shown_ < std::chrono::milliseconds(100)) return;
    shown_ = now;
    const double rate = double(done_) / std::chrono::duration<double>(now - start_).count();
    fmt::print(stderr, "\r\033[K{}: {} of {}, {:.1f} per second, {:.0f} s left", what_, done_, total_, rate,
               double(total_ - done_) / rate);
}

} // namespace oncollide::tools
