#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/pipeline/model_store.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>

namespace oncollide {

/// Any pairs by their sphere-trees, which must be there (ModelStore::spheres), in rounds:
///
///     pairs walk ──> parked ──> requests ──> one batch ──> trees grow ──> parked pairs walk on ──> ...
///                                              └─ meanwhile the next pairs start to walk
///
/// until none is parked. Many pairs start in slices, one per round: while a GPU works, the CPU has walks to start, and
/// later slices find most of their cells grown by earlier ones, which keeps what is parked small. Slices are an eighth
/// of the pairs, so rounds hardly grow with the number of pairs, but at most 16,384 of them.
///
/// What is parked is bounded: no slice starts while it takes over half of `most_parked_bytes` (with a memory budget, a
/// quarter of that if it is less, but a megabyte), and what goes beyond starts again from its roots later. That costs
/// time, but changes no result, as these do not depend on the order of a walk.
class SphereRefiner final : public PairRefiner {
public:
    explicit SphereRefiner(ModelStore& models) : models_(models) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<RefineResult> results) override;

    /// Of parked walks. The vectors that hold them may be three times as large.
    static constexpr std::size_t most_parked_bytes = std::size_t{16} << 20;
    static constexpr std::size_t least_parked_bytes = std::size_t{1} << 20; ///< however small the budget

private:
    struct Parked {
        std::uint32_t pair, worker;
        int resumed;      ///< times that the pair was taken up again
        WalkResult found; ///< so far
        ParkedWork work;  ///< in the worker's walker
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

    static constexpr std::size_t pairs_per_chunk = 256, pairs_per_look = 16; ///< at whether the call is to stop
    static constexpr std::size_t pairs_worth_slices = 1024, slices = 8, most_in_slice = 16384;

    ModelStore& models_;
    RefineContext* context_ = nullptr; ///< of the run under way, and so the next three
    std::span<const PairTask> tasks_;
    PairCache* cache_ = nullptr;
    std::span<RefineResult> results_;
    std::vector<std::array<int, 2>> depths_; ///< by task: at which its walk ends; the trees' may grow meanwhile
    bool give_up_ = false;
    std::size_t started_ = 0; ///< pairs
    std::size_t slice_size_ = 0;
    std::vector<std::uint32_t> again_; ///< started, and put back; sorted
    std::vector<std::uint32_t> slice_; ///< pairs to start now
    std::size_t parked_room_ = 0;      ///< entries that may be parked
    std::size_t parked_entries_ = 0;   ///< that are
    std::vector<Worker> workers_, parked_workers_;
    std::vector<Parked> parked_;
    std::vector<CellRequest> requests_;
};

} // namespace oncollide
