#include <oncollide/narrowphase/spheres/ocst.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

/// Position of octant k's node among the packed grey children.
unsigned rank(unsigned grey, unsigned octant)
{
    return static_cast<unsigned>(std::popcount(grey & ((1u << octant) - 1)));
}

std::uint32_t expanded_state(unsigned grey, std::uint32_t frame)
{
    return grey | OcstNode::expanded_bit | (frame & OcstNode::stamp_mask) << OcstNode::stamp_shift;
}

} // namespace

Ocst::Ocst(const RootCell& root, int depth, double covering_error)
    : root_(root), depth_(depth), covering_error_(covering_error), nodes_(1), lists_(1, all_triangles)
{
    ONCOLLIDE_ASSERT(depth >= 1 && depth <= deepest_level);
}

void Ocst::deepen(int depth)
{
    ONCOLLIDE_ASSERT(depth <= deepest_level);
    if (depth <= depth_) return;
    forget_leaves(0, 0);
    depth_ = depth;
}

/// Makes cells unexpanded whose children are leaves: they have no room for child nodes and no list.
void Ocst::forget_leaves(std::uint32_t node, int level)
{
    const OcstNode n = nodes_[node];
    if (!n.expanded()) return;
    if (level + 1 == depth_)
        nodes_[node] = {};
    else
        for (unsigned c = 0; c < static_cast<unsigned>(std::popcount(n.grey())); ++c)
            forget_leaves(n.first_child + c, level + 1);
}

double Ocst::radius(int level) const
{
    return std::ldexp(root_.radius, -level);
}

void Ocst::admit_backend(const OcclusionBackend& backend)
{
    for (int level = 0; level <= deepest_level; ++level) {
        const double error = root_.test_error() + covering_error_ + backend.error(std::ldexp(root_.scale, -level));
        errors_[static_cast<std::size_t>(level)] = std::max(errors_[static_cast<std::size_t>(level)], error);
    }
}

std::uint32_t Ocst::find(CellKey cell) const
{
    std::uint32_t node = 0;
    for (int level = 0, depth = level_of(cell); level < depth; ++level) {
        const OcstNode& n = nodes_[node];
        const unsigned octant = octant_at(cell, level);
        ONCOLLIDE_ASSERT(n.expanded() && (n.grey() >> octant & 1));
        node = n.first_child + rank(n.grey(), octant);
    }
    return node;
}

CellKey Ocst::cell_at(const Eigen::Vector3d& point, int level) const
{
    CellKey cell = root_cell;
    Eigen::Vector3d p = point - root_.centre, half(root_.half[0], root_.half[1], root_.half[2]);
    for (int l = 0; l < level; ++l) {
        half *= 0.5;
        unsigned octant = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const bool high = p[axis] > 0;
            octant |= static_cast<unsigned>(high) << axis;
            p[axis] += high ? -half[axis] : half[axis];
        }
        cell = child_cell(cell, octant);
    }
    return cell;
}

bool Ocst::knows(CellKey cell) const
{
    std::uint32_t node = 0;
    for (int level = 0, depth = level_of(cell); level < depth; ++level) {
        const OcstNode& n = nodes_[node];
        const unsigned octant = octant_at(cell, level);
        if (!n.expanded() || !(n.grey() >> octant & 1)) return false;
        if (level + 1 < depth) node = n.first_child + rank(n.grey(), octant);
    }
    return true;
}

ListId Ocst::parent_list(CellKey cell) const
{
    return cell == root_cell ? all_triangles : lists_[find(parent_cell(cell))];
}

OctantRow Ocst::row(std::uint32_t tree, CellKey cell) const
{
    return {tree, cell, parent_list(cell), level_of(cell) + 1 < depth_};
}

std::uint32_t Ocst::add_block(unsigned count)
{
    stored_ += count;
    auto& free = free_blocks_[count];
    if (!free.empty()) {
        const std::uint32_t block = free.back();
        free.pop_back();
        for (unsigned i = 0; i < count; ++i) nodes_[block + i] = {}, lists_[block + i] = all_triangles;
        return block;
    }
    const auto block = static_cast<std::uint32_t>(nodes_.size());
    nodes_.resize(block + count);
    lists_.resize(block + count, all_triangles);
    return block;
}

void Ocst::expand(CellKey cell, const OctantResult& result, std::uint32_t frame)
{
    const std::uint32_t node = find(cell);
    ONCOLLIDE_ASSERT(!nodes_[node].expanded());
    const auto children = static_cast<unsigned>(std::popcount(result.grey));
    const bool stored = level_of(cell) + 1 < depth_ && children > 0;
    const std::uint32_t first = stored ? add_block(children) : 0; // may reallocate nodes_
    nodes_[node] = {first, expanded_state(result.grey, frame)};
    lists_[node] = result.list;
}

