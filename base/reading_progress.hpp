#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace oncollide {

/// Calls `watch` now and then with how much of a long file is read, by the thread that reads, and at the end with all
/// of it; null: nobody. For a program that shows it; set while nothing is read.
using ReadingWatcher = void (*)(const std::string& file, std::uint64_t bytes, std::uint64_t total);
void on_reading(ReadingWatcher watch);

/// How far one reading of a file has come. Costs a comparison each time.
class ReadingProgress {
public:
    ReadingProgress(std::string_view file, std::uint64_t total);
    ~ReadingProgress();
    ReadingProgress(const ReadingProgress&) = delete;
    ReadingProgress& operator=(const ReadingProgress&) = delete;

    void at(std::uint64_t bytes)
    {
        if (bytes >= next_) tell(bytes);
    }

private:
    void tell(std::uint64_t bytes);

    static constexpr std::uint64_t never = std::numeric_limits<std::uint64_t>::max();
    std::string file_;
    std::uint64_t total_, next_ = never;
};

} // namespace oncollide
