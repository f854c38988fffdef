#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <oncollide/broadphase/tree/aabb_tree_kernel.hpp>
#include <oncollide/broadphase/tree/pair_lists.hpp>
#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The AABBs of all triangles of a mesh, for one search of all overlaps. AabbTree also holds boxes that change,
/// come and go; this takes a third of its time to build and half of its memory. Not for a mesh without triangles.
class TriangleBoxes {
public:
    /// @param within  metres: boxes this near count as overlapping, and some that are little farther apart
    /// Cost: 15 ns per triangle.
    TriangleBoxes(const Mesh& mesh, double within, int threads);

    /// The search has parts, which may run at the same time. They depend on the mesh alone.
    std::size_t parts() const { return parts_.size(); }
    /// Passes the pairs of boxes of a part to take(i, j, count), in chunks, as columns of places. All parts together
    /// have each pair once.
    template <class Take>
    void find(std::size_t part, Take take) const
    {
        find_in_chunks(take, [&](PairSink& sink) { find(parts_[part], sink); });
    }
    /// The triangle at a place.
    std::uint32_t triangle_at(std::uint32_t place) const { return order_[place]; }

private:
    /// Two nodes of one level, or one node twice.
    using Part = std::pair<std::uint32_t, std::uint32_t>;

    void add_levels(std::uint32_t count);
    void set_boxes(const Mesh& mesh, double within, int threads);
    void divide();
    void find(Part part, PairSink& sink) const;

    std::unique_ptr<std::uint32_t[]> order_;
    std::vector<std::unique_ptr<float[]>> blocks_;  ///< by level
    std::vector<std::vector<std::uint16_t>> there_; ///< by level, by block: which boxes it has
    AabbTreeView view_{};
    std::vector<Part> parts_; ///< sorted; one alone: all boxes
};

} // namespace oncollide