void Ocst::rebuild_lists(std::uint32_t tree, OcclusionBackend& backend, int threads)
{
    struct Place {
        std::uint32_t node;
        CellKey cell;
        ListId parent;
    };
    std::vector<Place> level{{0, root_cell, all_triangles}}, next;
    std::vector<OctantRow> rows;
    std::vector<OctantResult> results;
    while (!level.empty()) {
        std::erase_if(level, [&](const Place& p) { return !nodes_[p.node].expanded(); });
        rows.clear(), next.clear();
        for (const Place& p : level) rows.push_back({tree, p.cell, p.parent, level_of(p.cell) + 1 < depth_});
        results.resize(rows.size());
        backend.run(rows, threads, results);
        for (std::size_t i = 0; i < level.size(); ++i) {
            const OcstNode& n = nodes_[level[i].node];
            lists_[level[i].node] = results[i].list;
            if (level_of(level[i].cell) + 1 < depth_)
                for (unsigned k = 0; k < 8; ++k)
                    if (n.grey() >> k & 1)
                        next.push_back(
                            {n.first_child + rank(n.grey(), k), child_cell(level[i].cell, k), results[i].list});
        }
        level.swap(next);
    }
}

std::uint64_t Ocst::drop_children(std::uint32_t node, int level, std::uint32_t tree, OcclusionBackend& backend)
{
    OcstNode& n = nodes_[node];
    if (!n.expanded()) return 0;
    const auto children = static_cast<std::uint32_t>(std::popcount(n.grey()));
    std::uint64_t dropped = 0;
    if (level + 1 < depth_ && children > 0) {
        dropped = children;
        for (std::uint32_t c = 0; c < children; ++c)
            dropped += drop_children(n.first_child + c, level + 1, tree, backend);
        free_blocks_[children].push_back(n.first_child);
        stored_ -= children;
    }
    if (lists_[node] != all_triangles) backend.release(tree, lists_[node]);
    n = {}, lists_[node] = all_triangles;
    return dropped;
}

std::uint64_t Ocst::collapse_below(std::uint32_t node, int level, std::uint32_t frame, std::uint32_t age,
                                   std::uint32_t tree, OcclusionBackend& backend)
{
    const OcstNode n = nodes_[node];
    if (!n.expanded()) return 0;
    if (((frame - n.stamp()) & OcstNode::stamp_mask) >= age) return drop_children(node, level, tree, backend);
    std::uint64_t dropped = 0;
    if (level + 1 < depth_)
        for (std::uint32_t c = 0; c < static_cast<std::uint32_t>(std::popcount(n.grey())); ++c)
            dropped += collapse_below(n.first_child + c, level + 1, frame, age, tree, backend);
    return dropped;
}

std::uint64_t Ocst::collapse(std::uint32_t frame, std::uint32_t age, std::uint32_t tree, OcclusionBackend& backend)
{
    const std::uint64_t dropped = collapse_below(0, 0, frame, age, tree, backend);
    if (stored_ == 1 && nodes_.size() > 1) { // only the root is left: free the memory, too
        const OcstNode root = nodes_[0];
        const ListId list = lists_[0];
        nodes_ = std::vector<OcstNode>(1, root), lists_ = std::vector<ListId>(1, list);
        for (auto& free : free_blocks_) free = std::vector<std::uint32_t>();
    }
    return dropped;
}

Eigen::Vector3d Ocst::centre(CellKey cell) const
{
    const std::array<std::int32_t, 3> place = centre_of(cell);
    Eigen::Vector3d centre = root_.centre;
    for (int axis = 0; axis < 3; ++axis)
        centre[axis] += place[std::size_t(axis)] * std::ldexp(double(root_.half[std::size_t(axis)]), -level_of(cell));
    return centre;
}

void Ocst::for_each_cell(const std::function<void(CellKey, bool)>& visit) const
{
    const auto below = [&](const auto& self, std::uint32_t node, CellKey cell) -> void {
        const OcstNode& n = nodes_[node];
        visit(cell, n.expanded());
        for (unsigned k = 0; n.expanded() && k < 8; ++k)
            if (n.grey() >> k & 1) {
                if (level_of(cell) + 1 < depth_)
                    self(self, n.first_child + rank(n.grey(), k), child_cell(cell, k));
                else
                    visit(child_cell(cell, k), false);
            }
    };
    below(below, 0, root_cell);
}

std::size_t Ocst::bytes() const
{
    std::size_t sum = nodes_.capacity() * sizeof(OcstNode) + lists_.capacity() * sizeof(ListId);
    for (const auto& free : free_blocks_) sum += free.capacity() * sizeof(std::uint32_t);
    return sum;
}

} // namespace oncollide
