#include <oncollide/narrowphase/boxes/map_tree.hpp>

#include <algorithm>
#include <cmath>

namespace oncollide {

namespace {

constexpr std::int32_t lowest = -32768, all = 65536; ///< OctoMap's address space

/// Of the octant that holds the cell's least corner, in a cube twice as large.
unsigned octant_in(const MapCell& cube, const MapCell& cell)
{
    const std::int32_t half = cube.side / 2;
    return unsigned(cell.x >= cube.x + half) | unsigned(cell.y >= cube.y + half) << 1 |
           unsigned(cell.z >= cube.z + half) << 2;
}

/// In the order of an octree's leaves.
bool before(const MapCell& a, const MapCell& b)
{
    const auto ax = std::uint32_t(a.x - lowest), ay = std::uint32_t(a.y - lowest), az = std::uint32_t(a.z - lowest);
    const auto bx = std::uint32_t(b.x - lowest), by = std::uint32_t(b.y - lowest), bz = std::uint32_t(b.z - lowest);
    const std::uint32_t x = ax ^ bx, y = ay ^ by, z = az ^ bz;
    // The axis that differs in the highest bit; of equal ones z, then y, then x.
    if (z >= std::max(x, y) || !((z ^ std::max(x, y)) > z)) return az < bz;
    if (y >= x || !((y ^ x) > y)) return ay < by;
    return ax < bx;
}

} // namespace

MapTree::MapTree(const OccupancyMap& map)
    : resolution_(map.resolution), bounds_(map.bounds), centre_(map.bounds.centre()),
      radius_(0.5 * map.bounds.diagonal() * (1 + 0x1p-50))
{
    std::vector<MapCell> cells;
    cells.reserve(map.cells.size());
    for (const Aabb& box : map.cells) {
        const auto grid = [&](double x) { return static_cast<std::int32_t>(std::floor(x / resolution_ + 0.5)); };
        cells.push_back(
            {grid(box.min.x()), grid(box.min.y()), grid(box.min.z()), grid(box.max.x()) - grid(box.min.x())});
    }
    if (!std::ranges::is_sorted(cells, before)) std::ranges::sort(cells, before);

    // A cube twice the address space, so that a map that is all occupied is an octant of a node, too.
    top_ = {0, {lowest, lowest, lowest, 2 * all}};
    nodes_.emplace_back();
    build(0, top_.cube, cells.data(), cells.data() + cells.size());
    nodes_.shrink_to_fit();
    top_ = forked(top_);
}

void MapTree::build(std::uint32_t index, const MapCell& cube, const MapCell* begin, const MapCell* end)
{
    constexpr std::ptrdiff_t few = 64; // sooner looked through than halved
    std::array<const MapCell*, 9> ends;
    Inner node{};
    ends[0] = begin;
    for (unsigned k = 0; k < 8; ++k) {
        const auto here = [&](const MapCell& cell) { return octant_in(cube, cell) == k; };
        ends[k + 1] =
            end - ends[k] > few ? std::partition_point(ends[k], end, here) : std::find_if_not(ends[k], end, here);
        if (ends[k + 1] == ends[k]) continue;
        (ends[k]->side == cube.side / 2 ? node.full : node.parted) |= static_cast<std::uint8_t>(1u << k);
    }
    node.first = static_cast<std::uint32_t>(nodes_.size());
    nodes_[index] = node;
    nodes_.resize(nodes_.size() + bits_in(node.parted));
    for (unsigned k = 0; k < 8; ++k)
        if (node.parted >> k & 1) {
            const Node child = below({index, cube}, k);
            build(child.index, child.cube, ends[k], ends[k + 1]);
        }
}

/// An octree has long chains of only children, above all where a map lies around the origin.
MapTree::Node MapTree::forked(Node node) const
{
    for (Inner inner = nodes_[node.index]; !inner.full && (inner.parted & (inner.parted - 1)) == 0;
         inner = nodes_[node.index])
        node = below(node, static_cast<unsigned>(__builtin_ctz(inner.parted)));
    return node;
}

MapTree::Node MapTree::child(const Node& node, unsigned lane) const
{
    if (node.index == root.index) return top_;
    if (node.index & whole) return {node.index & ~whole, node.cube};
    return forked(below(node, octant_of(nodes_[node.index], lane)));
}

MapTree::Entry MapTree::entry(const Aabb& box) const
{
    // A margin of half the box, so that what is left out is not merely apart.
    const double margin = 0.25 * (box.max - box.min).maxCoeff() + resolution_;
    const Eigen::Array3d low = ((box.min.array() - margin) / resolution_).floor(),
                         high = ((box.max.array() + margin) / resolution_).ceil();
    Node node = top_;
    while (true) {
        const Inner inner = nodes_[node.index];
        const std::int32_t half = node.cube.side / 2;
        const Eigen::Array3d middle(node.cube.x + half, node.cube.y + half, node.cube.z + half);
        unsigned there = inner.parted | inner.full; // octants that the box and the margin touch
        if (high.x() < middle.x()) there &= 0x55;
        if (low.x() > middle.x()) there &= 0xAA;
        if (high.y() < middle.y()) there &= 0x33;
        if (low.y() > middle.y()) there &= 0xCC;
        if (high.z() < middle.z()) there &= 0x0F;
        if (low.z() > middle.z()) there &= 0xF0;
        const double gap = margin * (1 - 0x1p-20);
        if (there == 0) return {std::nullopt, gap};
        if ((there & (there - 1)) || (there & inner.full)) return {Node{node.index | whole, node.cube}, gap};
        node = below(node, static_cast<unsigned>(__builtin_ctz(there)));
    }
}

LaneMasks MapTree::open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    // Octants are combinations of two halves along each axis, or of the whole. They reach far beyond the cells, and
    // floats so large would err by more than the walk allows for, so they are cut to the cells' bounds.
    const bool one = node.index & whole; // the root, too
    const double half = one ? node.cube.side : node.cube.side / 2;
    const std::int32_t low[3] = {node.cube.x, node.cube.y, node.cube.z};
    float centre[3][2], extent[3][2];
    for (int i = 0; i < 3; ++i)
        for (int side = 0; side < 2 - one; ++side) {
            double from = bounds_.min[i], to = bounds_.max[i];
            if (node.index != root.index) {
                from = std::max(from, (low[i] + side * half) * resolution_);
                to = std::min(to, (low[i] + (side + 1) * half) * resolution_);
            }
            centre[i][side] = static_cast<float>(0.5 * (from + to) - centre_[i]);
            extent[i][side] = static_cast<float>(0.5 * (to - from));
        }

