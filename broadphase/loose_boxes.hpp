#pragma once
#include <cstdint>
#include <vector>

#include <oncollide/base/prefetch.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Boxes somewhat larger than those of bodies that move. A tree that holds them need not change, nor be searched, while
/// each body's box stays within its own: what was found with them holds all pairs that there can be.
///
/// They leave room for three to six frames of what the body moved in the last ones; those of fast bodies, and the first
/// ones, leave none. 64 bytes per body that has moved, and 4 per body.
class LooseBoxes {
public:
    bool empty() const { return rows_.size() == free_.size(); }
    /// Begins to load what hold() looks at: bodies lie scattered in memory.
    void prefetch(std::uint32_t body, const BodyColumns& columns, bool filters_too) const
    {
        if (body < row_of_.size()) oncollide::prefetch(&row_of_[body]);
        prefetch_all_of(columns.boxes[body]);
        if (!filters_too) return;
        for (const auto& column : {columns.layers, columns.masks, columns.groups})
            if (!column.empty()) oncollide::prefetch(&column[body]);
    }
    /// Is the body's box within its loose one, and all else as it was that decides which pairs it may form?
    /// @param filters_too  layers, mask and group may have changed
    bool hold(std::uint32_t body, const BodyColumns& columns, bool dynamic, bool filters_too) const;
    /// Makes another one for it as it is now. Its box must be usable.
    Aabb renew(std::uint32_t body, const BodyColumns& columns, bool dynamic);
    void erase(std::uint32_t body);
    void clear();
    void end_frame() { ++frame_; }
    std::size_t bytes() const;

private:
    /// One line of the cache.
    struct alignas(64) Row {
        Aabb box;
        std::uint32_t layers, mask, group;
        std::uint32_t dynamic : 1, made : 31; ///< in which frame
    };
    static constexpr std::uint32_t none = ~0u;
    static Row row(std::uint32_t body, const BodyColumns& columns, bool dynamic);

    std::vector<std::uint32_t> row_of_; ///< by body
    std::vector<Row> rows_;
    std::vector<std::uint32_t> owners_, free_; ///< bodies by row; rows
    std::uint32_t frame_ = 0;
};

} // namespace oncollide
