#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/pairs/pair_memory.hpp>

namespace oncollide {

/// Pairs now ... now + count - 1 of a frame were pairs before ... before + count - 1 of the last one.
struct PairRun {
    std::uint32_t now, before, count;
    std::uint32_t now_end() const { return now + count; }
    std::uint32_t before_end() const { return before + count; }
};

/// The memory of the candidate pairs. An element keeps its address within a frame, and its row while its pair is a
/// candidate.
class PairCache {
public:
    /// Keeps the memory of pairs that were candidates in the last frame, and drops all other memory.
    /// @param pairs  sorted
    /// @param changed  for each slot, true if the body changed in any way since the last frame; empty: false for all
    /// @param fresh  the same: true if the memory of the body's pairs is void; each of these bodies is `changed`, too
    void begin_frame(std::span<const BodyPair> pairs, std::span<const std::uint8_t> changed,
                     std::span<const std::uint8_t> fresh);
    /// The frame's pairs that were candidates in the last frame and whose bodies did not change since, ascending.
    std::span<const PairRun> unchanged() const { return unchanged_; }
    /// The memory of pair `i` of the frame.
    PairMemory& operator[](std::size_t i)
    {
        ONCOLLIDE_ASSERT(i < rows_.size());
        return memories_[rows_[i]];
    }
    /// Returns the first fault of the whole structure as text; empty: it has none. Assertions and tests call it. Cost:
    /// O(pairs).
    std::string validate() const;
    std::size_t bytes() const
    {
        return memories_.capacity() * sizeof(PairMemory) +
               (pairs_.capacity() + last_pairs_.capacity()) * sizeof(BodyPair) +
               (rows_.capacity() + last_rows_.capacity() + free_.capacity()) * sizeof(std::uint32_t) +
               unchanged_.capacity() * sizeof(PairRun);
    }

private:
    std::uint32_t make_row();

    std::vector<PairMemory> memories_;
    std::vector<std::uint32_t> free_; ///< rows
    std::vector<BodyPair> pairs_, last_pairs_;
    std::vector<std::uint32_t> rows_, last_rows_; ///< the pairs' rows in memories_
    std::vector<PairRun> unchanged_;
};

} // namespace oncollide
