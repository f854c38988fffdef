#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/pairs/pair_memory.hpp>

namespace oncollide {

/// The memory of the candidate pairs. An element keeps its address within a frame, and its row while its pair is a
/// candidate.
class PairCache {
public:
    /// Keeps the memory of pairs that were candidates in the last frame, and drops all other memory.
    /// @param pairs  sorted
    /// @param fresh  by slot: true if the memory of the body's pairs is void; empty: false for all
    void begin_frame(std::span<const BodyPair> pairs, std::span<const std::uint8_t> fresh);
    /// The number of pair `i` in the last frame; none if it was no candidate then or its memory was void.
    std::uint32_t earlier(std::size_t i) const { return earlier_[i]; }
    static constexpr std::uint32_t none = ~std::uint32_t{0};
    /// The memory of pair `i` of the frame.
    PairMemory& operator[](std::size_t i)
    {
        ONCOLLIDE_ASSERT(i < now_.size());
        return memories_[now_[i].row];
    }
    /// Returns the first fault of the whole structure as text; empty: it has none. Assertions and tests call it. Cost:
    /// O(pairs).
    std::string validate() const;
    std::size_t bytes() const
    {
        return memories_.capacity() * sizeof(PairMemory) + (now_.capacity() + before_.capacity()) * sizeof(Known) +
               (free_.capacity() + earlier_.capacity()) * sizeof(std::uint32_t);
    }

private:
    struct Known {
        BodyPair pair;
        std::uint32_t row; ///< in memories_
    };
    std::uint32_t make_row();

    std::vector<PairMemory> memories_;
    std::vector<std::uint32_t> free_;    ///< rows
    std::vector<Known> now_, before_;    ///< by pair
    std::vector<std::uint32_t> earlier_; ///< by pair of the frame
};

} // namespace oncollide