    LaneMasks masks{0, 0};
    const Inner inner = one ? Inner{0, 1, 0} : nodes_[node.index];
    unsigned lanes = 0;
    for (unsigned all = inner.parted | inner.full; all; all &= all - 1, ++lanes) {
        const auto k = static_cast<unsigned>(__builtin_ctz(all));
        if (inner.full >> k & 1) masks.leaves |= 1u << lanes;
        float size = 0;
        for (unsigned i = 0; i < 3; ++i) {
            const unsigned side = k >> i & 1;
            boxes.c[i][lanes] = centre[i][side], boxes.h[i][lanes] = extent[i][side];
            size += extent[i][side] * extent[i][side];
        }
        boxes.size[lanes] = size;
    }
    masks.singles = masks.leaves;
    for (unsigned k = lanes; k < 8; ++k) {
        for (int i = 0; i < 3; ++i) boxes.c[i][k] = 1e30f, boxes.h[i][k] = 0;
        boxes.size[k] = 0;
    }
    if (!placement) {
        static constexpr float along[3][8] = {{1, 1, 1, 1, 1, 1, 1, 1}, {}, {}};
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < 3; ++i) std::copy_n(along[(i - axis + 3) % 3], 8, boxes.axis[axis][i]);
        return masks;
    }
    const float* r = placement->rotation;
    for (unsigned k = 0; k < lanes; ++k) {
        const float x = boxes.c[0][k], y = boxes.c[1][k], z = boxes.c[2][k];
        for (int i = 0; i < 3; ++i)
            boxes.c[i][k] = r[3 * i] * x + r[3 * i + 1] * y + r[3 * i + 2] * z + placement->translation[i];
    }
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 3; ++i) std::fill_n(boxes.axis[axis][i], 8, r[3 * i + axis]);
    return masks;
}

} // namespace oncollide
