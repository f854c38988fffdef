#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/narrowphase/spheres/walk.hpp>
#include <oncollide/pipeline/pipeline.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// What stages hand to each other: columns, kept from frame to frame so that a warm frame allocates nothing.
/// Written by                     who reads it
///   boxes          bounds        -> delimitation, broad
///   survivors      delimitation  -> broad
///   pairs          broad         -> ocst
///   results        ocst, exact   -> the caller
struct Frame {
    const Settings* settings = nullptr;
    std::uint32_t number = 0; ///< frames since the pipeline was made
    int threads = 1;

    std::vector<Aabb> boxes;                     ///< by body; world, metres
    bool delimited = false;                      ///< what survives is in the tree that the stages share
    std::vector<std::uint32_t> survivors;        ///< bodies that may collide, ascending; unless the tree has them
    std::vector<DelimitationLevel> delimitation; ///< by level; empty when skipped
    std::vector<BodyPair> pairs;                 ///< candidates, sorted
    std::vector<PairResult> results;             ///< one a pair, in the same order
    std::vector<Round> rounds;                   ///< batches asked of the backend, in order
    TreeStats trees;

    std::chrono::steady_clock::time_point began;
    /// Milliseconds since the frame began.
    double clock_ms() const
    {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count();
    }
};

} // namespace oncollide
