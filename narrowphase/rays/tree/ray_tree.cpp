#include <oncollide/narrowphase/rays/tree/ray_tree.hpp>

#include <algorithm>
#include <cmath>
#include <mutex>

#include <fmt/format.h>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/base/numbers/outward.hpp>
#include <oncollide/narrowphase/obb/oriented_box.hpp>

namespace oncollide {

namespace {

using Eigen::Vector3d;

constexpr std::uint32_t node_lines = sizeof(RayNode) / sizeof(NodeLine),
                        row_lines = sizeof(RayTriangles) / sizeof(NodeLine);

/// Boxes of more triangles are around the oriented box instead of its triangles, which takes no pass over them.
constexpr std::uint32_t most_read = 2048;

/// Every node has at least two boxes, and every box a row of at least one triangle. Lines at the ends of blocks stay
/// unused.
std::size_t most_lines(std::size_t triangles)
{
    const std::size_t lines = node_lines + (node_lines + row_lines) * triangles;
    return lines + (lines / (lines_per_block - 2 * row_lines) + 1) * 2 * row_lines;
}

} // namespace

struct RayTree::Item {
    std::array<float, 3> place; ///< three times the triangle's centre
    std::uint32_t triangle;
};

RayTree::RayTree(ObbTree& tree)
    : tree_(tree),
      rounding_(0x1p-45 * std::max(tree.bounds().min.cwiseAbs().maxCoeff(), tree.bounds().max.cwiseAbs().maxCoeff()) +
                1e-300),
      blocks_(most_lines(tree.mesh().triangles.size()) / lines_per_block + 1)
{
    const std::size_t table = blocks_.capacity() * sizeof(blocks_[0]);
    bytes_ += table;
    if (BoxTotals* totals = tree_.totals()) totals->bytes += table;
    const std::lock_guard lock(growing_);
    const auto triangles = static_cast<std::uint32_t>(tree.mesh().triangles.size());
    root_ = triangles > most_in_node ? node_over(tree.below_root()) : part(items_of(0, triangles));
}

RayTree::~RayTree()
{
    if (BoxTotals* totals = tree_.totals()) totals->bytes -= bytes();
    for (NodeLine* block : blocks_) delete[] block;
}

RayTree::Ref RayTree::add_lines(std::uint32_t count)
{
    if (lines_ % lines_per_block + count > lines_per_block) lines_ += lines_per_block - lines_ % lines_per_block;
    const Ref at = lines_;
    NodeLine*& block = blocks_[at / lines_per_block];
    if (!block) {
        const std::size_t room = std::min<std::size_t>(lines_per_block, most_lines(tree_.mesh().triangles.size()) -
                                                                            at / lines_per_block * lines_per_block);
        block = new NodeLine[room];
        bytes_ += room * sizeof(NodeLine);
        if (BoxTotals* totals = tree_.totals()) totals->bytes += room * sizeof(NodeLine);
    }
    lines_ += count;
    return at;
}

RayTree::Ref RayTree::add_node()
{
    const Ref at = add_lines(node_lines);
    auto& node = *new (&line(at)) RayNode{};
    for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < 8; ++k) node.low[axis][k] = float_infinity, node.high[axis][k] = -float_infinity;
    return at;
}

/// @param box  relative to the centre
void RayTree::set_bounds(RayNode& to, unsigned k, const Aabb& box) const
{
    for (int axis = 0; axis < 3; ++axis) {
        to.low[axis][k] = below(box.min[axis] - rounding_);
        to.high[axis][k] = above(box.max[axis] + rounding_);
    }
}

/// The triangles at these positions of the tree's order.
std::span<RayTree::Item> RayTree::items_of(std::uint32_t begin, std::uint32_t count)
{
    tree_.copy_order(begin, count, numbers_);
    items_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto [a, b, c] = tree_.corners(numbers_[i]);
        const Vector3d sum = (a - tree_.centre()) + (b - tree_.centre()) + (c - tree_.centre());
        items_[i] = {{float(sum.x()), float(sum.y()), float(sum.z())}, numbers_[i]};
    }
    return items_;
}

/// A node with the boxes of a node of the ObbTree.
RayTree::Ref RayTree::node_over(ObbTree::Node boxes)
{
    const Ref at = add_node();
    auto& to = node_at(at);
    to.boxes = boxes;
    OpenBoxes open;
    tree_.open(boxes, nullptr, open);
    for (unsigned k = 0; k < tree_.node(boxes).lanes; ++k) {
        const std::uint32_t count = tree_.count_of(boxes, k);
        Aabb box;
        if (count <= most_read) {
            tree_.copy_order(tree_.begin_of(boxes, k), count, numbers_);
            for (const std::uint32_t triangle : numbers_)
                for (const Vector3d& corner : tree_.corners(triangle)) box.add(corner - tree_.centre());
        } else {
            const Vector3d centre(open.c[0][k], open.c[1][k], open.c[2][k]);
            Vector3d half = Vector3d::Constant(open.margin);
            for (int which = 0; which < 3; ++which)
                for (int axis = 0; axis < 3; ++axis)
                    half[axis] += double(open.h[which][k]) * std::abs(open.axis[which][axis][k]);
            half += Vector3d::Constant(0x1p-20 * (half.sum() + centre.cwiseAbs().sum()));
            box = {centre - half, centre + half};
        }
        set_bounds(to, k, box);
    }
    return at;
}

