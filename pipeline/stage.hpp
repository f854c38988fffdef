#pragma once
#include <memory>
#include <string_view>

#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/pipeline/forest.hpp>
#include <oncollide/pipeline/frame.hpp>

namespace oncollide {

/// One step of a frame. It may keep what does not collide; it must never lose what does.
/// No timing inside: the pipeline's loop times every stage alike.
class Stage {
public:
    virtual ~Stage() = default;
    virtual std::string_view name() const = 0;
    /// What its counts count: "bodies" or "pairs".
    virtual std::string_view unit() const = 0;
    /// Why it had better be skipped on this scene; empty: it should run.
    virtual std::string_view reason_to_skip(const Scene&, const Frame&) const { return {}; }

    /// Fills its columns of `frame` and the counts of `stats`.
    virtual void run(const Scene& scene, Frame& frame, StageStats& stats) = 0;
    /// The safe stand-in for run(): keeps everything.
    virtual void skip(const Scene& scene, Frame& frame, StageStats& stats) = 0;
};

std::unique_ptr<Stage> make_bounds_stage(const Scene& scene);
/// Both keep a reference to `tree`, a kd-tree, which goes on with what delimitation left in it.
std::unique_ptr<Stage> make_delimitation_stage(const Scene& scene, const Settings& settings, BroadPhase& tree);
std::unique_ptr<Stage> make_broad_stage(const Scene& scene, BroadPhaseKind kind, BroadPhase& tree);
/// Keeps a reference to `forest`. The exact stages: exact_stages.hpp.
std::unique_ptr<Stage> make_ocst_stage(const Settings& settings, Forest& forest);

} // namespace oncollide
