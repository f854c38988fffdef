#pragma once
#include <array>
#include <string>
#include <vector>

#include <oncollide/runs/pipeline.hpp>

#include "play/pairs_file.hpp"

namespace oncollide::tools {

/// Plays a run that was written with --pairs again: poses and overlapping AABBs are computed anew, and the results of
/// the narrow phase are read from the file.
class StoredFrames {
public:
    /// Throws Error{usage} if results and scene do not fit together, and the errors of StoredResults and open_scene.
    /// @param scene  used in place of the scene named in the results; empty: that scene
    StoredFrames(const std::string& results, const std::string& scene, const std::string& data, int threads);

    const Scene& scene() const { return scene_; }
    const Pipeline& pipeline() const { return pipeline_; }
    bool separate() const { return run_.separate; }
    int first() const { return static_cast<int>(stored_.frames().front().frame); }
    int last() const { return static_cast<int>(stored_.frames().back().frame); }

    /// Plays frame `frame`, first() to last(). Valid until the next call. Throws Error{bad_data} if the file is damaged
    /// or belongs to other bodies.
    FrameView play(int frame);

private:
    FrameView step(int frame);
    void decide(const FrameRow& row, std::span<const PairResult> candidates);
    void add_sweep(const SweepRow& row, std::size_t pair);
    void count(const FrameRow& row, std::span<const StageStats> stages);
    [[noreturn]] void refuse_scene(const std::string& why) const;

    std::string name_;
    StoredResults stored_;
    StoredRun run_;
    Scene scene_;
    Pipeline pipeline_;
    Mover mover_;
    int played_; ///< the frame of the bodies' poses
    std::vector<PairRow> rows_;
    std::vector<SweepRow> sweep_rows_;
    std::vector<PairResult> results_;
    std::vector<PairSweep> sweeps_;
    std::vector<StageStats> stages_;
};

} // namespace oncollide::tools
