#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <oncollide/scenes/columns.hpp>

namespace oncollide {

// Results in HDF5, written frame by frame while a run goes on. The layout: docs/results.md.

/// What a file of results says of all its frames.
struct ResultsHeader {
    std::string version, scene, settings;
    std::string
        source; ///< where the scene came from (JSON); a file that is continued may have been made from elsewhere
    std::uint64_t bodies = 0;
    std::vector<std::string> verdicts, stages, kinds; ///< what the numbers of a row mean, from 0 on
};

/// One pair in one frame: 27 bytes, as in the file.
#pragma pack(push, 1)
struct PairRow {
    std::uint32_t a, b; ///< bodies
    std::uint8_t verdict, stage, kind;
    double bound, max_error; ///< metres; infinite: unknown
};
#pragma pack(pop)

/// What one stage did in one frame.
struct StageRow {
    std::uint64_t in, out, undecided;
    double ms;
};

/// One frame, as in the file: there the stages' columns have the names of ResultsHeader::stages ("broad_out").
struct FrameRow {
    std::uint64_t frame, first, pairs; ///< its rows among the pairs
    std::uint64_t hash;                ///< of the frame
    std::uint64_t chain;               ///< of all frames up to this one
    double ms;
    std::array<StageRow, 5> stages;
};

/// A file of results. Whatever ends the program, all frames that were added can be read, and nothing of another one;
/// while it is written others may read it (as "SWMR").
class ResultsFile {
public:
    /// Begins the file anew where `frame` is 0 or no file is there. Otherwise it goes on with what an earlier run
    /// wrote: that is copied up to the frame before, and put in place of the file. `names` are those of the bodies.
    /// Throws Error{cannot_write}, Error{usage} where the build or the machine has no HDF5 or the file does not hold
    /// all frames up to there, of the same scene, settings and version, and Error{bad_data} for a file of another kind.
    ResultsFile(const std::filesystem::path& path, const ResultsHeader& header, const NameColumn& names,
                std::uint64_t frame = 0);
    ~ResultsFile();
    ResultsFile(const ResultsFile&) = delete;
    ResultsFile& operator=(const ResultsFile&) = delete;

    /// The hash of the frames that were there; 0 if none was.
    std::uint64_t chain() const { return chain_; }
    /// Appends a frame; sets row.first and row.pairs. Throws Error{cannot_write}, and the file ends before the frame.
    void add(std::span<const PairRow> pairs, FrameRow row);
    /// Nothing can be added afterwards. Throws Error{cannot_write}.
    void close();

private:
    struct Open; ///< the file, while it is open
    void copy(const std::filesystem::path& from, const ResultsHeader& header, std::uint64_t frame);
    [[noreturn]] void fail();

    std::string name_;
    std::unique_ptr<Open> open_;
    std::uint64_t chain_ = 0, pairs_ = 0, frames_ = 0; ///< written
};

/// Results that a run wrote, whatever ended it.
class StoredResults {
public:
    /// Throws Error{bad_data} for a file that ResultsFile did not write or that is damaged, and Error{usage} where the
    /// build or the machine has no HDF5.
    /// @param words  what verdicts, stages and kinds are called; its other fields are not read
    StoredResults(const std::filesystem::path& path, const ResultsHeader& words);
    ~StoredResults();

    const ResultsHeader& header() const { return header_; }      ///< without the words
    std::span<const FrameRow> frames() const { return frames_; } ///< one after the other, from any first frame on
    /// The name of the first body that is called otherwise than in `names`, which has one for each body; empty: none.
    std::string unlike(const NameColumn& names) const;
    /// The pairs of a frame of the file, in the order in which they were added. Throws Error{bad_data} where they
    /// cannot be read.
    void read(const FrameRow& frame, std::vector<PairRow>& pairs) const;

private:
    struct Open;
    std::string name_;
    ResultsHeader header_;
    std::unique_ptr<Open> open_;
    std::vector<FrameRow> frames_;
};

} // namespace oncollide
