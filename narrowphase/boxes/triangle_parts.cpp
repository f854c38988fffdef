#include <oncollide/narrowphase/boxes/triangle_parts.hpp>

#include <algorithm>
#include <limits>

namespace oncollide {

namespace {

/// Triangles that are halved at their median: a better cut of so few costs more than it saves; those that are sorted to
/// try every cut; of more, cuts are tried between slices.
constexpr std::size_t most_halved = 16, most_sorted = 64, most_tried = most_sorted / 5 + 2;

constexpr float infinite = std::numeric_limits<float>::infinity();

} // namespace

const std::size_t TriangleParts::bytes_each =
    sizeof(Item) + sizeof(Bounds) + sizeof(TrianglePoints) + sizeof(std::uint32_t);

/// Bounds of what was added so far.
struct TriangleParts::Growing {
    Eigen::Array4f low{infinite, infinite, infinite, 0}, high{-infinite, -infinite, -infinite, 0};

    void add(const auto& other) { low = low.min(other.low), high = high.max(other.high); }
    void add_point(const std::array<float, 3>& p)
    {
        const Eigen::Array4f v(p[0], p[1], p[2], 0);
        low = low.min(v), high = high.max(v);
    }
    Eigen::Array4f extent() const { return high - low; }
    float area() const
    {
        const Eigen::Array4f e = extent();
        return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
    }
};

void TriangleParts::start(const Source& mesh, const Eigen::Vector3d& centre, std::span<const std::uint32_t> triangles)
{
    const std::size_t size = triangles.size();
    numbers_ = mesh.numbers;
    triangles_.assign(triangles.begin(), triangles.end());
    items_.resize(size);
    if (bounds_.size() < size) bounds_.resize(size), corners_.resize(size); // else there is room
    for (std::size_t i = 0; i < size; ++i) {
        Growing bounds;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero(); // of floats: exact, whatever the order of the corners
        for (std::size_t c = 0; c < 3; ++c) {
            const Eigen::Vector3d& p = corners_[i][c] = mesh.vertices[mesh.triangles[triangles[i]][c]] - centre;
            const Eigen::Vector3f rounded = p.cast<float>();
            sum += rounded.cast<double>();
            bounds.add_point({rounded.x(), rounded.y(), rounded.z()});
        }
        bounds_[i] = {bounds.low, bounds.high};
        items_[i] = {{static_cast<float>(sum.x()), static_cast<float>(sum.y()), static_cast<float>(sum.z())},
                     static_cast<std::uint32_t>(i)};
    }
}

void TriangleParts::split(unsigned parts)
{
    split(items_, parts, 0, 0);
}

/// Of items that begin there the parts from `first` on.
void TriangleParts::split(std::span<Item> items, unsigned parts, std::size_t begin, unsigned first)
{
    if (parts == 1) {
        ends_[first] = begin + items.size();
        return;
    }
    const unsigned low_parts = parts / 2, high_parts = parts - low_parts;
    const std::size_t size = items.size(), half = size * low_parts / parts;
    const std::size_t away = std::min({size / 10, half - low_parts, size - high_parts - half});
    const std::size_t least = half - away, most = half + away;

    Growing places;
    for (const Item& item : items) places.add_point(item.place);
    const Eigen::Array4f extent = places.extent();
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (extent[axis] > extent[longest]) longest = axis;
    Cut best{longest, half, infinite};
    for (int axis = 0; size > most_halved && axis < 3; ++axis) {
        if (!(extent[axis] > 0.5f * extent[longest])) continue;
        const Cut cut = size <= most_sorted
                            ? best_of_few(items, least, most, axis)
                            : best_of_slices(items, least, most, axis, places.low[axis], places.high[axis]);
        if (cut.cost < best.cost) best = cut;
    }
    halve(items, best.at, best.axis, places.low[best.axis], places.high[best.axis]);
    split(items.first(best.at), low_parts, begin, first);
    split(items.subspan(best.at), high_parts, begin + best.at, first + low_parts);
}

/// Along the axis.
inline bool TriangleParts::before(const Item& x, const Item& y, int axis) const
{
    const auto a = static_cast<std::size_t>(axis);
    return x.place[a] != y.place[a] ? x.place[a] < y.place[a] : before_in_a_tie(x, y, axis);
}

/// Of triangles with one centre, by their corners: so the parts do not depend on the order in the file.
bool TriangleParts::before_in_a_tie(const Item& x, const Item& y, int axis) const
{
    for (int k = 0; k < 2; ++k) {
        axis = (axis + 1) % 3;
        const auto a = static_cast<std::size_t>(axis);
        if (x.place[a] != y.place[a]) return x.place[a] < y.place[a];
    }
    const auto sorted = [this](const Item& item) {
        std::array<std::array<double, 3>, 3> corners;
        for (std::size_t c = 0; c < 3; ++c) Eigen::Map<Eigen::Vector3d>(corners[c].data()) = corners_[item.number][c];
        std::sort(corners.begin(), corners.end());
        return corners;
    };
    const auto corners_x = sorted(x), corners_y = sorted(y);
    if (corners_x != corners_y) return corners_x < corners_y;
    const std::uint32_t a = triangles_[x.number], b = triangles_[y.number];
    return numbers_ ? numbers_[a] < numbers_[b] : a < b;
}

/// So that the first `half` items come before() the others. The places are in [low, high] along the axis. Of many items
/// most are told apart by counting those in each of some thousand slices.
void TriangleParts::halve(std::span<Item> items, std::size_t half, int axis, float low, float high) const
{
    constexpr std::size_t many = 8192, slices = 4096;
    const auto a = static_cast<std::size_t>(axis);
    if (items.size() >= many && high > low) {
        const float scale = slices / (high - low);
        const auto slice_of = [=](const Item& item) {
            return std::min(static_cast<std::uint32_t>((item.place[a] - low) * scale), std::uint32_t(slices - 1));
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

/// The best cut along the axis of those that leave `least` to `most` items on the first side, by trying each: sorts the
/// items between.
TriangleParts::Cut TriangleParts::best_of_few(std::span<Item> items, std::size_t least, std::size_t most,
                                              int axis) const
{
    const auto first = items.begin(), from = first + std::ptrdiff_t(least), to = first + std::ptrdiff_t(most);
    const auto in_order = [this, axis](const Item& x, const Item& y) { return before(x, y, axis); };
    std::nth_element(first, from, items.end(), in_order);
    if (most > least) {
        std::nth_element(from, to, items.end(), in_order);
        std::sort(from, to, in_order);
    }
    Growing below, above;
    for (const Item& item : items.first(least)) below.add(bounds_[item.number]);
    for (const Item& item : items.subspan(most)) above.add(bounds_[item.number]);
    std::array<float, most_tried> areas_above; // of the items from `least` + i on
    for (std::size_t i = most - least + 1; i-- > 0;) {
        areas_above[i] = above.area();
        if (i > 0) above.add(bounds_[items[least + i - 1].number]);
    }
    Cut best{axis, least, infinite};
    for (std::size_t at = least; at <= most; ++at) {
        const float cost = float(at) * below.area() + float(items.size() - at) * areas_above[at - least];
        if (cost < best.cost) best = {axis, at, cost};
        if (at < most) below.add(bounds_[items[at].number]);
    }
    return best;
}

/// The same of many items, between slices across the axis along which their places are in [low, high].
TriangleParts::Cut TriangleParts::best_of_slices(std::span<const Item> items, std::size_t least, std::size_t most,
                                                 int axis, float low, float high) const
{
    constexpr std::size_t slices = 32;
    struct Slice {
        Growing bounds;
        std::size_t count = 0;
    };
    std::array<Slice, slices> slice;
    const auto a = static_cast<std::size_t>(axis);
    const float scale = slices / (high - low);
    for (const Item& item : items) {
        Slice& s = slice[std::min(static_cast<std::size_t>((item.place[a] - low) * scale), slices - 1)];
        s.bounds.add(bounds_[item.number]), ++s.count;
    }
    std::array<float, slices> areas_above;
    Growing above, below;
    for (std::size_t i = slices; i-- > 0;) above.add(slice[i].bounds), areas_above[i] = above.area();
    Cut best{axis, 0, infinite};
    std::size_t at = 0;
    for (std::size_t i = 0; i + 1 < slices; ++i) {
        below.add(slice[i].bounds), at += slice[i].count;
        if (at < least || at > most) continue;
        const float cost = float(at) * below.area() + float(items.size() - at) * areas_above[i + 1];
        if (cost < best.cost) best = {axis, at, cost};
    }
    return best;
}

Aabb TriangleParts::bounds(std::size_t from, std::size_t to) const
{
    Growing all;
    for (std::size_t i = from; i < to; ++i) all.add(bounds_[items_[i].number]);
    return {all.low.head<3>().matrix().cast<double>(), all.high.head<3>().matrix().cast<double>()};
}

} // namespace oncollide
