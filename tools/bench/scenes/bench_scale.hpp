#pragma once
#include <cstdint>
#include <string>

namespace oncollide::tools {

struct ScaleOptions {
    double bodies = 1e6;
    std::string ranks = "64"; ///< numbers of ranks; each number divides the whole world
    int sample = 0;           ///< ranks to play; 0: all
    double edge = 1;          ///< mean, in mean spacings
    int frame = 0, threads = 1;
    std::uint64_t seed = 12345;
    std::string csv, shard;
};

/// Plays ranks of a large uniform world one after another on this machine, and compares them with a cost model. Returns
/// the exit code: 70 if ghosts differ from the model by more than a tenth, or two numbers of ranks find different
/// pairs.
int bench_scale(const ScaleOptions& options);

} // namespace oncollide::tools
