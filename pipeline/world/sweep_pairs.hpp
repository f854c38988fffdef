#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/pipeline/world/frame.hpp>

namespace oncollide {

/// Decides the pairs of a frame in which a body is on its way: exactly, with all settings.
class SweepPairs {
public:
    explicit SweepPairs(ModelStore& models) : models_(models) {}
    /// Sets frame.sweeps and the results of these pairs. On entry, frame.results has the results for the ends of the
    /// ways, except of the pairs in frame.swept. A pair did not meet if its distance there exceeds the motion of its
    /// bodies, or if a gap of an earlier frame exceeds all motion since; without coherence, it is swept anyway. Pairs
    /// stay undecided if a budget has no room for a tree, if a file cannot be read, or once the caller stops the frame.
    /// @param stats  the counts of the last stage
    void run(const BodyTable& bodies, Frame& frame, StageStats& stats);

private:
    double moved(const BodyTable& bodies, std::uint32_t slot);
    static bool hulls_stay_apart(const BodyTable& bodies, const PairMemory& memory, const PairResult& last,
                                 double needed);
    bool apart_on_the_way(const BodyTable& bodies, Frame& frame, std::uint32_t pair);
    void sweep(const BodyTable& bodies, Frame& frame);
    static void report(const BodyTable& bodies, Frame& frame, StageStats& stats);

    ModelStore& models_;
    std::vector<double> moved_; ///< by slot: see moved(); negative: not known yet
    struct Open {
        std::uint32_t sweep; ///< index in frame.sweeps
        bool met;            ///< in frame.swept
    };
    std::vector<Open> open_;
    std::vector<PairWorker> workers_; ///< by thread
};

/// The sweep of a pair; undecided if a file cannot be read.
SweepResult sweep_pair(ModelStore& models, PairWorker& worker, const SweepTask& task);

} // namespace oncollide
