#pragma once
#include <vector>

#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/pipeline/world/frame.hpp>
#include <oncollide/pipeline/world/stage.hpp>

namespace oncollide {

/// Decides the pairs of a frame in which a body is on its way: exactly, with all settings.
class SweepPairs {
public:
    explicit SweepPairs(ModelStore& models) : models_(models) {}
    /// Sets frame.sweeps and the results of frame.swept, which so far hold bounds from the boxes. Pairs stay undecided
    /// if a budget has no room for a tree, if a file cannot be read, or once the caller stops the frame.
    void run(const Bodies& bodies, Frame& frame, StageStats& stats);

private:
    ModelStore& models_;
    std::vector<PairWorker> workers_; ///< by thread
};

/// The sweep of a pair; undecided if a file cannot be read.
SweepResult sweep_pair(ModelStore& models, PairWorker& worker, const SweepTask& task);

} // namespace oncollide
