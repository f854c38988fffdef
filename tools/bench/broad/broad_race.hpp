#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bench/broad/box_scenes.hpp"
#include "peers/peer.hpp"

namespace oncollide::tools {

/// What one contender did in one scene.
struct RaceRow {
    const Contender* contender = nullptr;
    int threads = 1;
    double ms = 0;    ///< median of the counted frames: taking in the boxes and finding all pairs
    double ratio = 0; ///< time of the best Debian peer on as many threads or fewer, over this; 0: there was none
    double bytes = 0; ///< by which the process grew while this contender took in the scene and its first frame
    PairSet pairs;    ///< of the last frame
    std::uint64_t missed = 0, extra = 0;   ///< pairs, the most in any frame
    bool delimited = false;                ///< can it rule out regions?
    std::vector<DelimitationLevel> levels; ///< of the last frame; empty: it was off
    std::uint64_t left = 0;                ///< boxes in regions that are left
};

struct RaceResult {
    std::vector<RaceRow> rows;     ///< fastest first
    std::vector<std::string> left; ///< who was left out, and why
    PairSet pairs;                 ///< the right answer of the last frame
};

/// Plays `frames` frames of `scene`, with every contender on every number of threads in each frame, turn about.
/// Frames up to `warm_up` are not counted. Every answer of every frame is compared with that of a plain exact grid; a
/// peer that misses a pair or reports one twice is left out from then on.
RaceResult race(BoxScene& scene, const std::vector<Contender>& contenders, const std::vector<int>& threads,
                std::uint64_t frames, std::uint64_t warm_up);

} // namespace oncollide::tools
