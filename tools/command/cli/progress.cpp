#include "cli/progress.hpp"

#include <filesystem>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include <oncollide/base/reading_progress.hpp>
#include <oncollide/base/text/file_warning.hpp>
#include <oncollide/base/text/printable.hpp>

#include "cli/log.hpp"
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

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds between_lines{100};

/// The file being read; if several are read at once, the one that began first.
class Reading {
public:
    void tell(const std::string& file, std::uint64_t bytes, std::uint64_t total)
    {
        const std::lock_guard lock(mutex_);
        const auto now = Clock::now();
        if (file_.empty()) file_ = file, start_ = shown_ = now;
        if (file != file_) return;
        if (bytes == total) {
            if (shown_ != start_) write_to_stderr(clear_line);
            file_.clear();
        } else if (now - shown_ >= between_lines) {
            shown_ = now;
            const double rate = double(bytes) / std::chrono::duration<double>(now - start_).count();
            const std::string name = printable(std::filesystem::path(file).filename().string());
            write_to_stderr(fmt::format("{}reading {}: {:.0f} of {:.0f} MB, {:.1f} MB per second, {} left", clear_line,
                                        name.substr(0, 30), double(bytes) / 1e6, double(total) / 1e6, rate / 1e6,
                                        duration_text(double(total - bytes) / rate)));
        }
    }

private:
    std::mutex mutex_;
    std::string file_; ///< empty: none
    Clock::time_point start_, shown_;
};

} // namespace

Progress::Progress(std::string what, std::size_t total, bool quiet)
    : what_(std::move(what)), total_(total), seen_(!quiet && stderr_is_terminal())
{
}

Progress::~Progress()
{
    if (shown_ != start_) write_to_stderr(clear_line);
}

void Progress::step()
{
    ++done_;
    if (!seen_) return;
    const auto now = Clock::now();
    if (now - shown_ < between_lines) return;
    shown_ = now;
    const double rate = double(done_) / std::chrono::duration<double>(now - start_).count();
    write_to_stderr(fmt::format("{}{}: {} of {}, {:.1f} per second, {} left", clear_line, what_, done_, total_, rate,
                                duration_text(double(total_ - done_) / rate)));
}

namespace {

void print_warning(const std::string& line)
{
    log(LogLevel::warning, line);
}

} // namespace

void show_reading(bool quiet)
{
    watch_file_warnings(quiet ? nullptr : print_warning);
    if (quiet || !stderr_is_terminal()) return on_reading(nullptr);
    on_reading([](const std::string& file, std::uint64_t bytes, std::uint64_t total) {
        static Reading reading;
        reading.tell(file, bytes, total);
    });
}

} // namespace oncollide::tools
