#pragma once
#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include <oncollide/pipeline/results.hpp>

namespace oncollide {

/// The different pairs of bodies that a run found, in the order in which it found them: the first few as they were
/// then, the others by number only. Holds at most a few megabytes, however long the run.
class PairList {
public:
    struct Entry {
        PairResult pair;
        std::uint64_t frame; ///< the first one that has it
    };
    static constexpr std::size_t most_shown = 10, most_counted = 100'000;

    void add(const PairResult& pair, std::uint64_t frame);
    std::span<const Entry> first() const { return first_; }
    std::size_t size() const { return seen_.size(); }
    /// There may be more than size().
    bool full() const { return seen_.size() == most_counted; }

private:
    std::vector<Entry> first_;
    std::unordered_set<std::uint64_t> seen_;
};

} // namespace oncollide
