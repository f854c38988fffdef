#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/pipeline/refine/pair_refiner.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/pipeline/world/bodies.hpp>

namespace oncollide {

/// Data that stages pass on: columns, kept between frames so that a warm frame allocates no memory.
/// Column: written by -> read by
///   whole: World -> broad
///   pairs: broad -> refine
///   results: refine, exact -> the caller
struct Frame {
    explicit Frame(const Settings& s) : settings(s), context{.settings = s, .trees = {}, .rounds = {}, .began = {}} {}

    const Settings& settings;
    std::uint32_t number = 0; ///< frames since the World was made

    BodyChanges changes;                         ///< as of this frame
    std::vector<std::uint8_t> fresh;             ///< by slot: true if since the last frame the body is new or its
                                                 ///< geometry changed
    std::vector<std::uint32_t> fresh_slots;      ///< the slots with fresh[slot] set
    std::size_t moved = 0;                       ///< bodies that moved since the last frame
    bool whole = false;                          ///< delimitation is skipped by request: search all bodies
    std::vector<DelimitationLevel> delimitation; ///< by level; empty when skipped
    std::vector<BodyPair> pairs;                 ///< candidates, sorted
    PairFilter filter;                           ///< empty: all candidates are refined
    PairCache cache;                             ///< of the candidates
    std::vector<PairResult> results;             ///< one per pair, in the same order
    RefineContext context;
};

} // namespace oncollide
