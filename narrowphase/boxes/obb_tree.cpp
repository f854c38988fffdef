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
/// Room for so many is kept from one node to the next.
constexpr std::size_t most_kept = 256;
/// Of more the upper levels come from a grid.
constexpr std::size_t most_split = 131072;
/// Items that are halved at their median; those that are sorted to try every cut; of more, cuts are tried between
/// slices.
constexpr std::size_t most_halved = 16, most_sorted = 64, most_tried = most_sorted / 5 + 2;

std::atomic<std::uint32_t> trees_made = 1;

/// A box along the mesh's axes.
struct ItemBounds {
    float low[3] = {most, most, most}, high[3] = {-most, -most, -most};

    void add(const auto& other)
    {
        for (int axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], other.low[axis]), high[axis] = std::max(high[axis], other.high[axis]);
    }
    void add_place(const auto& item)
    {
        for (int axis = 0; axis < 3; ++axis)
            low[axis] = std::min(low[axis], item.place[axis]), high[axis] = std::max(high[axis], item.place[axis]);
    }
    float area() const
    {
        const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
        return x * y + y * z + z * x;
    }
    float extent(int axis) const { return high[axis] - low[axis]; }
    int longest() const
    {
        int axis = 0;
        for (int other = 1; other < 3; ++other)
            if (extent(other) > extent(axis)) axis = other;
        return axis;
    }

private:
    static constexpr float most = std::numeric_limits<float>::infinity();
};

} // namespace

ObbTree::ObbTree(const Mesh& mesh)
    : mesh_(mesh), identity_(trees_made.fetch_add(1, std::memory_order_relaxed)), centre_(mesh.bounds.centre()),
      radius_(0), chunks_(most_nodes(mesh) / chunk + 1)
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
    if (count > most_split)
        if (const std::uint32_t index = grow_by_grid(above, k)) return index;
    items_.clear();
    items_.reserve(count);
    for (std::uint32_t id : std::span(order_).subspan(begin, count)) {
        items_.push_back(item_of(id));
    }
    const std::uint32_t index = add_node();
    BoxNode& node = at(index);
    set_frame(node, centre_of(above, k), radius_of(above, k));
    if (count > leaf_triangles)
        split(node, items_, std::min(most_lanes, count), begin);
    else // a leaf: others may be reading the order of its triangles, which must stay
        for (std::uint32_t i = 0; i < count; ++i) add_lane(node, std::span(items_).subspan(i, 1), begin + i);
    if (count > most_kept) items_ = {}, points_ = {}; // rarely needed again, and then less
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

/// Along the axis.
inline bool ObbTree::before(const Item& x, const Item& y, int axis) const
{
    return x.place[axis] != y.place[axis] ? x.place[axis] < y.place[axis] : before_in_a_tie(x, y, axis);
}