RayTree::Ref RayTree::grow(Ref parent, unsigned k)
{
    const std::lock_guard lock(growing_);
    if (const Ref child = grown(parent, k)) return child; // another segment grew it first
    auto& above = node_at(parent);
    const std::uint32_t count = tree_.count_of(above.boxes, k);
    const Ref child = count > most_in_node ? node_over(tree_.child(above.boxes, k))
                                           : part(items_of(tree_.begin_of(above.boxes, k), count));
    std::atomic_ref(above.child[k]).store(child, std::memory_order_release);
    return child;
}

/// At most 128 triangles: one or two rows, or a node of at most eight times one or two rows.
RayTree::Ref RayTree::part(std::span<Item> items)
{
    const auto count = static_cast<std::uint32_t>(items.size());
    if (count <= 2 * row) return add_rows(items);
    const Ref at = add_node();
    auto& node = node_at(at);
    const std::uint32_t most = count <= 8 * row ? row : 2 * row;
    unsigned lanes = 0;
    divide(node, lanes, items, most, (count + most - 1) / most);
    return at;
}

/// Divides the items into boxes of at most `most` triangles: at the middle, or as near to it as full rows allow, across
/// the axis along which they extend farthest.
void RayTree::divide(RayNode& to, unsigned& lanes, std::span<Item> items, std::uint32_t most, unsigned into)
{
    if (into > 1) {
        std::array<float, 3> low = items[0].place, high = low;
        for (const Item& item : items)
            for (std::size_t axis = 0; axis < 3; ++axis)
                low[axis] = std::min(low[axis], item.place[axis]), high[axis] = std::max(high[axis], item.place[axis]);
        std::size_t axis = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
        const unsigned left = into / 2;
        const std::size_t half = std::min<std::size_t>(std::size_t(left) * most, items.size() * left / into + 1);
        const std::size_t at = std::max(half, items.size() - std::size_t(into - left) * most);
        std::nth_element(items.begin(), items.begin() + std::ptrdiff_t(at), items.end(),
                         [&](const Item& p, const Item& q) {
                             return std::pair(p.place[axis], p.triangle) < std::pair(q.place[axis], q.triangle);
                         });
        divide(to, lanes, items.first(at), most, left);
        divide(to, lanes, items.subspan(at), most, into - left);
        return;
    }
    Aabb box;
    for (const Item& item : items)
        for (const Vector3d& corner : tree_.corners(item.triangle)) box.add(corner - tree_.centre());
    set_bounds(to, lanes, box);
    to.child[lanes++] = add_rows(items);
}

RayTree::Ref RayTree::add_rows(std::span<const Item> items)
{
    const unsigned count = items.size() > row ? 2 : 1;
    const Ref at = add_lines(count * row_lines);
    for (unsigned r = 0; r < count; ++r) {
        const auto mine = items.subspan(r * row, std::min<std::size_t>(row, items.size() - r * row));
        auto& to = *new (&line(at + r * row_lines)) RayTriangles{};
        Aabb box;
        for (const Item& item : mine)
            for (const Vector3d& corner : tree_.corners(item.triangle)) box.add(corner - tree_.centre());
        Vector3d centre;
        for (int axis = 0; axis < 3; ++axis)
            centre[axis] = to.centre[axis] = static_cast<float>(0.5 * (box.min[axis] + box.max[axis]));
        const double reach = std::max((box.max - centre).maxCoeff(), (centre - box.min).maxCoeff());
        to.unit = static_cast<float>(std::max({reach / 32760, 0x1p-60 * tree_.radius(), 1e-30}));
        for (std::size_t i = 0; i < row; ++i) {
            to.triangle[i] = mine[std::min(i, mine.size() - 1)].triangle;
            const TrianglePoints corners = tree_.corners(to.triangle[i]);
            for (std::size_t c = 0; c < 3; ++c)
                for (int axis = 0; axis < 3; ++axis) {
                    const double at_unit = (corners[c][axis] - tree_.centre()[axis] - centre[axis]) / double(to.unit);
                    to.corner[c][axis][i] =
                        static_cast<std::int16_t>(std::lrint(std::clamp(at_unit, -32767.0, 32767.0)));
                }
        }
    }
    return at | rows_bit | (count == 2 ? two_bit : 0);
}

std::string RayTree::validate() const
{
    std::vector<std::pair<Ref, Aabb>> waiting{
        {root_, {Vector3d::Constant(-float_infinity), Vector3d::Constant(float_infinity)}}};
    std::vector<std::uint8_t> seen(tree_.mesh().triangles.size());
    bool whole = true;
    while (!waiting.empty()) {
        const auto [ref, box] = waiting.back();
        waiting.pop_back();
        if (!is_rows(ref)) {
            const RayNode& n = node(ref);
            for (unsigned k = 0; k < 8; ++k) {
                if (n.low[0][k] == float_infinity) continue;
                if (!grown(ref, k)) {
                    whole = false;
                    continue;
                }
                waiting.push_back({grown(ref, k),
                                   {Vector3d(n.low[0][k], n.low[1][k], n.low[2][k]),
                                    Vector3d(n.high[0][k], n.high[1][k], n.high[2][k])}});
            }
            continue;
        }
        for (unsigned r = 0; r < rows_in(ref); ++r)
            for (const std::uint32_t triangle : rows(ref)[r].triangle) {
                seen[triangle] = 1;
                for (const Vector3d& corner : tree_.corners(triangle)) {
                    const Vector3d at = corner - tree_.centre();
                    if ((at - box.min).minCoeff() < 0 || (box.max - at).minCoeff() < 0)
                        return fmt::format("triangle {} is outside its box", triangle);
                }
            }
    }
    if (whole && std::ranges::find(seen, 0) != seen.end()) return "a triangle is missing";
    return {};
}

} // namespace oncollide
