#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

namespace oncollide {

/// Calls `watch` at intervals with the bytes of a large file read so far, on the reading thread, and once at the end
/// with all of them; null: no calls. Intended for progress displays. Call only while no file is being read.
using ReadingWatcher = void (*)(const std::string& file, std::uint64_t bytes, std::uint64_t total);
void on_reading(ReadingWatcher watch);

/// Progress of one reading of a file. Each update costs one comparison.
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
