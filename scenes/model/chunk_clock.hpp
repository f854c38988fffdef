#pragma once
#include <atomic>
#include <cstdint>

namespace oncollide {

/// The clock of the last use of chunks: it advances with each chunk that is read.
class ChunkClock {
public:
    std::uint64_t now() const { return now_.load(std::memory_order_relaxed); }
    void advance() { now_.fetch_add(1, std::memory_order_relaxed); }
    /// Records the present time as the last use.
    void mark(std::atomic<std::uint64_t>& needed) const
    {
        if (const std::uint64_t at = now(); needed.load(std::memory_order_relaxed) != at)
            needed.store(at, std::memory_order_relaxed);
    }

private:
    std::atomic<std::uint64_t> now_ = 1;
};

} // namespace oncollide
