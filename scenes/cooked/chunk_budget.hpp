#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/chunk_clock.hpp>

namespace oncollide {

/// The memory that chunks of all cooked files together may use, and the clock of their last use.
class ChunkBudget : public ChunkClock {
public:
    /// @param limit  bytes; 0: no limit
    explicit ChunkBudget(std::size_t limit) : limit_(limit) {}

    bool limited() const { return limit_ > 0; }
    std::size_t limit() const { return limit_; }
    std::size_t held() const { return held_.load(std::memory_order_relaxed); }
    /// Throws NoRoomForChunk, naming `who`, if the limit would be exceeded.
    void take(std::size_t bytes, const std::string& who);
    void give(std::size_t bytes)
    {
        ONCOLLIDE_ASSERT(bytes <= held());
        held_.fetch_sub(bytes, std::memory_order_relaxed);
    }

private:
    const std::size_t limit_;
    std::atomic<std::size_t> held_ = 0;
};

/// The chunks of one cooked file that are in memory, as seen by the owner of the budget.
class HeldChunks {
public:
    virtual ~HeldChunks() = default;
    struct Held {
        std::uint64_t needed; ///< time of the last use
        std::uint32_t chunk;
    };
    virtual void add_held(std::vector<Held>& to) const = 0;
    /// No traversal may run meanwhile.
    virtual void drop(std::uint32_t chunk) = 0;
};

} // namespace oncollide
