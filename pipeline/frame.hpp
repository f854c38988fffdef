#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include <oncollide/pipeline/bodies.hpp>
#include <oncollide/pipeline/refine/pair_refiner.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>

namespace oncollide {

/// What stages hand to each other: columns, kept from frame to frame so that a warm frame allocates nothing.
/// Written by                     who reads it
///   whole          World         -> broad
///   pairs          broad         -> ocst
///   results        ocst, exact   -> the caller
struct Frame {
    explicit Frame(const Settings& s) : settings(s), context{.settings = s, .trees = {}, .rounds = {}, .began = {}} {}

    const Settings& settings;
    std::uint32_t number = 0; ///< frames since the World was made

    BodyChanges changes;                         ///< as they were last taken in
    std::vector<std::uint8_t> fresh;             ///< by slot: since the last frame the body is new, or its geometry is
    std::vector<std::uint32_t> fresh_slots;      ///< the slots that are
    std::size_t moved = 0;                       ///< bodies that moved since the last frame
    bool whole = false;                          ///< delimitation is left out by request: all bodies are to be searched
    std::vector<DelimitationLevel> delimitation; ///< by level; empty when skipped
    std::vector<BodyPair> pairs;                 ///< candidates, sorted
    /// Leaves of the candidates those that this World is to decide, and may turn them round; null: all (RankWorld).
    std::function<void(const Bodies&, std::vector<BodyPair>&)> choose;
    PairCache cache;                             ///< of these
    std::vector<PairResult> results;             ///< one per pair, in the same order
    RefineContext context;
};

} // namespace oncollide
