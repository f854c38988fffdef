#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <oncollide/broadphase/box_tree.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/tree_search.hpp>

namespace oncollide {

/// Progressive delimitation: from the whole scene down a hierarchy of regions, each split where neighbours overlap
/// least, only those are looked at that a box in question reaches; a region that none reaches, or in which the layers
/// forbid every pair, is rejected whole at the highest level where that shows. The regions are the upper levels of the
/// tree that the accurate level goes on with: what survives is handed over as pairs (box in question, leaf region).
///
/// Cost: O(boxes in question * levels), whatever the number of bodies.
/// Source: Franquesa-Niubó and Brunet, "Collision prediction using MKtrees", CEIG 2004, for the idea.
class Delimitation {
public:
    void clear();
    /// Adds a box in question: lo x y z, hi x y z, as BoxTree::round() or box_at() gives it.
    void ask(const float box[6], std::uint32_t layers, std::uint32_t mask);
    /// Delimits.
    /// @param layers  reject regions whose layers forbid every pair, too: the tree knows them
    void run(const BoxTree& tree, bool layers, int threads);
    /// The accurate level: places of the leaf regions that overlap the boxes in question, as pairs (number of the box,
    /// place), by thread. After run().
    std::span<const std::unique_ptr<FoundPairs>> compare(const BoxTree& tree, int threads);

    const float* box(std::size_t k) const { return &boxes_[6 * k]; }
    // What was rejected, counted when first asked for after run(), on the same tree.
    std::span<const DelimitationLevel> levels(const BoxTree& tree);
    /// Bodies in the leaf regions that are left.
    std::uint64_t bodies_left(const BoxTree& tree);
    /// Overwrites `bodies` with them, ascending.
    void survivors(const BoxTree& tree, std::vector<std::uint32_t>& bodies);
    std::size_t bytes() const;

private:
    void descend(const BoxTree& tree, int level, FoundPairs& from, FoundPairs& to) const;
    void drop_forbidden(const BoxLevelView& level, PairSink& found) const;
    void count(const BoxTree& tree);
    void mark(const BoxTree& tree);
    void count_rejected(const BoxTree& tree);

    std::size_t share(std::size_t thread, std::size_t threads) const { return layers_.size() * thread / threads; }

    std::vector<float> boxes_; ///< 6 each
    std::vector<std::uint32_t> layers_, masks_;
    std::vector<std::unique_ptr<FoundPairs>> reached_, next_; ///< by thread: (box, node)
    std::vector<std::vector<std::uint32_t>> left_;            ///< by level: nodes that survive, each once
    std::vector<std::vector<std::uint8_t>> is_left_;          ///< by level and node
    std::vector<DelimitationLevel> levels_;
    std::uint64_t bodies_left_ = 0;
    bool counted_ = true;
};

} // namespace oncollide
