#pragma once
#include <cstdint>
#include <string>

namespace oncollide::tools {

struct ScaleOptions {
    double bodies = 1e6;
    std::string ranks = "64"; ///< numbers of ranks, each of which shares the whole world
    int sample = 0;           ///< ranks to play; 0: all
    double edge = 1;          ///< mean, in mean spacings
    int frame = 0, threads = 1;
    std::uint64_t seed = 12345;
    std::string csv, shard;
};

/// Ranks of a large uniform world, played one after another on this machine, against the model of their cost. Returns
/// the exit code: 70 where ghosts are off the model by more than a tenth, or two numbers of ranks find different pairs.
int bench_scale(const ScaleOptions& options);

} // namespace oncollide::tools
