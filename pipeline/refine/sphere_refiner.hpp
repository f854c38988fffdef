#pragma once
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
/// later slices find most of their cells grown by earlier ones, which keeps what is parked small. The number of slices
/// is bounded, so rounds do not grow with the number of pairs.
class SphereRefiner final : public PairRefiner {
public:
    explicit SphereRefiner(ModelStore& models) : models_(models) {}

    void refine(RefineContext& context, std::span<const PairTask> tasks, PairCache* cache,
                std::span<RefineResult> results) override;

private:
    struct Walk {
        WalkPair pair;
        WalkResult result;
    };
    struct Parked {
        std::uint32_t walk, worker;
        int resumed;     ///< times that the pair was taken up again
        ParkedWork work; ///< in the worker's walker
    };
    struct Worker {
        Walker walker;
        std::vector<Parked> parked;
    };

    WalkPair pair_of(const PairTask& task, LeafPair hint) const;
    void run_rounds();
    void walk(std::size_t first, std::size_t last);
    bool gather_parked();
    void gather_requests();
    template <class Meanwhile>
    void grow_trees(Meanwhile meanwhile);
    void resume_all();
    void count();

    static constexpr std::size_t pairs_per_chunk = 256;
    static constexpr std::size_t pairs_worth_slices = 1024, slices = 8;

    ModelStore& models_;
    RefineContext* context_ = nullptr; ///< of the run under way
    std::vector<Walk> walks_;
    bool give_up_ = false;
    std::vector<Worker> workers_, parked_workers_;
    std::vector<Parked> parked_;
    std::vector<CellRequest> requests_;
};

} // namespace oncollide
