#pragma once
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include <oncollide/pipeline/pipeline.hpp>

namespace oncollide {

/// Collects frames and writes them out as JSON, CSV, a Chrome trace and a stage table.
/// Formats: docs/results.md. Files are written to a temporary name and renamed: whole or not at all.
class Report {
public:
    /// @param separate  also keep the pairs that were found separate
    Report(const Scene& scene, const Pipeline& pipeline, bool separate = false);

    void add(const FrameView& frame);
    /// Marks the results as cut short by the user.
    void interrupted() { interrupted_ = true; }

    // Each throws Error{cannot_write} naming the path. "-" writes to standard output.
    void write_json(const std::filesystem::path& path) const;
    void write_csv(const std::filesystem::path& path) const;
    void write_trace(const std::filesystem::path& path) const;
    /// The stage table: in, out, culled, undecided, ms per frame; then verdict counts, trees, hash.
    void print_table(std::ostream& out) const;
    /// One picture: the stage funnel, and time per frame by stage. SVG.
    void write_picture(const std::filesystem::path& path) const;

private:
    struct Row { std::uint32_t a, b; Verdict verdict; std::uint8_t stage; double bound; };
    struct FrameRow {
        std::uint64_t frame;
        double ms;
        std::size_t first_pair, pairs;
        std::uint64_t verdicts[4];
        TreeStats trees;
        std::size_t first_stage; ///< into stage_ms_
    };
    const Scene& scene_;
    const Pipeline& pipeline_;
    bool separate_, interrupted_ = false;
    std::vector<Row> rows_;
    std::vector<FrameRow> frames_;
    std::vector<double> stage_ms_; ///< frames x stages
    std::vector<DelimitationLevel> delimitation_; ///< summed over frames
};

} // namespace oncollide
