#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include <oncollide/scenes/files/tables/results_file.hpp>

#include "cli/options.hpp"
#include "play/play.hpp"

namespace oncollide::tools {

/// Writes the pairs of every frame to HDF5 as each frame is done (--pairs).
class PairsFile final : public FrameSink {
public:
    /// If `frame` is not 0 and the file exists, keeps its frames before `frame` and appends; the pipeline's hash is
    /// restored accordingly. Throws the errors of ResultsFile.
    /// @param source    the options that opened `scene`; stored in the file
    /// @param separate  also keep separate pairs
    PairsFile(const std::filesystem::path& path, const SceneOptions& source, const Scene& scene, Pipeline& pipeline,
              int frame, bool separate);

    void add(const FrameView& frame) override;
    void close() override { file_.close(); }

private:
    Pipeline& pipeline_;
    bool separate_;
    ResultsFile file_;
    std::vector<PairRow> rows_;
    std::vector<SweepRow> sweeps_;
};

/// The run that a results file describes.
struct StoredRun {
    SceneOptions scene; ///< without a name if it was read from standard input
    Settings settings;  ///< without settings that never change a result
    bool separate;      ///< the file also has separate pairs
    bool continuous;    ///< bodies moved on the way from frame to frame
};
/// Throws Error{no_input} for a missing file, and the errors of StoredResults.
StoredResults open_pairs(const std::filesystem::path& path);
/// Throws Error{usage} for a file of another version.
StoredRun stored_run(const std::string& name, const ResultsHeader& header);

} // namespace oncollide::tools
