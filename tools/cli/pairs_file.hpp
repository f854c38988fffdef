#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/files/tables/results_file.hpp>

#include "cli/options.hpp"
#include "cli/play.hpp"

namespace oncollide::tools {

/// The pairs of every frame, in HDF5 as the frames come (--pairs).
class PairsFile final : public FrameSink {
public:
    /// Where `frame` is not 0 and the file is there, it goes on with its frames before that one, and so does the
    /// pipeline's hash. Throws what ResultsFile does.
    /// @param source    what `scene` was opened with: the file tells of it
    /// @param separate  keep the pairs that were found separate, too
    PairsFile(const std::filesystem::path& path, const SceneOptions& source, const Scene& scene, Pipeline& pipeline,
              int frame, bool separate);

    void add(const FrameView& frame) override;
    void close() override { file_.close(); }

private:
    Pipeline& pipeline_;
    bool separate_;
    ResultsFile file_;
    std::vector<PairRow> rows_;
};

/// The run that such a file is of.
struct StoredRun {
    SceneOptions scene; ///< no name: it was read from standard input
    Settings settings;  ///< but for what never changes a result
    bool separate;      ///< pairs that were found separate are there, too
};
/// Throws Error{no_input} for a missing file, and what StoredResults does.
StoredResults open_pairs(const std::filesystem::path& path);
/// Throws Error{usage} for a file of another version.
StoredRun stored_run(const std::string& name, const ResultsHeader& header);

} // namespace oncollide::tools
