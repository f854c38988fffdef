#include <oncollide/narrowphase/obb/map_tree.hpp>

#include <algorithm>

#include <oncollide/narrowphase/obb/oriented_box.hpp>

namespace oncollide {

namespace {

/// The octants of a cube that intersect or touch the box. Lowers `gap` to the distance of the other octants, in cells.
inline unsigned octants_at(const MapCell& cube, unsigned octants, const CellBox& box, int& gap)
{
    constexpr unsigned highs[3] = {0xAA, 0xCC, 0xF0};
    const std::int32_t middle[3] = {cube.x + cube.side / 2, cube.y + cube.side / 2, cube.z + cube.side / 2};
    for (int i = 0; i < 3; ++i) {
        const int below = middle[i] - box.high[i], above = box.low[i] - middle[i];
        const unsigned out = below > 0 ? octants & highs[i] : above > 0 ? octants & ~highs[i] : 0;
        if (!out) continue;
        octants ^= out;
        gap = std::min(gap, std::max(below, above));
    }
    return octants;
}

/// The keys of the first and the last cells of a box share the bits above the cube around the box.
struct KeysOfCells {
    Eigen::Array3i first;
    std::int32_t parts; ///< the bits that they do not share are not above this

    KeysOfCells(const CellBox& cells, int margin)
    {
        const auto key = [](const Eigen::Vector3i& cell) -> Eigen::Array3i {
            return (cell.array() - CellTree::lowest).max(0).min(CellTree::side - 1);
        };
        first = key(cells.low.array() - margin);
        const Eigen::Array3i last = key(cells.high.array() + (margin - 1));
        parts = (first.x() ^ last.x()) | (first.y() ^ last.y()) | (first.z() ^ last.z());
    }
    /// The octant, of side `half`, that holds the box. The first step takes the whole grid as octant 0.
    unsigned octant(std::int32_t half) const
    {
        return ((first.x() & half) != 0) | ((first.y() & half) != 0) << 1 | ((first.z() & half) != 0) << 2;
    }
};

} // namespace

MapTree::MapTree(const OccupancyMap& map)
    : map_(map), cells_(MapAccess::cells(map)), centre_(map.bounds().centre()),
      radius_(0.5 * map.bounds().diagonal() * (1 + 0x1p-50))
{
}

unsigned MapTree::solid_in_bounds(const Node& node) const
{
    const CellBox& bounds = MapAccess::cell_bounds(map_);
    int any = 0;
    return octants_at(node.cube, node.octants.solid, {bounds.low.array() + 1, bounds.high.array() - 1}, any);
}

/// Skips chains of single children; an octree has many of them where a map lies around the origin.
MapTree::Node MapTree::forked(Node node) const
{
    while (true) {
        const unsigned there = solid(node);
        if ((there & (there - 1)) || there == 0 || (cells_.whole(node.octants) & there)) return node;
        node = below(node, static_cast<unsigned>(__builtin_ctz(there)));
    }
}

MapTree::Node MapTree::child(const Node& node, unsigned lane) const
{
    if (node.cube.side == 0) return forked({cells_.top(), CellTree::top_cube});
    return forked(below(node, lane));
}

double MapTree::starts(const Aabb& box, double size, std::vector<Node>& nodes) const
{
    const double resolution = map_.resolution();
    const CellBox near = MapAccess::cells_touching(map_, box);
    // A margin of half the box, so that omitted cells have a useful distance.
    const int margin = (near.high - near.low).maxCoeff() / 4 + 1;
    const double large = size / (0.75 * resolution * resolution); // squared sides
    int gap = margin;                                             // cells
    nodes.clear();

    const KeysOfCells keys(near, margin + 1);
    Node node{cells_.top(), CellTree::top_cube};
    for (std::int32_t half = CellTree::side; half > keys.parts; half /= 2) {
        const unsigned k = keys.octant(half);
        if (!(node.octants.solid >> k & 1)) return gap * resolution * (1 - 0x1p-20);
        if (cells_.whole(node.octants) >> k & 1) break;
        node = below(node, k);
    }

    std::array<Node, 8 * 17> waiting;
    std::size_t count = 0;
    waiting[count++] = node;
    while (count) {
        node = waiting[--count];
        const unsigned inside = octants_at(node.cube, solid(node), near, gap);
        if (!inside) continue;
        const double half = node.cube.side / 2;
        if (half * half < large || (cells_.whole(node.octants) & inside))
            nodes.push_back(node);
        else
            for (unsigned left = inside; left; left &= left - 1)
                waiting[count++] = below(node, static_cast<unsigned>(__builtin_ctz(left)));
    }
    return gap * resolution * (1 - 0x1p-20);
}

std::optional<MapTree::Octant> MapTree::octant_around(const Aabb& box) const
{
    const CellBox near = MapAccess::cells_touching(map_, box), &all = MapAccess::cell_bounds(map_);
    const CellBox inside{near.low.cwiseMax(all.low), near.high.cwiseMin(all.high)};
    if (inside.empty()) return std::nullopt;
    const KeysOfCells keys(inside, 0);
    Octant octant{{cells_.top(), CellTree::top_cube}, 0, false};
    for (std::int32_t half = CellTree::side;; half /= 2) {
        octant.number = keys.octant(half);
        if (!(solid(octant.of) >> octant.number & 1)) return std::nullopt;
        octant.whole = cells_.whole(octant.of.octants) >> octant.number & 1;
        if (octant.whole || half / 2 <= keys.parts) return octant;
        octant.of = below(octant.of, octant.number);
    }
}

LaneMasks MapTree::open(const Node& node, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    // Octants are combinations of two halves along each axis, or of the whole. They extend far beyond the cells, where
    // floats would err by more than the traversal allows for, so they are clipped to the cells' bounds.
    const Aabb& bounds = map_.bounds();
    const bool whole = node.cube.side == 0;
    const double resolution = map_.resolution();
    const std::int32_t low[3] = {node.cube.x, node.cube.y, node.cube.z}, half = node.cube.side / 2;
    OctantBoxes octants;
    for (int i = 0; i < 3; ++i) {
        const double from = centre_[i] + (placement ? placement->from[i] : 0);
        const double least = whole ? bounds.min[i] : std::max(bounds.min[i], low[i] * resolution),
                     middle = (low[i] + half) * resolution,
                     most = whole ? bounds.max[i] : std::min(bounds.max[i], (low[i] + 2 * half) * resolution);
        const double to = whole ? most : std::min(middle, bounds.max[i]), next = std::max(middle, bounds.min[i]);
        octants.centre[i][0] = static_cast<float>(0.5 * (least + to) - from);
        octants.centre[i][1] = static_cast<float>(0.5 * (next + most) - from);
        octants.half[i][0] = static_cast<float>(0.5 * (to - least));
        octants.half[i][1] = static_cast<float>(0.5 * (most - next));
    }
    const unsigned lanes = whole ? 1 : solid(node), leaves = whole ? 0 : cells_.whole(node.octants) & lanes;
    oriented_box_kernel().open_octants(octants, lanes, placement, boxes);
    return {leaves, leaves};
}

} // namespace oncollide
