#include "cli/progress.hpp"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "cli/system.hpp"

namespace oncollide::tools {

namespace {

/// "48 s", "12 min 5 s" or "3 h 20 min".
std::string duration_text(double seconds)
{
    if (!(seconds < 1e7)) return "very long";
    const auto s = static_cast<long>(seconds + 0.5);
    if (s < 60) return fmt::format("{} s", s);
    if (s < 3600) return fmt::format("{} min {} s", s / 60, s % 60);
    return fmt::format("{} h {} min", s / 3600, s / 60 % 60);
}

} // namespace

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
    fmt::print(stderr, "\r\033[K{}: {} of {}, {:.1f} per second, {} left", what_, done_, total_, rate,
               duration_text(double(total_ - done_) / rate));
}

} // namespace oncollide::tools
