#pragma once
#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// The distinct pairs of bodies that a run found, in order of discovery: complete results for the first few, only slots
/// for the others. Uses at most a few megabytes, however long the run.
class PairList {
public:
    struct Entry {
        PairResult pair;
        std::uint64_t frame; ///< the first frame with this pair
    };
    static constexpr std::size_t most_shown = 10, most_counted = 100'000;

    void add(const PairResult& pair, std::uint64_t frame);
    std::span<const Entry> first() const { return first_; }
    std::size_t size() const { return seen_.size(); }
    /// True if pairs beyond size() may be missing.
    bool full() const { return seen_.size() == most_counted; }

private:
    std::vector<Entry> first_;
    std::unordered_set<std::uint64_t> seen_;
};

} // namespace oncollide
