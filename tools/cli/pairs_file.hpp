#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/files/tables/results_file.hpp>

#include "cli/play.hpp"

namespace oncollide::tools {

/// The pairs of every frame, in HDF5 as the frames come (--pairs).
class PairsFile final : public FrameSink {
public:
    /// Where `frame` is not 0 and the file is there, it goes on with its frames before that one, and so does the
    /// pipeline's hash. Throws what ResultsFile does.
    /// @param separate  keep the pairs that were found separate, too
    PairsFile(const std::filesystem::path& path, const Scene& scene, Pipeline& pipeline, int frame, bool separate);

    void add(const FrameView& frame) override;
    void close() override { file_.close(); }

private:
    Pipeline& pipeline_;
    bool separate_;
    ResultsFile file_;
    std::vector<PairRow> rows_;
};

} // namespace oncollide::tools
