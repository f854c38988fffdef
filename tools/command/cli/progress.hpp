#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace oncollide::tools {

/// A line on standard error with the progress of long work and the time left, redrawn at most ten times per second. It
/// is shown only on a terminal, and erased when the work is done.
class Progress {
public:
    Progress(std::string what, std::size_t total, bool quiet = false);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Counts one more item as done.
    void step();

private:
    using Clock = std::chrono::steady_clock;
    std::string what_;
    std::size_t total_, done_ = 0;
    bool seen_; ///< on a terminal
    Clock::time_point start_ = Clock::now(), shown_ = start_;
};

/// From now on, shows progress while long files are read, and the warnings of readers, unless `quiet`.
void show_reading(bool quiet);

} // namespace oncollide::tools
