#include "cli/progress.hpp"

#include <cstdio>
#include <unistd.h>
#include <utility>

namespace oncollide::tools {

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)), total_(total), seen_(::isatty(STDERR_FILENO)), shown_(std::chrono::steady_clock::now())
{
}

Progress::~Progress()
{
    if (seen_) std::fputs("\r\033[K", stderr);
}

void Progress::step()
{
    ++done_;
    if (!seen_) return;
    const auto now = std::chrono::steady_clock::now();
    if (now - shown_ < std::chrono::milliseconds(100)) return;
    shown_ = now;
    std::fprintf(stderr, "\r\033[K%s: %zu of %zu", what_.c_str(), done_, total_);
}

} // namespace oncollide::tools
