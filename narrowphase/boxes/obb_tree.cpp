#include <oncollide/narrowphase/boxes/obb_tree.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include <oncollide/narrowphase/boxes/oriented_box.hpp>

namespace oncollide {

namespace {

constexpr unsigned most_lanes = 8;
/// Triangles whose box is fitted. Boxes of more lie along the mesh's axes: fitting costs ten times what looking at
/// bounds does, and of a mesh so large the first answer would wait for it.
constexpr std::size_t most_fitted = 16384;
/// Of more the upper levels come from a grid.
constexpr std::size_t most_halved = 131072;

} // namespace

ObbTree::ObbTree(const Mesh& mesh)
    : mesh_(mesh), centre_(mesh.bounds.centre()), radius_(0), chunks_(most_nodes(mesh) / chunk + 1)
{
    for (const Triangle& t : mesh.triangles)
        for (std::uint32_t v : t) radius_ = std::max(radius_, (mesh.vertices[v] - centre_).squaredNorm());
    radius_ = std::sqrt(radius_) * (1 + 0x1p-50) + 1e-150;

    BoxNode& node = at(add_node());
    set_frame(node, Eigen::Vector3d::Zero(), 2 * radius_); // the box's corners are farther out
    const Eigen::Vector3d half = mesh.bounds.half_extent();
    quantise_along_axes(node, 0, {-half, half});
    node.lanes = 1, node.begin[0] = 0, node.count[0] = static_cast<std::uint32_t>(mesh.triangles.size());
    node.leaves = node.count[0] <= leaf_triangles, node.singles = node.count[0] == 1;
    if (node.leaves) number_triangles();
}

LaneMasks ObbTree::open(Node index, const BoxPlacement* placement, OpenBoxes& boxes) const
{
    const BoxNode& from = node(index);
    oriented_box_kernel().open(from, placement, boxes);
    return {from.leaves, from.singles};
}

void ObbTree::number_triangles()
{
    order_.resize(mesh_.triangles.size());
    std::iota(order_.begin(), order_.end(), 0u);
}

/// No more than there can be: rays and boxes are small meshes.
std::size_t ObbTree::room_in(const Mesh& mesh, std::size_t number)
{
    return std::min<std::size_t>(chunk, most_nodes(mesh) - number * chunk);
}

std::uint32_t ObbTree::add_node()
{
    const std::uint32_t index = used_.fetch_add(1);
    if (!chunks_[index / chunk]) chunks_[index / chunk] = std::make_unique<BoxNode[]>(room_in(mesh_, index / chunk));
    return index;
}

std::uint32_t ObbTree::grow(std::uint32_t parent, unsigned k)
{
    const std::lock_guard lock(growing_);
    BoxNode& above = at(parent);
    if (above.child[k]) return above.child[k]; // another walk was first
    if (order_.empty()) number_triangles();
    const std::uint32_t begin = above.begin[k], count = above.count[k];
    if (count > most_halved)
        if (const std::uint32_t index = grow_by_grid(above, k)) return index;
    items_.clear();
    items_.reserve(count);
    for (std::uint32_t id : std::span(order_).subspan(begin, count)) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero(); // of floats: exact, whatever the order of the corners
        for (std::uint32_t v : mesh_.triangles[id]) sum += (mesh_.vertices[v] - centre_).cast<float>().cast<double>();
        const Eigen::Vector3f place = sum.cast<float>();
        items_.push_back({{place.x(), place.y(), place.z()}, id});
    }
    const std::uint32_t index = add_node();
    BoxNode& node = at(index);
    set_frame(node, centre_of(above, k), radius_of(above, k));
    if (count > leaf_triangles)
        split(node, items_, std::min(most_lanes, count), begin);
    else // a leaf: others may be reading the order of its triangles, which must stay
        for (std::uint32_t i = 0; i < count; ++i) add_lane(node, std::span(items_).subspan(i, 1), begin + i);
    if (count > most_fitted) items_ = {}, points_ = {}; // rarely needed again, and then less
    std::atomic_ref(above.child[k]).store(index, std::memory_order_release);
    return index;
}

/// All levels at once down to parts of a few thousand triangles. 0: the grid cannot tell them apart.
std::uint32_t ObbTree::grow_by_grid(BoxNode& above, unsigned k)
{
    const Eigen::Vector3d middle = centre_of(above, k), reach = Eigen::Vector3d::Constant(radius_of(above, k));
    const Eigen::Vector3d half = mesh_.bounds.half_extent();
    const Aabb around{(middle - reach).cwiseMax(-half), (middle + reach).cwiseMin(half)};
    const std::uint32_t begin = above.begin[k];
    const GridPart all = split_by_grid(mesh_, centre_, std::span(order_).subspan(begin, above.count[k]), around);
    if (all.parts.empty()) return 0;
    const std::uint32_t index = add_nodes(all, begin);
    std::atomic_ref(above.child[k]).store(index, std::memory_order_release);
    return index;
}

std::uint32_t ObbTree::add_nodes(const GridPart& part, std::uint32_t begin)
{
    const std::uint32_t index = add_node();
    BoxNode& node = at(index);
    set_frame(node, part.box.centre(), part.box.half_extent().norm());
    for (const GridPart& lane : part.parts) {
        const unsigned k = node.lanes++;
        node.begin[k] = begin + lane.begin, node.count[k] = lane.count;
        node.leaves |= unsigned(lane.count <= leaf_triangles) << k;
        node.singles |= unsigned(lane.count == 1) << k;
        quantise_along_axes(node, k, lane.box);
        if (!lane.parts.empty()) node.child[k] = add_nodes(lane, begin);
    }
    return index;
}

