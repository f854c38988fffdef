#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Refines any pairs with their sphere-trees, which must exist (ModelStore::spheres), in rounds:
///
///     start ──> park ──> requests ──> one batch ──> trees grow ──> resume ──> park ──> ...
///                                       └─ meanwhile the next slice of traversals starts
///
/// until no traversal is parked. Many pairs start in slices, one per round: while a GPU works, the CPU starts
/// traversals, and later slices find most of their cells already grown, which keeps the parked data small. A slice is
/// an eighth of the pairs, at most 16,384, so the number of rounds hardly grows with the number of pairs.
///
/// Parked data are bounded: no slice starts while they use over half of `most_parked_bytes` (with a memory budget, at
/// most a quarter of the budget, but at least a megabyte). Traversals beyond the bound restart from the roots later.
/// This costs time but does not change results, which do not depend on the order of traversals.
class SphereRefiner final : public PairRefiner {
public:
    explicit SphereRefiner(ModelStore& models) : models_(models) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<Finding> results) override;

    /// Limit of the data of parked traversals. The vectors that hold the data may be three times as large.
    static constexpr std::size_t most_parked_bytes = std::size_t{16} << 20;
    static constexpr std::size_t least_parked_bytes = std::size_t{1} << 20; ///< regardless of the budget

private:
    struct Parked {
        std::uint32_t pair, worker;
        int resumed;      ///< number of times the pair was resumed
        WalkResult found; ///< result so far
        ParkedWork work;  ///< entries in the worker's walker
    };
    struct Worker {
        Walker walker;
        std::vector<Parked> parked;
    };

    WalkPair pair_of(std::uint32_t pair) const;
    void settle(std::uint32_t pair, const WalkResult& walk);
    void run_rounds();
    void next_slice();
    void walk_slice();
    bool gather_parked();
    void gather_requests();
    template <class Meanwhile>
    void grow_trees(Meanwhile meanwhile);
    void resume_all();
    void count();

    static constexpr std::size_t pairs_per_chunk = 256, pairs_per_look = 16; ///< per check whether the call should stop
    static constexpr std::size_t pairs_worth_slices = 1024, slices = 8, most_in_slice = 16384;

    ModelStore& models_;
    RefineContext* context_ = nullptr; ///< the context of the current run, like the next three members
    std::span<const PairTask> tasks_;
    PairCache* cache_ = nullptr;
    std::span<Finding> results_;
    std::vector<std::array<int, 2>> depths_; ///< by task: levels where its traversal ends
    bool give_up_ = false;
    std::size_t started_ = 0; ///< number of pairs
    std::size_t slice_size_ = 0;
    std::vector<std::uint32_t> again_; ///< pairs started but postponed; sorted
    std::vector<std::uint32_t> slice_; ///< pairs to start now
    std::size_t parked_room_ = 0;      ///< limit of parked_entries_
    std::size_t parked_entries_ = 0;   ///< entries parked
    std::vector<Worker> workers_, parked_workers_;
    std::vector<Parked> parked_;
    std::vector<CellRequest> requests_;
};

} // namespace oncollide
