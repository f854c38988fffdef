#pragma once
#include <array>
#include <string>
#include <vector>

#include <oncollide/pipeline/pipeline.hpp>

#include "cli/pairs_file.hpp"

namespace oncollide::tools {

/// A run that was written with --pairs, played again: bodies go where they were, boxes that overlap are found anew, and
/// what the narrow phase found is read from the file.
class StoredFrames {
public:
    /// Throws Error{usage} where results and scene do not belong together, and what StoredResults and open_scene do.
    /// @param scene  in place of the scene that the results name; empty: that one
    StoredFrames(const std::string& results, const std::string& scene, const std::string& data, int threads);

    const Scene& scene() const { return scene_; }
    const Pipeline& pipeline() const { return pipeline_; }
    bool separate() const { return run_.separate; }
    int first() const { return static_cast<int>(stored_.frames().front().frame); }
    int last() const { return static_cast<int>(stored_.frames().back().frame); }

    /// Frame `frame`, first() to last(). Valid until the next call. Throws Error{bad_data} where the file is damaged or
    /// of other bodies.
    FrameView play(int frame);

private:
    void decide(const FrameRow& row, std::span<const PairResult> candidates);
    void count(const FrameRow& row, std::span<const StageStats> stages);
    [[noreturn]] void refuse_scene(const std::string& why) const;

    std::string name_;
    StoredResults stored_;
    StoredRun run_;
    Scene scene_;
    Pipeline pipeline_;
    Mover mover_;
    std::vector<PairRow> rows_;
    std::vector<PairResult> results_;
    std::vector<StageStats> stages_;
};

} // namespace oncollide::tools
