#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace oncollide::tools {

/// A line on standard error that says how far long work has come and how long the rest will take, drawn over itself ten
/// times a second at most. Only on a terminal; gone when the work is done.
class Progress {
public:
    Progress(std::string what, std::size_t total, bool quiet = false);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// One more of the total is done.
    void step();

private:
    using Clock = std::chrono::steady_clock;
    std::string what_;
    std::size_t total_, done_ = 0;
    bool seen_; ///< on a terminal
    Clock::time_point start_ = Clock::now(), shown_ = start_;
};

/// From now on the same is shown of long files as they are read. Nothing where `quiet`.
void show_reading(bool quiet);

} // namespace oncollide::tools