/// Of triangles with one centre, by their corners: so the parts do not depend on the order in the file.
bool ObbTree::before_in_a_tie(const Item& x, const Item& y, int axis) const
{
    for (int k = 0; k < 2; ++k) {
        axis = (axis + 1) % 3;
        if (x.place[axis] != y.place[axis]) return x.place[axis] < y.place[axis];
    }
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

ObbTree::Item ObbTree::item_of(std::uint32_t triangle) const
{
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(); // of floats: exact, whatever the order of the corners
    Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (std::uint32_t v : mesh_.triangles[triangle]) {
        const Eigen::Vector3f p = (mesh_.vertices[v] - centre_).cast<float>();
        sum += p.cast<double>(), low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
    Item item;
    for (int axis = 0; axis < 3; ++axis)
        item.place[axis] = static_cast<float>(sum[axis]), item.low[axis] = low[axis], item.high[axis] = high[axis];
    item.triangle = triangle;
    return item;
}

/// The best cut along the axis of those that leave `least` to `most` items on the first side, by trying each: sorts the
/// items between.
ObbTree::Cut ObbTree::best_of_few(std::span<Item> items, std::size_t least, std::size_t most, int axis) const
{
    const auto first = items.begin(), from = first + std::ptrdiff_t(least), to = first + std::ptrdiff_t(most);
    const auto in_order = [this, axis](const Item& x, const Item& y) { return before(x, y, axis); };
    std::nth_element(first, from, items.end(), in_order);
    if (most > least) {
        std::nth_element(from, to, items.end(), in_order);
        std::sort(from, to, in_order);
    }
    ItemBounds below, above;
    for (const Item& item : items.first(least)) below.add(item);
    for (const Item& item : items.subspan(most)) above.add(item);
    std::array<float, most_tried> areas_above; // of the items from `least` + i on
    for (std::size_t i = most - least + 1; i-- > 0;) {
        areas_above[i] = above.area();
        if (i > 0) above.add(items[least + i - 1]);
    }
    Cut best{axis, least, std::numeric_limits<float>::infinity()};
    for (std::size_t at = least; at <= most; ++at) {
        const float cost = float(at) * below.area() + float(items.size() - at) * areas_above[at - least];
        if (cost < best.cost) best = {axis, at, cost};
        if (at < most) below.add(items[at]);
    }
    return best;
}

/// The same of many items, between slices across the axis along which their places are in [low, high].
ObbTree::Cut ObbTree::best_of_slices(std::span<const Item> items, std::size_t least, std::size_t most, int axis,
                                     float low, float high) const
{
    constexpr std::size_t slices = 64;
    struct Slice {
        ItemBounds bounds;
        std::size_t count = 0;
    };
    std::array<Slice, slices> slice;
    const float scale = slices / (high - low);
    for (const Item& item : items) {
        Slice& s = slice[std::min(static_cast<std::size_t>((item.place[axis] - low) * scale), slices - 1)];
        s.bounds.add(item), ++s.count;
    }
    std::array<float, slices> areas_above;
    ItemBounds above, below;
    for (std::size_t i = slices; i-- > 0;) above.add(slice[i].bounds), areas_above[i] = above.area();
    Cut best{axis, 0, std::numeric_limits<float>::infinity()};
    std::size_t at = 0;
    for (std::size_t i = 0; i + 1 < slices; ++i) {
        below.add(slice[i].bounds), at += slice[i].count;
        if (at < least || at > most) continue;
        const float cost = float(at) * below.area() + float(items.size() - at) * areas_above[i + 1];
        if (cost < best.cost) best = {axis, at, cost};
    }
    return best;
}

/// Parts the items until there is a part for each lane.
void ObbTree::split(BoxNode& node, std::span<Item> items, unsigned lanes, std::uint32_t begin)
{
    if (lanes == 1) return add_lane(node, items, begin);
    const unsigned low_lanes = lanes / 2, high_lanes = lanes - low_lanes;
    const std::size_t size = items.size(), half = size * low_lanes / lanes;
    const std::size_t away = std::min({size / 10, half - low_lanes, size - high_lanes - half});
    const std::size_t least = half - away, most = half + away;

    ItemBounds places;
    for (const Item& item : items) places.add_place(item);
    const int longest = places.longest();
    Cut best{longest, half, std::numeric_limits<float>::infinity()};
    for (int axis = 0; size > most_halved && axis < 3; ++axis) { // of the fewest a better cut costs more than it saves
        if (!(places.extent(axis) > 0.5f * places.extent(longest))) continue;
        const Cut cut = size <= most_sorted
                            ? best_of_few(items, least, most, axis)
                            : best_of_slices(items, least, most, axis, places.low[axis], places.high[axis]);
        if (cut.cost < best.cost) best = cut;
    }
    halve(items, best.at, best.axis, places.low[best.axis], places.high[best.axis]);
    split(node, items.first(best.at), low_lanes, begin);
    split(node, items.subspan(best.at), high_lanes, begin + static_cast<std::uint32_t>(best.at));
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
