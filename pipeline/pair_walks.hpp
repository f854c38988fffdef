#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/pipeline/forest.hpp>
#include <oncollide/pipeline/frame.hpp>

namespace oncollide {

/// Walks many pairs, in rounds:
///
///     pairs walk ──> parked ──> requests ──> one batch ──> trees grow ──> parked pairs walk on ──> ...
///                                              └─ meanwhile the next pairs start to walk
///
/// until none is parked. Many pairs start in slices, one a round: while a GPU answers, the CPU has walks to start, and
/// later slices find most of their cells grown by earlier ones, which keeps what is parked small. The number of slices
/// is bounded, so rounds do not grow with the number of pairs.
class PairWalks {
public:
    explicit PairWalks(Forest& forest) : forest_(forest) {}

    struct Walk {
        BodyPair pair;
        LeafPair hint;     ///< in: what decided the pair last frame
        WalkResult result; ///< out
    };
    /// Walks all; appends to frame.rounds and counts in frame.trees what was asked and compared.
    void run(const Scene& scene, Frame& frame, std::span<Walk> walks);

private:
    struct Parked {
        std::uint32_t walk, worker;
        int resumed;     ///< times that the pair was taken up again
        ParkedWork work; ///< in the worker's walker
    };
    struct Worker {
        Walker walker;
        std::vector<Parked> parked;
    };

    WalkPair pair_of(const Walk& walk);
    void walk(std::size_t first, std::size_t last);
    bool gather_parked();
    void gather_requests();
    void resume_all();
    void run_rounds();
    void count();

    static constexpr std::size_t pairs_a_chunk = 256;
    static constexpr std::size_t pairs_worth_slices = 1024, slices = 8;

    Forest& forest_;
    const Scene* scene_ = nullptr; ///< of the run under way, as what follows
    Frame* frame_ = nullptr;
    std::span<Walk> walks_;
    bool give_up_ = false;
    std::vector<Worker> workers_, parked_workers_;
    std::vector<Parked> parked_;
    std::vector<CellRequest> requests_;
};

} // namespace oncollide
