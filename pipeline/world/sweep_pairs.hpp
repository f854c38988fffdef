#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/pipeline/world/frame.hpp>

namespace oncollide {

/// Decides the pairs of a frame in which a body is on its way: exactly, with all settings.
class SweepPairs {
public:
    explicit SweepPairs(ModelStore& models) : models_(models) {}
    /// Sets frame.sweeps and the results of these pairs. On entry, frame.results has the results for the ends of the
    /// ways. A pair did not meet if its distance there exceeds the motion of its bodies. Pairs stay undecided if a
    /// budget has no room for a tree, if a file cannot be read, or once the caller stops the frame.
    void run(const Bodies& bodies, Frame& frame);

private:
    bool apart_on_the_way(const Bodies& bodies, const Frame& frame, std::uint32_t pair);
    void sweep(const Bodies& bodies, Frame& frame);

    ModelStore& models_;
    std::vector<double> moved_;       ///< by slot: upper bound on the motion in this frame; negative: not known yet
    std::vector<std::uint32_t> open_; ///< indices in frame.sweeps
    std::vector<PairWorker> workers_; ///< by thread
};

/// The sweep of a pair; undecided if a file cannot be read.
SweepResult sweep_pair(ModelStore& models, PairWorker& worker, const SweepTask& task);

} // namespace oncollide