/// Along the axis; of triangles with one centre, by their corners: so the parts do not depend on the order in the file.
bool ObbTree::before(const Item& x, const Item& y, int axis) const
{
    for (int k = 0; k < 3; ++k, axis = (axis + 1) % 3)
        if (x.place[axis] != y.place[axis]) return x.place[axis] < y.place[axis];
    const auto sorted = [this](std::uint32_t triangle) {
        std::array<std::array<double, 3>, 3> corners;
        for (std::size_t k = 0; k < 3; ++k)
            Eigen::Map<Eigen::Vector3d>(corners[k].data()) = mesh_.vertices[mesh_.triangles[triangle][k]];
        std::sort(corners.begin(), corners.end());
        return corners;
    };
    const auto corners_x = sorted(x.triangle), corners_y = sorted(y.triangle);
    return corners_x != corners_y ? corners_x < corners_y : x.triangle < y.triangle;
}

/// So that the first `half` items come before() the others. The places are in [low, high] along the axis. Of many items
/// most are told apart by counting those in each of some thousand slices.
void ObbTree::halve(std::span<Item> items, std::size_t half, int axis, float low, float high) const
{
    constexpr std::size_t many = 8192, slices = 4096;
    if (items.size() >= many && high > low) {
        const float scale = slices / (high - low);
        const auto slice_of = [=](const Item& item) {
            return std::min(static_cast<std::uint32_t>((item.place[axis] - low) * scale), std::uint32_t(slices - 1));
        };
        std::vector<std::uint32_t> counts(slices);
        for (const Item& item : items) ++counts[slice_of(item)];
        std::uint32_t slice = 0;
        std::size_t before = 0;
        while (before + counts[slice] < half) before += counts[slice++];
        std::partition(items.begin(), items.end(), [&](const Item& item) { return slice_of(item) < slice; });
        items = items.subspan(before), half -= before;
        std::partition(items.begin(), items.end(), [&](const Item& item) { return slice_of(item) == slice; });
        items = items.first(counts[slice]);
    }
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                     [this, axis](const Item& x, const Item& y) { return before(x, y, axis); });
}

/// Halves the items, across the axis along which they spread most, until there is a part for each lane.
void ObbTree::split(BoxNode& node, std::span<Item> items, unsigned lanes, std::uint32_t begin)
{
    if (lanes == 1) return add_lane(node, items, begin);
    float low[3], high[3];
    std::fill(low, low + 3, std::numeric_limits<float>::infinity());
    std::fill(high, high + 3, -std::numeric_limits<float>::infinity());
    for (const Item& item : items)
        for (int axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], item.place[axis]), high[axis] = std::max(high[axis], item.place[axis]);
    int axis = 0;
    for (int other = 1; other < 3; ++other)
        if (high[other] - low[other] > high[axis] - low[axis]) axis = other;
    const std::size_t half = items.size() * (lanes / 2) / lanes;
    halve(items, half, axis, low[axis], high[axis]);
    split(node, items.first(half), lanes / 2, begin);
    split(node, items.subspan(half), lanes - lanes / 2, begin + static_cast<std::uint32_t>(half));
}

void ObbTree::add_lane(BoxNode& node, std::span<const Item> items, std::uint32_t begin)
{
    const unsigned k = node.lanes++;
    node.begin[k] = begin, node.count[k] = static_cast<std::uint32_t>(items.size());
    node.leaves |= unsigned(items.size() <= leaf_triangles) << k;
    node.singles |= unsigned(items.size() == 1) << k;
    for (std::size_t i = 0; i < items.size(); ++i) {
        std::uint32_t& place = order_[begin + i];
        if (place != items[i].triangle) place = items[i].triangle;
    }
    const auto corner = [&](const Item& item, std::size_t c) -> Eigen::Vector3d {
        return mesh_.vertices[mesh_.triangles[item.triangle][c]] - centre_;
    };
    if (items.size() > most_fitted) {
        Aabb box;
        for (const Item& item : items)
            for (std::size_t c = 0; c < 3; ++c) box.add(corner(item, c));
        quantise_along_axes(node, k, box);
        return;
    }
    points_.clear();
    for (const Item& item : items) points_.push_back({corner(item, 0), corner(item, 1), corner(item, 2)});
    quantise(node, k, fit_box(points_), points_);
}

std::size_t ObbTree::most_bytes(const Mesh& mesh)
{
    const std::size_t triangles = mesh.triangles.size(), chunks = most_nodes(mesh) / chunk + 1;
    return most_nodes(mesh) * sizeof(BoxNode) + chunks * sizeof(chunks_[0]) +
           triangles * (sizeof(order_[0]) + 2 * (sizeof(Item) + sizeof(TrianglePoints)));
}

std::size_t ObbTree::bytes() const
{
    std::size_t nodes = 0;
    for (std::size_t c = 0; c < chunks_.size(); ++c)
        if (chunks_[c]) nodes += room_in(mesh_, c);
    return nodes * sizeof(BoxNode) + chunks_.capacity() * sizeof(chunks_[0]) + order_.capacity() * sizeof(order_[0]) +
           items_.capacity() * sizeof(Item) + points_.capacity() * sizeof(TrianglePoints);
}

} // namespace oncollide
