#include <oncollide/narrowphase/boxes/triangle_parts.hpp>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include <oncollide/base/prefetch.hpp>

namespace oncollide {

namespace {

/// Triangles that are halved at their median: a better cut of so few costs more than it saves; those that are sorted to
/// try every cut; of more, cuts are tried between slices.
constexpr std::size_t most_halved = 16, most_sorted = 64, most_tried = most_sorted / 5 + 2;

constexpr float infinite = std::numeric_limits<float>::infinity();

using F32x4 = float __attribute__((vector_size(16)));
using F64x4 = double __attribute__((vector_size(32)));

Eigen::Array4f four(const auto& numbers)
{
    static_assert(sizeof numbers == sizeof(Eigen::Array4f));
    Eigen::Array4f same;
    std::memcpy(same.data(), &numbers, sizeof same);
    return same;
}

} // namespace

const std::size_t TriangleParts::bytes_each =
    2 * sizeof(Item) + sizeof(Bounds) + sizeof(TrianglePoints) + sizeof(std::uint32_t);

/// Bounds of what was added so far.
struct TriangleParts::Growing {
    Eigen::Array4f low{infinite, infinite, infinite, 0}, high{-infinite, -infinite, -infinite, 0};

    void add(const auto& other) { low = low.min(other.low), high = high.max(other.high); }
    void add_point(const Eigen::Array4f& p) { low = low.min(p), high = high.max(p); }
    /// The fourth lane says nothing then.
    void add_place(const Item& item) { add_point(four(item)); }
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
    if (bounds_.size() < size) bounds_.resize(size), corners_.resize(size), above_.resize(size); // else there is room
    const F64x4 middle{centre.x(), centre.y(), centre.z(), 0};
    constexpr std::size_t ahead = 8; // triangles; of a large mesh they are in no cache
    for (std::size_t i = 0; i < size; ++i) {
        if (i + 2 * ahead < size) prefetch(&mesh.triangles[triangles[i + 2 * ahead]]);
        if (i + ahead < size)
            for (const std::uint32_t v : mesh.triangles[triangles[i + ahead]]) prefetch(&mesh.vertices[v]);
        Growing bounds;
        F64x4 sum{}; // of floats: exact, whatever the order of the corners
        for (std::size_t c = 0; c < 3; ++c) {
            const Eigen::Vector3d& v = mesh.vertices[mesh.triangles[triangles[i]][c]];
            const F64x4 p = F64x4{v.x(), v.y(), v.z(), 0} - middle;
            corners_[i][c] = {p[0], p[1], p[2]};
            const F32x4 rounded = __builtin_convertvector(p, F32x4);
            sum += __builtin_convertvector(rounded, F64x4);
            bounds.add_point(four(rounded));
        }
        bounds_[i] = {bounds.low, bounds.high};
        items_[i] = std::bit_cast<Item>(__builtin_convertvector(sum, F32x4));
        items_[i].number = static_cast<std::uint32_t>(i);
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
    for (const Item& item : items) places.add_place(item);
    const Eigen::Array4f extent = places.extent();
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (extent[axis] > extent[longest]) longest = axis;
    Cut best{longest, half, infinite};
    int sorted = -1; // axis along which they lie as best_of_few() left them
    for (int axis = 0; size > most_halved && axis < 3; ++axis) {
        if (!(extent[axis] > 0.5f * extent[longest])) continue;
        Cut cut;
        if (size <= most_sorted)
            cut = best_of_few(items, least, most, sorted = axis);
        else
            cut = best_of_slices(items, least, most, {axis, places.low[axis], places.high[axis]});
        if (cut.cost < best.cost) best = cut;
    }
    const Slices slices{best.axis, places.low[best.axis], places.high[best.axis]};
    if (best.slice > 0)
        part(items, [&](const Item& item) { return slices.of(item) < best.slice; });
    else if (best.axis != sorted)
        halve(items, best.at, slices);
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

/// Those of which `first` is true before the others. Without branches: which way one goes cannot be foreseen.
void TriangleParts::part(std::span<Item> items, auto first)
{
    std::size_t below = 0, above = 0;
    for (const Item item : items) {
        const bool goes_below = first(item);
        items[below] = above_[above] = item;
        below += goes_below, above += !goes_below;
    }
    std::copy_n(above_.begin(), above, items.begin() + static_cast<std::ptrdiff_t>(below));
}

/// So that the first `half` items come before() the others. Of many items most are told apart by counting those in
/// each slice.
void TriangleParts::halve(std::span<Item> items, std::size_t half, const Slices& slices)
{
    constexpr std::size_t many = 8192;
    if (items.size() >= many && slices.high > slices.low) {
        const Slices fine{slices.axis, slices.low, slices.high, 4096};
        std::vector<std::uint32_t> counts(fine.number);
        for (const Item& item : items) ++counts[fine.of(item)];
        std::uint32_t slice = 0;
        std::size_t before = 0;
        while (before + counts[slice] < half) before += counts[slice++];
        part(items, [&](const Item& item) { return fine.of(item) < slice; });
        items = items.subspan(before), half -= before;
        part(items, [&](const Item& item) { return fine.of(item) == slice; });
        items = items.first(counts[slice]);
    }
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(half), items.end(),
                     [this, axis = slices.axis](const Item& x, const Item& y) { return before(x, y, axis); });
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

/// The same of many items, between slices.
TriangleParts::Cut TriangleParts::best_of_slices(std::span<const Item> items, std::size_t least, std::size_t most,
                                                 const Slices& slices) const
{
    struct Slice {
        Growing bounds;
        std::size_t count = 0;
    };
    std::array<Slice, Slices::few> slice;
    for (const Item& item : items) {
        Slice& s = slice[slices.of(item)];
        s.bounds.add(bounds_[item.number]), ++s.count;
    }
    std::array<float, Slices::few> areas_above;
    Growing above, below;
    for (std::size_t i = Slices::few; i-- > 0;) above.add(slice[i].bounds), areas_above[i] = above.area();
    Cut best{slices.axis, 0, infinite};
    std::size_t at = 0;
    for (std::uint32_t i = 0; i + 1 < Slices::few; ++i) {
        below.add(slice[i].bounds), at += slice[i].count;
        if (at < least || at > most) continue;
        const float cost = float(at) * below.area() + float(items.size() - at) * areas_above[i + 1];
        if (cost < best.cost) best = {slices.axis, at, cost, i + 1};
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
