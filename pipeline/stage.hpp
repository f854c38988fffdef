#pragma once
#include <memory>
#include <string_view>

#include <oncollide/pipeline/frame.hpp>
#include <oncollide/pipeline/model_store.hpp>

namespace oncollide {

// Indices of the stages, as in PairResult::stage.
constexpr std::uint8_t ocst_stage_index = 3, exact_stage_index = 4;

// StageStats::note of a stage that the settings leave out, and of one without anything to narrow down.
constexpr std::string_view by_request = "by request", no_candidates = "no candidates";

/// One step of a frame. It may keep what does not collide; it must never lose what does.
/// No timing inside: the loop outside times every stage alike.
class Stage {
public:
    virtual ~Stage() = default;
    virtual std::string_view name() const = 0;
    /// What its counts count: "bodies" or "pairs".
    virtual std::string_view unit() const = 0;
    /// Why it had better be skipped in this frame; empty: it should run.
    virtual std::string_view reason_to_skip(const Bodies&, const Frame&) const { return {}; }

    /// Fills its columns of `frame` and the counts of `stats`.
    virtual void run(Bodies& bodies, Frame& frame, StageStats& stats) = 0;
    /// The safe stand-in for run(): keeps everything.
    virtual void skip(Bodies& bodies, Frame& frame, StageStats& stats) = 0;
};

// All keep references to what they are given.
std::unique_ptr<Stage> make_bounds_stage();
std::unique_ptr<Stage> make_delimitation_stage(BroadPhase& broad);
std::unique_ptr<Stage> make_broad_stage(BroadPhase& broad);
std::unique_ptr<Stage> make_ocst_stage(const Settings& settings, ModelStore& models);
std::unique_ptr<Stage> make_exact_stage(const Settings& settings, ModelStore& models);

} // namespace oncollide
