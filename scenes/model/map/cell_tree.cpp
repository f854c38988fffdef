#include <oncollide/scenes/model/map/cell_tree.hpp>

#include <algorithm>

#include <oncollide/base/error.hpp>
#include <oncollide/scenes/model/map/map_chunks.hpp>

namespace oncollide {

namespace {

constexpr std::uint8_t bit(unsigned octant)
{
    return static_cast<std::uint8_t>(1u << octant);
}

} // namespace

CellTree::CellTree(bool unknown_is_solid) : unknown_(unknown_is_solid ? 0xff : 0)
{
    spare_.fill(none);
    set_grid(CellState::unknown);
}

CellTree::CellTree(std::shared_ptr<MapChunks> chunks, const Node& top, bool unknown_is_solid)
    : chunks_(std::move(chunks)), top_(top), unknown_(unknown_is_solid ? 0xff : 0)
{
    spare_.fill(none);
}

const CellTree::Node& CellTree::in_chunk(std::uint32_t number) const
{
    return chunks_->node(number);
}

std::size_t CellTree::bytes() const
{
    return chunks_ ? chunks_->bytes() : nodes_.capacity() * sizeof(Node);
}

CellTree::Node CellTree::taken(const Node& node, std::vector<Node>& nodes) const
{
    Node copy = node;
    copy.first = node.inner ? static_cast<std::uint32_t>(nodes.size()) : 0;
    nodes.resize(nodes.size() + bits_in(node.inner));
    std::uint32_t next = copy.first;
    for (unsigned k = 0; k < 8; ++k)
        if (node.inner >> k & 1) {
            const Node inner = taken(below(node, k), nodes);
            nodes[next++] = inner;
        }
    return copy;
}

void CellTree::take_all()
{
    if (!chunks_) return;
    std::vector<Node> nodes;
    top_ = taken(top_, nodes);
    nodes_ = std::move(nodes), chunks_.reset();
}

void CellTree::Octants::set(unsigned octant, CellState state)
{
    ONCOLLIDE_ASSERT(octant < 8);
    const std::uint8_t here = bit(octant), others = static_cast<std::uint8_t>(~here);
    node_.inner &= others, node_.occupied &= others, node_.free &= others;
    if (state == CellState::occupied) node_.occupied |= here;
    if (state == CellState::free) node_.free |= here;
}

void CellTree::Octants::set(unsigned octant, const Node& node)
{
    if (node.occupied == 0xff) return set(octant, CellState::occupied);
    if (node.free == 0xff) return set(octant, CellState::free);
    set(octant, CellState::unknown);
    if (!(node.inner | node.occupied | node.free)) return;
    node_.inner |= bit(octant);
    below_[octant] = node;
}

CellTree::Node CellTree::close(Octants& octants)
{
    ONCOLLIDE_ASSERT(!chunks_ && !(octants.node_.occupied & octants.node_.free));
    Node& node = octants.node_;
    node.solid = whole(node), node.first = 0;
    const std::uint32_t length = bits_in(node.inner);
    if (length == 0) return node;
    node.first = spare_[length];
    if (node.first != none) {
        spare_[length] = nodes_[node.first].first;
    } else {
        node.first = static_cast<std::uint32_t>(nodes_.size());
        nodes_.resize(nodes_.size() + length);
    }
    Node* to = &nodes_[node.first];
    for (unsigned left = node.inner; left; left &= left - 1) {
        const auto k = static_cast<unsigned>(__builtin_ctz(left));
        if (octants.below_[k].solid) node.solid |= bit(k);
        *to++ = octants.below_[k];
    }
    return node;
}

/// Takes the node's octants out of storage, which becomes free.
CellTree::Octants CellTree::open(const Node& node)
{
    Octants octants;
    octants.node_ = node;
    if (node.inner == 0) return octants;
    for (unsigned k = 0; k < 8; ++k)
        if (node.inner >> k & 1) octants.below_[k] = below(node, k);
    std::uint32_t& spare = spare_[bits_in(node.inner)];
    nodes_[node.first].first = spare, spare = node.first;
    return octants;
}

void CellTree::set_grid(CellState state)
{
    Octants top;
    for (unsigned k = 0; k < 8; ++k) top.set(k, k == 0 ? state : CellState::free); // octants 1 to 7 have no cells
    top_ = close(top);
}

void CellTree::set_grid(const Node& grid)
{
    Octants top;
    for (unsigned k = 1; k < 8; ++k) top.set(k, CellState::free);
    top.set(0, grid);
    top_ = close(top);
}

CellState CellTree::state(const Eigen::Vector3i& cell) const
{
    ONCOLLIDE_ASSERT(CellBox(top_cube.octant(0)).contains(CellBox(cell, cell.array() + 1)));
    const CellBox box(cell, cell.array() + 1);
    Node node = top_;
    MapCell cube = top_cube;
    while (true) {
        unsigned k = 0;
        while (!CellBox(cube.octant(k)).contains(box)) ++k;
        if (!(node.inner >> k & 1)) return state(node, k);
        node = below(node, k), cube = cube.octant(k);
    }
}

void CellTree::set(const CellBox& box, CellState state, Before* before)
{
    take_all();
    const Eigen::Vector3i least = Eigen::Vector3i::Constant(lowest), end = Eigen::Vector3i::Constant(lowest + side);
    const CellBox inside(box.low.cwiseMax(least), box.high.cwiseMin(end));
    if (!inside.empty()) top_ = changed(top_, top_cube, inside, state, before);
}

/// Appends the states in a node to `before`, and frees the storage below it.
void CellTree::take(const Node& node, const MapCell& cube, Before* before)
{
    const Octants octants = open(node);
    for (unsigned k = 0; k < 8; ++k)
        if (node.inner >> k & 1)
            take(octants.below_[k], cube.octant(k), before);
        else if (before)
            before->push_back({cube.octant(k), state(node, k)});
}

CellTree::Node CellTree::changed(const Node& node, const MapCell& cube, const CellBox& box, CellState now,
                                 Before* before)
{
    Octants octants = open(node);
    for (unsigned k = 0; k < 8; ++k) {
        const MapCell octant = cube.octant(k);
        const bool inner = node.inner >> k & 1;
        if (!box.overlaps(CellBox(octant)) || (!inner && state(node, k) == now)) continue;
        if (!box.contains(CellBox(octant))) {
            Node parts;
            if (inner)
                parts = octants.below_[k];
            else if (state(node, k) == CellState::occupied)
                parts.occupied = 0xff;
            else if (state(node, k) == CellState::free)
                parts.free = 0xff;
            octants.set(k, changed(parts, octant, box, now, before));
            continue;
        }
        if (inner)
            take(octants.below_[k], octant, before);
        else if (before)
            before->push_back({octant, state(node, k)});
        octants.set(k, now);
    }
    return close(octants);
}

/// Extends `farthest` along the axis to the cells in the node.
void CellTree::add_bounds(const Node& node, const MapCell& cube, int axis, bool high, std::int32_t& farthest) const
{
    const unsigned leaves = unknown_ ? node.occupied | node.free : node.occupied;
    const unsigned all = leaves | (unknown_ ? node.inner : node.inner & node.solid);
    for (unsigned i = 0; i < 8; ++i) {
        const unsigned of_half = i & 3, u = (axis + 1) % 3, v = (axis + 2) % 3; // the farther half is searched first
        const unsigned k = unsigned((i < 4) == high) << axis | (of_half & 1) << u | (of_half >> 1) << v;
        if (!(all >> k & 1)) continue;
        const MapCell octant = cube.octant(k);
        const CellBox box(octant);
        const std::int32_t end = high ? box.high[axis] : box.low[axis];
        if (high ? end <= farthest : end >= farthest) continue;
        if (leaves >> k & 1)
            farthest = end;
        else
            add_bounds(below(node, k), octant, axis, high, farthest);
    }
}

CellBox CellTree::bounds() const
{
    CellBox box(Eigen::Vector3i::Constant(lowest + side), Eigen::Vector3i::Constant(lowest));
    if (!(top_.inner & 1)) return (top_.occupied | (unknown_ & top_.free)) & 1 ? CellBox(top_cube.octant(0)) : box;
    const Node& grid = below(top_, 0);
    for (int axis = 0; axis < 3; ++axis) {
        add_bounds(grid, top_cube.octant(0), axis, false, box.low[axis]);
        add_bounds(grid, top_cube.octant(0), axis, true, box.high[axis]);
    }
    return box;
}

std::size_t CellTree::count() const
{
    std::size_t nodes = 1; // the root
    const auto add = [&](const auto& self, const Node& node) -> void {
        nodes += bits_in(node.inner) + bits_in(node.occupied) + bits_in(node.free);
        for (unsigned k = 0; k < 8; ++k)
            if (node.inner >> k & 1) self(self, below(node, k));
    };
    if (top_.inner & 1) add(add, below(top_, 0));
    return nodes;
}

} // namespace oncollide
