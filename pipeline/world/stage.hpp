#pragma once
#include <memory>
#include <string_view>

#include <oncollide/pipeline/models/model_store.hpp>
#include <oncollide/pipeline/world/frame.hpp>

namespace oncollide {

class GpuPairs;

// StageStats::note of a stage that the settings skip, and of a stage without input.
constexpr std::string_view by_request = "by request", no_candidates = "no candidates";

/// One step of a frame. It may keep bodies and pairs that do not collide; it must never drop any that collide.
/// Stages do not measure time: the loop that calls them does.
class Stage {
public:
    virtual ~Stage() = default;
    virtual StageId id() const = 0;
    /// The unit of its counts: "bodies" or "pairs".
    virtual std::string_view unit() const = 0;
    /// The reason to skip the stage in this frame; empty: run it.
    virtual std::string_view reason_to_skip(const BodyTable&, const Frame&) const { return {}; }

    /// Fills the stage's columns of `frame` and the counts of `stats`.
    virtual void run(BodyTable& bodies, Frame& frame, StageStats& stats) = 0;
    /// The safe substitute for run(): keeps everything.
    virtual void skip(BodyTable& bodies, Frame& frame, StageStats& stats) = 0;
};

// The stages keep references to their arguments.
std::unique_ptr<Stage> make_bounds_stage();
std::unique_ptr<Stage> make_delimitation_stage(BroadPhase& broad);
std::unique_ptr<Stage> make_broad_stage(BroadPhase& broad);
std::unique_ptr<Stage> make_refine_stage(const Settings& settings, ModelStore& models, GpuPairs* gpu);
std::unique_ptr<Stage> make_exact_stage(const Settings& settings, ModelStore& models, GpuPairs* gpu);

} // namespace oncollide
