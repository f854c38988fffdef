#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <oncollide/narrowphase/spheres/cell_key.hpp>
#include <oncollide/narrowphase/spheres/occlusion_backend.hpp>
#include <oncollide/narrowphase/spheres/ocst_node.hpp>
#include <oncollide/narrowphase/spheres/surface.hpp>

namespace oncollide {

/// The sphere-tree of one geometry, built while collisions are detected ("on-collide"): a cell is expanded only when a
/// test reaches it; then a backend finds which of its octants are grey.
///
/// Cells of level `depth` are the deepest that a traversal has needed. They are not stored: their parent's grey mask
/// shows which exist. All cells of level l share one half-extent and one sphere radius, root radius / 2^l. Source:
/// Franquesa-Niubó and Rodríguez González, "Sphere-trees generation as needed in real time to speed up collision
/// detection", GRAPP 2006.
class Ocst {
public:
    /// A tree with only the root. depth in [1, deepest_level].
    Ocst(const RootCell& root, int depth, double covering_error);
    /// Raises the depth to at least `depth`. Cells above the new levels are no longer expanded if they lack the data
    /// that these levels need. Cost: a pass over the cells, if the depth changes.
    void deepen(int depth);

    const RootCell& root() const { return root_; }
    int depth() const { return depth_; }
    double radius(int level) const;
    /// How far the geometry may be from a grey cell, whichever backend found it (m); a bound adds it to 2 * radius.
    double error(int level) const { return errors_[static_cast<std::size_t>(level)]; }
    /// Lets `backend` supply cells from now on. Cells from other backends stay; error() is the largest of all
    /// backends'.
    void admit_backend(const OcclusionBackend& backend);

    /// The request to expand `cell`, with its parent's list. The cell must be stored and not expanded. The triangles of
    /// the last stored level are not kept, as nothing below it needs them yet.
    OctantRow row(std::uint32_t tree, CellKey cell) const;
    /// Stores the result for `cell` and stamps it.
    void expand(CellKey cell, const OctantResult& result, std::uint32_t frame);
    /// Lets `backend` rebuild the lists of all cells, after another backend's lists were lost. Masks stay.
    void rebuild_lists(std::uint32_t tree, OcclusionBackend& backend, int threads);
    /// Drops the children of every expanded cell that no test has reached for `age` frames, and releases their lists.
    /// Returns the number of stored cells that were dropped.
    std::uint64_t collapse(std::uint32_t frame, std::uint32_t age, std::uint32_t tree, OcclusionBackend& backend);

    /// The list of `cell`'s parent, which holds the triangles of `cell` under its octant; all_triangles for the root.
    ListId parent_list(CellKey cell) const;

    /// The cell of the level that contains `point` (geometry frame; points outside the root go to the nearest cell).
    CellKey cell_at(const Eigen::Vector3d& point, int level) const;
    /// True if the cell's parent is expanded and the cell is grey, so that its triangles are known.
    bool knows(CellKey cell) const;

    /// Calls `visit` for every known cell, parents first: stored cells, and the leaves under expanded parents. The
    /// children of an expanded cell are known; below other cells nothing is known yet, and leaves have no children.
    void for_each_cell(const std::function<void(CellKey, bool expanded)>& visit) const;
    Eigen::Vector3d centre(CellKey cell) const; ///< centre of its sphere, geometry frame

    const OcstNode* nodes() const { return nodes_.data(); }
    OcstNode* nodes() { return nodes_.data(); }
    std::uint64_t size() const { return stored_; } ///< stored cells
    std::size_t bytes() const;
    /// Returns the first fault of the whole tree as text; empty: each cell is reached once, and all others are free.
    /// Assertions and tests call it. Cost: O(cells).
    std::string validate() const;

private:
    std::uint32_t find(CellKey cell) const; ///< index of a stored cell
    std::uint32_t add_block(unsigned count);
    void forget_leaves(std::uint32_t node, int level);
    std::uint64_t drop_children(std::uint32_t node, int level, std::uint32_t tree, OcclusionBackend& backend);
    std::uint64_t collapse_below(std::uint32_t node, int level, std::uint32_t frame, std::uint32_t age,
                                 std::uint32_t tree, OcclusionBackend& backend);

    RootCell root_;
    int depth_;
    double covering_error_;
    std::array<double, deepest_level + 1> errors_{}; ///< by level
    std::uint64_t stored_ = 1;
    std::vector<OcstNode> nodes_;
    std::vector<ListId> lists_;                 ///< by node: the triangles of an expanded cell
    std::vector<std::uint32_t> free_blocks_[9]; ///< by size
};

} // namespace oncollide
