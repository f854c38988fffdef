#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/pipeline/pipeline.hpp>

namespace oncollide {

/// The version that results carry; a test holds it equal to the project's version in CMakeLists.txt.
inline constexpr std::string_view version = "0.1.0";

class OutputFile;

/// Collects frames and writes them out as JSON, CSV, a Chrome trace, a stage table and a picture.
/// Formats: docs/results.md. Files are written to a temporary name and renamed: whole or not at all.
class Report {
public:
    /// Keeps references to both. Make it before the first step, and add every step: totals and hash are the pipeline's.
    /// @param separate  also keep the pairs that were found separate
    Report(const Scene& scene, const Pipeline& pipeline, bool separate = false);

    void add(const FrameView& frame);
    /// Marks the results as cut short by the user.
    void interrupted() { interrupted_ = true; }

    // Each throws Error{cannot_write} naming the path. "-" writes to standard output.
    void write_json(const std::filesystem::path& path) const;
    void write_csv(const std::filesystem::path& path) const;
    void write_trace(const std::filesystem::path& path) const;
    /// One picture: the stage funnel, and time per frame by stage. SVG.
    void write_picture(const std::filesystem::path& path) const;
    /// The stage table: in, out, culled, undecided, ms per frame; then verdict counts, trees, hash.
    void print_table(std::ostream& out) const;

    /// Pairs of each verdict, indexed by Verdict, over all frames.
    std::array<std::uint64_t, 4> verdicts() const;
    /// Pairs of each kind of contact, indexed by ContactKind, over all frames; separate ones too, if touching is
    /// ignored.
    std::array<std::uint64_t, 5> kinds() const { return kinds_; }

private:
    struct Row {
        std::uint32_t a, b;
        Verdict verdict;
        std::uint8_t stage;
        ContactKind kind;
        double bound;
    };
    struct FrameRow {
        std::uint64_t frame;
        double ms;
        std::uint64_t hash;
        std::size_t first_pair, pairs; ///< its part of rows_
        std::array<std::uint64_t, 4> verdicts;
        TreeStats trees;
        std::size_t first_stage; ///< its part of stage_ms_, as long as Pipeline::stages()
        std::size_t first_round; ///< its part of rounds_, trees.rounds long
    };
    std::string title() const;
    int threads() const; ///< what --threads 0 came to
    void print_header(OutputFile& file) const;
    void print_stages(OutputFile& file) const;
    void print_frames(OutputFile& file) const;

    const Scene& scene_;
    const Pipeline& pipeline_;
    bool separate_, interrupted_ = false;
    std::vector<Row> rows_;
    std::vector<FrameRow> frames_;
    std::array<std::uint64_t, 5> kinds_{};
    std::vector<double> stage_ms_; ///< frames x stages, CPU time
    std::vector<Round> rounds_;
    std::vector<DelimitationLevel> delimitation_; ///< summed over frames
};

} // namespace oncollide
