#pragma once
#include <string>

#include "cli/options.hpp"
#include "cli/outputs.hpp"

namespace oncollide::tools {

/// Options of a run on several processes (docs/many-processes.md).
struct RankOptions {
    std::string rebalance = "auto", partitioner = "morton";
    std::string checkpoint, csv; ///< csv: one row per process
    int checkpoint_every = 100;
    bool resume = false;
    int patience = 600;        ///< seconds
    bool continuous = false;   ///< bodies move on the way from frame to frame
    std::string not_for_ranks; ///< a given option that needs a single process; empty: none
};

void add_rank_options(Arguments command, RankOptions& options);
/// True if mpirun started this process, or if an option is given that only such runs have.
bool wants_ranks(const RankOptions& options);
/// Plays the scene on all processes that mpirun started, or on this single process. Returns the exit code. Errors are
/// thrown only on process 0; the others return their code.
int play_on_ranks(const SceneOptions& scene, const SettingsOptions& settings, const OutputOptions& outputs,
                  const RankOptions& options);

} // namespace oncollide::tools
