#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/broad/box_scenes.hpp"
#include "peers/peers.hpp"

namespace oncollide::tools {

/// The results of a contender in a scene.
struct RaceRow {
    const BroadContender* contender = nullptr;
    int threads = 1;
    double ms = 0;    ///< median of the timed frames: updating the boxes and finding all pairs
    double ratio = 0; ///< time of the best Debian peer on as many threads or fewer, divided by `ms`; 0: no such peer
    double bytes = 0; ///< growth of the process during this contender's start and first frame
    PairSet pairs;    ///< of the last frame
    std::uint64_t missed = 0, extra = 0;   ///< pairs, maximum over frames
    bool delimited = false;                ///< it has delimitation
    std::vector<DelimitationLevel> levels; ///< of the last frame; empty: it was off
    std::uint64_t left = 0;                ///< boxes in regions that were kept
};

struct RaceResult {
    std::vector<RaceRow> rows;     ///< fastest first
    std::vector<std::string> left; ///< contenders that were left out, with the reason
    PairSet pairs;                 ///< the correct result of the last frame
};

/// Plays `frames` frames of `scene` with every contender and every number of threads, alternating within each frame.
/// Frames up to `warm_up` are not timed. The result of every frame is compared with a plain exact grid; a peer
/// that misses a pair or reports one twice is left out from then on.
RaceResult race(BoxScene& scene, const std::vector<BroadContender>& contenders, const std::vector<int>& threads,
                std::uint64_t frames, std::uint64_t warm_up);

} // namespace oncollide::tools
