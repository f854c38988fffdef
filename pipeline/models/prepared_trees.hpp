#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include <oncollide/base/threads/lock_order.hpp>
#include <oncollide/pipeline/models/prefetcher.hpp>

namespace oncollide {

/// OBB trees of cooked meshes that another thread makes and grows before a pair needs them.
class PreparedTrees {
public:
    /// Keeps a reference to the budget of the trees.
    explicit PreparedTrees(ChunkBudget& chunks) : chunks_(chunks) {}

    /// Makes the thread open these parts and grow their trees; replaces parts that still wait.
    void prepare(std::vector<PrefetchPart> parts);
    /// The frame of requests from now on.
    void begin(std::uint32_t frame);
    /// The thread is idle while the result lives.
    Prefetcher::Pause pause(bool wait = true) const { return Prefetcher::Pause(thread_.get(), wait); }

    using Lock = std::unique_lock<OrderedMutex<LockRank::obb_trees>>;
    /// Meanwhile the thread adds no prepared tree, and does not read which models of cooked meshes have a tree. Hold it
    /// to call the members below.
    Lock lock() const { return Lock(guard_); }
    /// Gives away the prepared tree of a model; null: there is none.
    std::unique_ptr<ObbTree> take(const Model& model);
    /// Drops the prepared tree of a model, and its waiting parts. Call it during a pause.
    void forget(const Model& model);
    /// Drops the trees that were not requested for `age` frames. Call it during a pause.
    void drop(std::uint32_t frame, std::uint32_t age);
    /// Calls visit(tree) for each prepared tree.
    template <class Visit>
    void each(Visit visit) const
    {
        for (const Prepared& prepared : trees_) visit(*prepared.tree);
    }

private:
    struct Prepared {
        const Model* model;
        std::unique_ptr<ObbTree> tree;
        std::uint32_t frame; ///< when it was last requested
    };
    void prepare(const PrefetchPart& part);
    std::vector<Prepared>::iterator find(const Model& model);

    ChunkBudget& chunks_;
    mutable OrderedMutex<LockRank::obb_trees> guard_; ///< guards trees_ and frame_
    std::vector<Prepared> trees_;
    std::uint32_t frame_ = 0;
    std::unique_ptr<Prefetcher> thread_; ///< null until needed; destroyed before the other members
};

} // namespace oncollide
