#pragma once
#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace oncollide {

// The size of the tree that instances expand to, known before any of it is made. Private to scenes.

/// The size of an element with all elements that it instances. Numbers stop at 2^40, beyond every limit.
struct ExpandedSize {
    std::uint64_t nodes = 0;  ///< nodes, and meshes shown by them
    std::uint64_t parts = 0;  ///< number of meshes among them
    std::uint64_t pieces = 0; ///< vertices and triangles of these meshes, and 1 for each
    int levels = 0;

    void add(const ExpandedSize& below)
    {
        constexpr std::uint64_t most = std::uint64_t{1} << 40;
        nodes = std::min(nodes + below.nodes, most);
        parts = std::min(parts + below.parts, most);
        pieces = std::min(pieces + below.pieces, most);
        levels = std::max(levels, below.levels);
    }
};

/// Measures each element once, however many instances it has: in a kilobyte of text, each element may instance the next
/// one twice, so that the tree has 2^30 nodes.
class ExpandedSizes {
public:
    explicit ExpandedSizes(int most_levels) : most_levels_(most_levels) {}

    /// @param level     the level of the element below the root of the tree, which is 1
    /// @param measure   returns the size of the element and of all elements below it; calls of() for these
    /// @param too_deep  throws; called if the tree has more than `most_levels` levels, or never ends
    template <class Measure, class TooDeep>
    ExpandedSize of(const void* element, int level, Measure measure, TooDeep too_deep)
    {
        const auto [at, is_new] = sizes_.try_emplace(element);
        ExpandedSize& size = at->second; // stays in place
        if (is_new && level <= most_levels_) {
            ExpandedSize measured = measure();
            ++measured.levels;
            size = measured;
        }
        // An element without levels is still being measured, so it is among the elements below itself.
        if (size.levels == 0 || level + size.levels - 1 > most_levels_) too_deep();
        return size;
    }

private:
    int most_levels_;
    std::unordered_map<const void*, ExpandedSize> sizes_;
};

} // namespace oncollide
