#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/scene.hpp>

namespace oncollide {

// Results in HDF5, written frame by frame during a run. The layout: docs/results.md.

/// Data of a results file that apply to all its frames.
struct ResultsHeader {
    std::string version, scene, settings;
    std::string source; ///< the scene's origin (JSON); may differ from the origin in a file that is continued
    std::uint64_t bodies = 0;
    std::vector<std::string> verdicts, stages, kinds; ///< names of the numbers in a row, from 0 on
    bool sweeps = false;                              ///< a row of sweeps for each row of pairs
};

/// One pair in one frame: 27 bytes, as in the file.
#pragma pack(push, 1)
struct PairRow {
    std::uint32_t a, b; ///< bodies
    std::uint8_t verdict, stage, kind;
    double bound, max_error; ///< metres; infinite: unknown
};
#pragma pack(pop)

/// The time at which the pair met on its way, in a run in which bodies move between frames. Numbers are NaN where
/// nothing is known: all, if no body of the pair moved.
#pragma pack(push, 1)
struct SweepRow {
    double clear_until, contact_by, gap;
    std::uint32_t triangle_a, triangle_b; ///< no_triangle: there is no contact, or the part is not a triangle
    std::uint8_t separating;
    std::array<double, 3> point, normal;
    static constexpr std::uint32_t no_triangle = ~0u;
};
#pragma pack(pop)

/// The counts of one stage in one frame.
struct StageRow {
    std::uint64_t in, out, undecided;
    double ms;
};

/// One frame, as in the file, where the stages' columns are named by ResultsHeader::stages ("broad_out").
struct FrameRow {
    std::uint64_t frame, first, pairs; ///< range of its rows among the pairs
    std::uint64_t hash;                ///< hash of the frame
    std::uint64_t chain;               ///< hash of all frames up to this one
    double ms;
    std::array<StageRow, 5> stages;
};

/// A results file. However the program ends, all frames that were added are readable, and no partial frame is; other
/// processes may read the file while it is written ("SWMR").
class ResultsFile {
public:
    /// Begins a new file if `frame` is 0 or the file is missing. Otherwise it continues the results of an earlier run:
    /// copies its frames before `frame`, and replaces the file. `names` are the names of the bodies. Throws
    /// Error{cannot_write}; Error{usage} if the build or the machine has no HDF5, or if the file does not have all
    /// frames before `frame` from the same scene, settings and version; and Error{bad_data} for a file of another kind.
    ResultsFile(const std::filesystem::path& path, const ResultsHeader& header, const NameColumn& names,
                std::uint64_t frame = 0);
    ~ResultsFile();
    ResultsFile(const ResultsFile&) = delete;
    ResultsFile& operator=(const ResultsFile&) = delete;

    /// The hash of the frames of the earlier run; 0 if there was none.
    std::uint64_t chain() const { return chain_; }
    /// Appends a frame; sets row.first and row.pairs. Throws Error{cannot_write}; the file then ends before the frame.
    /// @param sweeps  one sweep for each of the pairs, if the header says so
    void add(std::span<const PairRow> pairs, FrameRow row, std::span<const SweepRow> sweeps = {});
    /// No frame can be added afterwards. Throws Error{cannot_write}.
    void close();

private:
    struct Open; ///< the file, while it is open
    void copy(const std::filesystem::path& from, const ResultsHeader& header, std::uint64_t frame);
    [[noreturn]] void fail();

    std::string name_;
    std::unique_ptr<Open> open_;
    std::uint64_t chain_ = 0, pairs_ = 0, frames_ = 0; ///< written
};

/// Results of a run, whether or not it ended normally; at least one frame.
class StoredResults {
public:
    /// Throws Error{bad_data} for a file that ResultsFile did not write, that is damaged or that holds no frame, and
    /// Error{usage} if the build or the machine has no HDF5.
    /// @param words  names of verdicts, stages and kinds; its other members are ignored
    StoredResults(const std::filesystem::path& path, const ResultsHeader& words);
    ~StoredResults();

    const ResultsHeader& header() const { return header_; }      ///< without the words
    std::span<const FrameRow> frames() const { return frames_; } ///< consecutive; the first one may have any number
    /// The first name that differs from `names`, which has one for each body; empty: all are equal.
    std::string unlike(const NameColumn& names) const;
    /// The pairs of a frame of the file, in the order in which they were added. Throws Error{bad_data} if they cannot
    /// be read.
    void read(const FrameRow& frame, std::vector<PairRow>& pairs) const;
    /// The same for their sweeps, if header().sweeps; otherwise none.
    void read(const FrameRow& frame, std::vector<SweepRow>& sweeps) const;

private:
    struct Open;
    std::string name_;
    ResultsHeader header_;
    std::unique_ptr<Open> open_;
    std::vector<FrameRow> frames_;
};

} // namespace oncollide
