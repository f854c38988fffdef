#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/chunk_clock.hpp>
#include <oncollide/scenes/model/map/cell_tree.hpp>

namespace oncollide {

/// The nodes of an occupancy map that is in memory in part: a chunk of nodes is read when one of them is first used.
/// Many threads may do so at once. A derived class reads the chunks.
class MapChunks {
public:
    static constexpr std::uint32_t step = 512; ///< nodes per page; each page is of one chunk

    virtual ~MapChunks() = default;

    const CellTree::Node& node(std::uint32_t number) const
    {
        ONCOLLIDE_ASSERT(number / step < chunk_of_.size());
        if (const std::uint32_t of = chunk_of_[number / step]) {
            const Chunk& chunk = chunks_[of - 1];
            if (!chunk.there.load(std::memory_order_acquire)) need(of - 1);
            clock_.mark(chunk.needed);
        }
        return nodes_[number];
    }
    virtual void need_all() const = 0; ///< Throws ChunkFault
    virtual std::size_t bytes() const = 0;

protected:
    struct Chunk {
        std::atomic<bool> there = false;
        mutable std::atomic<std::uint64_t> needed = 0;
    };
    MapChunks(std::size_t chunks, std::size_t pages, const ChunkClock& clock)
        : chunk_of_(pages), chunks_(chunks), clock_(clock)
    {
    }
    /// Reads a chunk, unless another thread has just done so.
    virtual void need(std::uint32_t chunk) const = 0;

    CellTree::Node* nodes_ = nullptr;
    std::vector<std::uint32_t> chunk_of_; ///< by page: the chunk's number + 1; 0: always in memory
    mutable std::vector<Chunk> chunks_;

private:
    const ChunkClock& clock_;
};

} // namespace oncollide
