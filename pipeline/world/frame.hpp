#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/pipeline/refine/pair_refiner.hpp>
#include <oncollide/pipeline/results.hpp>
#include <oncollide/pipeline/settings.hpp>
#include <oncollide/pipeline/world.hpp>
#include <oncollide/pipeline/world/body_table.hpp>

namespace oncollide {

/// Pairs that keep the result of the last frame, by the stages that they passed then.
struct KeptCounts {
    std::uint64_t pairs = 0, left_by_refine = 0, exact = 0, left_by_exact = 0;
    void add(const PairResult& result)
    {
        const bool left = result.verdict != Verdict::separate, by_exact = result.stage == StageId::exact;
        ++pairs, left_by_refine += left || by_exact, exact += by_exact, left_by_exact += left && by_exact;
    }
};

/// Bodies by slot. Cost of clear(): proportional to the bodies in the set.
class SlotSet {
public:
    void resize(std::size_t slots) { marks_.resize(slots); }
    void add(std::span<const std::uint32_t> slots)
    {
        for (const std::uint32_t slot : slots)
            if (!marks_[slot]) marks_[slot] = 1, slots_.push_back(slot);
    }
    void clear()
    {
        for (const std::uint32_t slot : slots_) marks_[slot] = 0;
        slots_.clear();
    }
    bool contains(std::uint32_t slot) const { return marks_[slot]; }
    /// A column by slot: 1 for a body in it. Empty if there is none.
    std::span<const std::uint8_t> marks() const { return slots_.empty() ? std::span<const std::uint8_t>{} : marks_; }

private:
    std::vector<std::uint8_t> marks_;
    std::vector<std::uint32_t> slots_;
};

/// Data that stages pass on: columns, kept between frames so that a warm frame allocates no memory.
/// Column: written by -> read by
///   whole: World -> broad
///   pairs: broad -> refine
///   results: refine, exact -> the caller
struct Frame {
    explicit Frame(const Settings& s) : settings(s), context{.settings = s, .trees = {}, .rounds = {}, .began = {}} {}

    const Settings& settings;
    std::uint32_t number = 0; ///< frames since the World was made

    BodyChanges changes; ///< as of this frame
    // Since the last frame:
    SlotSet fresh;                               ///< bodies that are new or have a new geometry
    SlotSet changed;                             ///< fresh bodies, and bodies with another pose or filter
    bool same_bodies = false;                    ///< since the last frame no body, filter or exclusion changed
    std::uint64_t exclusions_version = 0;        ///< as of this frame
    std::size_t moved = 0;                       ///< bodies that moved since the last frame
    bool whole = false;                          ///< delimitation is skipped by request: search all bodies
    std::vector<DelimitationLevel> delimitation; ///< by level; empty when skipped
    std::vector<BodyPair> pairs;                 ///< candidates, sorted
    PairFilter filter;                           ///< empty: all candidates are refined
    PairCache cache;                             ///< cache of the candidates
    std::vector<PairResult> results;             ///< one per pair, in the same order
    std::vector<PairResult> last_results;        ///< results of the last frame that ended
    std::vector<PairRun> kept;                   ///< pairs that keep their last result, ascending; all others are open
    std::vector<std::uint32_t> open;             ///< pairs to be decided
    std::vector<std::uint32_t> retested;         ///< without coherence, pairs at rest: tested, but without their memory
    std::vector<std::uint32_t> swept;            ///< pairs that sweeps alone decide, as they probably meet at time 0
    std::vector<PairSweep> sweeps;               ///< sweeps of the pairs with a body on its way, ascending
    SweepOptions sweep_options;
    bool parts_by_poses = false; ///< for SweepTask
    KeptCounts kept_counts;      ///< counts of the pairs in `kept`
    bool keeps = false;          ///< the last frame ended, and no budget lets results depend on other pairs
    bool ended = true;           ///< `results` are of a frame that ended
    std::size_t undecided = 0;   ///< pairs of the last frame

    RefineContext context;
};

} // namespace oncollide
