#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <oncollide/broadphase/box_tree.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Pairs of places that one thread found, as columns.
class FoundPairs {
public:
    PairSink& sink() { return sink_; }
    void clear() { sink_.count = 0; }
    /// Overwrites all with (k, j) for k in [first, last).
    void assign_all(std::size_t first, std::size_t last, std::uint32_t j);
    std::size_t size() const { return static_cast<std::size_t>(sink_.count); }
    std::uint32_t i(std::size_t k) const { return i_[k]; }
    std::uint32_t j(std::size_t k) const { return j_[k]; }
    std::size_t bytes() const { return (i_.capacity() + j_.capacity()) * sizeof(std::uint32_t); }

private:
    static void grow(PairSink& sink);

    std::vector<std::uint32_t> i_, j_;
    PairSink sink_{nullptr, nullptr, 0, 0, grow, this};
};

/// Searches a tree against itself on several threads.
class TreeSearch {
public:
    static constexpr std::size_t worth_threads = 32768; ///< bodies: fewer are done before threads have woken

    /// Overwrites `pairs` with those whose boxes overlap and that `filter` allows; unsorted.
    /// @param exact  compare the boxes themselves where the tree's rounding leaves a doubt; else keep the doubtful
    void find_pairs(BoxTree& tree, std::span<const Aabb> boxes, const BodyFilter& filter, double margin, bool exact,
                    int threads, std::vector<BodyPair>& pairs);
    std::size_t bytes() const;

private:
    void search(const BoxTree& tree, int threads);
    std::size_t translate(const BoxTree& tree, const FoundPairs& found, std::span<const Aabb> boxes,
                          const BodyFilter& filter, double margin, bool exact, BodyPair* out) const;

    std::vector<std::unique_ptr<FoundPairs>> found_; ///< by thread
    FoundPairs tasks_;
    std::vector<std::size_t> starts_, counts_; ///< of the threads' pairs
    bool layers_asked_ = false;                ///< do layers and masks forbid anything?
};

/// The layers and masks of many bodies together.
struct LayerSummary {
    std::uint32_t layers = 0, common_mask = ~0u; ///< in any layer; in every mask
    bool some_in_none = false;                   ///< is there a body in no layer?

    LayerSummary() = default;
    explicit LayerSummary(const BodyFilter& filter);
    void add(std::uint32_t layer, std::uint32_t mask)
    {
        layers |= layer, common_mask &= mask, some_in_none |= layer == 0;
    }
    /// Do they forbid no pair at all?
    bool allow_all() const { return !some_in_none && (layers & ~common_mask) == 0; }
};

/// Do two boxes, each grown by margin / 2, overlap?
inline bool overlap(const Aabb& a, const Aabb& b, double margin)
{
    return !(((a.min - b.max).array() > margin).any() || ((b.min - a.max).array() > margin).any());
}

} // namespace oncollide
