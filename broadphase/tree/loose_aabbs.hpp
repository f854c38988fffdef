#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/broadphase/broad_phase.hpp>

namespace oncollide {

/// Enlarged boxes of bodies that move. A tree of them needs neither updates nor searches while each body's box stays
/// within its enlarged box: the pairs found with them include all pairs that can overlap.
///
/// The enlargement covers three to six frames of the body's recent motion; it is zero for fast bodies and for a
/// body's first box. 64 bytes per body that has moved, and 4 per body.
class LooseAabbs {
public:
    bool empty() const { return rows_.size() == free_.size(); }
    /// The body's enlarged box; null if it has none.
    const Aabb* find(std::uint32_t body) const
    {
        return body < row_of_.size() && row_of_[body] != none ? &rows_[row_of_[body]].box : nullptr;
    }
    /// Prefetches the data that hold() reads, because bodies are scattered in memory.
    void prefetch(std::uint32_t body, const BodyColumns& columns, bool filters_too) const
    {
        if (body < row_of_.size()) oncollide::prefetch(&row_of_[body]);
        prefetch_all_of(columns.boxes[body]);
        if (!filters_too) return;
        for (const auto& column : {columns.layers, columns.masks, columns.groups})
            if (!column.empty()) oncollide::prefetch(&column[body]);
    }
    /// True if the body's box is within its enlarged box and no other property that decides its pairs has changed.
    /// @param filters_too  layers, mask and group may have changed
    bool hold(std::uint32_t body, const BodyColumns& columns, bool dynamic, bool filters_too) const;
    /// Replaces the body's enlarged box. Its box must be usable.
    Aabb renew(std::uint32_t body, const BodyColumns& columns, bool dynamic);
    void erase(std::uint32_t body);
    void clear();
    void end_frame() { ++frame_; }
    std::uint32_t frame() const { return frame_; }
    std::size_t bytes() const;
    /// Returns the first fault of the whole structure as text; empty: it has none. Assertions and tests call it. Cost:
    /// O(n).
    /// @param columns  the columns as of the last change: each body's box is within its enlarged box
    std::string validate(const BodyColumns& columns) const;

private:
    /// One cache line.
    struct alignas(64) Row {
        Aabb box;
        std::uint32_t layers, mask, group;
        std::uint32_t dynamic : 1, made : 31; ///< frame in which it was made
    };
    static constexpr std::uint32_t none = ~0u;
    static Row row(std::uint32_t body, const BodyColumns& columns, bool dynamic);

    std::vector<std::uint32_t> row_of_; ///< by body
    std::vector<Row> rows_;
    std::vector<std::uint32_t> owners_, free_; ///< bodies by row; rows
    std::uint32_t frame_ = 0;
};

} // namespace oncollide
