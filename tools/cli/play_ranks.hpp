#pragma once
#include <string>

#include "cli/options.hpp"
#include "cli/outputs.hpp"

namespace oncollide::tools {

/// How a scene is played by several processes (docs/many-processes.md).
struct RankOptions {
    std::string rebalance = "auto", partitioner = "zoltan";
    std::string checkpoint, csv; ///< csv: a row for each process
    int checkpoint_every = 100;
    bool resume = false;
    int patience = 600; ///< seconds
};

void add_rank_options(Arguments command, RankOptions& options);
/// Was this process started by mpirun, or is something wanted that only such runs give?
bool wants_ranks(const RankOptions& options);
/// Plays the scene on all processes that mpirun started, or on this one alone. Returns the exit code. Errors are thrown
/// on process 0 only; the others return their code.
int play_on_ranks(const SceneOptions& scene, const SettingsOptions& settings, const OutputOptions& outputs,
                  const RankOptions& options);

} // namespace oncollide::tools
