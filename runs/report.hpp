#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <oncollide/base/error.hpp>
#include <oncollide/runs/pipeline.hpp>

namespace oncollide {

class JsonWriter;

/// The data that a report keeps of each frame, besides sums.
struct ReportParts {
    bool json = true, csv = true, trace = true; ///< the files that can be written at the end
    bool separate = false;                      ///< also list separate pairs
    std::filesystem::path folder{};             ///< for data that do not fit in memory; empty: the system's temporary
                                                ///< folder
};

/// Settings in JSON, as in results.
ONCOLLIDE_API std::string settings_json(const Settings& settings);

/// Collects frames and writes them as JSON, CSV, a Chrome trace, a stage table and a picture.
/// Formats: docs/results.md. Files are written under a temporary name and renamed: complete or not at all.
///
/// Frames are kept as text, with at most a megabyte per part in memory (Spool), so memory does not grow with the length
/// of the run. A part that is not requested keeps only sums.
class ONCOLLIDE_API Report {
public:
    /// Keeps references to both. Construct it before the first step and add every step: totals and hash are the
    /// pipeline's. Another thread may write files while the pipeline steps, but not during add().
    Report(const Scene& scene, const Pipeline& pipeline, const ReportParts& parts = {});
    ~Report();

    /// Throws Error{cannot_write} if the disk is full.
    void add(const FrameView& frame);
    /// Marks the results as cut short by the user.
    void interrupted() { interrupted_ = true; }
    std::uint64_t frames() const { return frames_; }

    // All throw Error{cannot_write} naming the path, and Error{usage} if the part was not kept. "-" is standard output.
    void write_json(const std::filesystem::path& path) const;
    /// @param first_line  written before the header, must include its line break; empty: none
    void write_csv(const std::filesystem::path& path, std::string_view first_line = {}) const;
    void write_trace(const std::filesystem::path& path) const;
    /// An SVG picture: counts per stage, and time per frame by stage.
    void write_picture(const std::filesystem::path& path) const;
    /// The stage table: in, out, ruled out, undecided, ms per frame; then verdict counts, trees, hash, and the names of
    /// the first pairs that collide or may collide.
    void print_table(std::ostream& out) const;

    /// Pairs of each verdict, indexed by Verdict, over all frames.
    std::array<std::uint64_t, 4> verdicts() const { return verdicts_; }
    /// Number of pairs of each kind of contact, indexed by ContactKind, over all frames; includes separate pairs if
    /// touching is ignored.
    std::array<std::uint64_t, 5> kinds() const { return kinds_; }

private:
    struct ONCOLLIDE_LOCAL Kept; ///< the data kept of each frame
    using Verdicts = std::array<std::uint64_t, 4>;

    bool keeps(const PairResult& pair) const { return pair.verdict != Verdict::separate || separate_; }
    void add_json(const FrameView& frame, const Verdicts& verdicts);
    void add_csv(const FrameView& frame);
    void add_trace(const FrameView& frame, const Verdicts& verdicts);
    void add_sums(const FrameView& frame);
    void look_at_pipeline(std::span<const StageStats> totals);
    std::string title() const;
    int threads() const; ///< the number that threads = 0 resolves to
    void write_header(JsonWriter& json) const;
    void write_stages(JsonWriter& json) const;
    void write_delimitation(JsonWriter& json) const;

    const Scene& scene_;
    const Pipeline& pipeline_;
    bool separate_, interrupted_ = false;
    std::unique_ptr<Kept> kept_;
    std::uint64_t frames_ = 0, pairs_ = 0; ///< pairs: kept, or that would be kept
    Verdicts verdicts_{};
    std::array<std::uint64_t, 5> kinds_{};
    double ms_ = 0, slowest_ms_ = 0;
    TreeStats trees_; ///< sums; nodes and bytes are as of the last frame
    std::uint64_t peak_nodes_ = 0;
    std::size_t peak_bytes_ = 0;
    std::vector<DelimitationLevel> delimitation_; ///< summed over frames
    // As of the last frame:
    std::vector<StageStats> totals_;
    std::uint64_t hash_ = 0;
    std::string backend_, renderer_, backend_note_;
};

} // namespace oncollide
