#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace oncollide::tools {

/// A line on standard error that says how far long work has come, while it is a terminal. Gone when the work is done.
class Progress {
public:
    Progress(std::string what, std::size_t total);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// One more of the total is done.
    void step();

private:
    std::string what_;
    std::size_t total_, done_ = 0;
    bool seen_; ///< somebody can look
    std::chrono::steady_clock::time_point shown_;
};

} // namespace oncollide::tools
