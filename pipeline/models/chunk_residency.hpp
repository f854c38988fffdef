#pragma once
#include <cstdint>
#include <mutex>
#include <shared_mutex>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/pipeline/models/prepared_trees.hpp>

namespace oncollide {

/// Which chunks of cooked files are in memory, under a budget.
class ChunkResidency {
public:
    /// Keeps references to the budget, and to the prepared trees, which use it too.
    ChunkResidency(ChunkBudget& budget, const PreparedTrees& prepared) : budget_(budget), prepared_(prepared) {}

    ChunkBudget& budget() const { return budget_; }
    // Models whose OBB trees read chunks. Hold PreparedTrees::lock().
    void add(const Model& model) { trees_.push_back(&model); }
    void remove(const Model& model) { std::erase(trees_, &model); }
    // Terrains, and maps in files.
    void add_grid(const Model& model) { grids_.push_back(&model); }
    void remove_grid(const Model& model) { std::erase(grids_, &model); }

    /// As ModelStore::with_room.
    template <class Work>
    auto with_room(Work work) const;

    std::uint64_t nodes() const; ///< number of nodes of the OBB trees
    std::size_t bytes() const;   ///< bytes of these trees, and of the trees of the grids

private:
    void drop_chunks(std::size_t down_to) const;

    ChunkBudget& budget_;
    const PreparedTrees& prepared_;
    std::vector<const Model*> trees_, grids_;
    /// Locked shared by traversals whose chunks may be dropped.
    mutable OrderedMutex<LockRank::chunks_in_use, SharedMutex> in_use_;
};

template <class Work>
auto ChunkResidency::with_room(Work work) const
{
    if (!budget_.limited()) return work();
    try {
        const std::shared_lock lock(in_use_);
        return work();
    } catch (const NoRoomForChunk&) {
    }
    const std::unique_lock lock(in_use_);
    const Prefetcher::Pause pause = prepared_.pause();
    try {
        drop_chunks(budget_.limit() / 2);
        return work();
    } catch (const NoRoomForChunk&) {
    }
    drop_chunks(0);
    return work();
}

} // namespace oncollide
