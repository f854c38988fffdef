#include <oncollide/narrowphase/obb/fits/triangle_parts.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/base/simd/prefetch.hpp>
#include <oncollide/narrowphase/obb/fits/box_fit.hpp>

namespace oncollide {

namespace {

/// Up to this many triangles are halved at their median, as a better cut costs more than it saves. Up to most_sorted
/// are sorted to try every cut. Above that, cuts between slices are tried.
constexpr std::size_t most_halved = 16;

using F32x4 = float __attribute__((vector_size(16)));
using I32x4 = std::int32_t __attribute__((vector_size(16)));
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

/// Bounds of the items added so far.
struct TriangleParts::Growing {
    Eigen::Array4f low{float_infinity, float_infinity, float_infinity, 0},
        high{-float_infinity, -float_infinity, -float_infinity, 0};

    void add(const auto& other) { low = low.min(other.low), high = high.max(other.high); }
    void add_point(const Eigen::Array4f& p) { low = low.min(p), high = high.max(p); }
    /// The fourth lane is then meaningless.
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
    if (bounds_.size() < size) bounds_.resize(size), corners_.resize(size), above_.resize(size);
    const F64x4 middle{centre.x(), centre.y(), centre.z(), 0};
    constexpr std::size_t ahead = 8; // triangles; a large mesh is in no cache
    for (std::size_t i = 0; i < size; ++i) {
        if (i + 2 * ahead < size) prefetch(&mesh.triangles[triangles[i + 2 * ahead]]);
        if (i + ahead < size)
            for (const std::uint32_t v : mesh.triangles[triangles[i + ahead]]) prefetch(&mesh.vertices[v]);
        Growing bounds;
        F64x4 sum{}; // a sum of floats in double: exact in any order of the corners
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

/// Splits items that begin at position `begin` into parts; the first of these is part `first`.
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
    std::array<bool, 3> worth; // cuts across shorter axes are not tried
    for (int axis = 0; axis < 3; ++axis) worth[std::size_t(axis)] = extent[axis] > 0.5f * extent[longest];
    Cut best{longest, half, float_infinity};
    if (size > most_sorted) {
        const Cut cut = best_of_slices(items, least, most, places, worth);
        if (cut.cost < best.cost) best = cut;
        const Slices slices{best.axis, places.low[best.axis], places.high[best.axis]};
        if (best.slice > 0)
            part(items, [&](const Item& item) { return slices.of(item) < best.slice; });
        else
            halve(items, best.at, slices);
    } else {
        Order order, best_order;
        for (int axis = 0; size > most_halved && axis < 3; ++axis) {
            if (!worth[std::size_t(axis)]) continue;
            sort(items, axis, order);
            const Cut cut = best_of_few(items, least, most, axis, order);
            if (cut.cost < best.cost) best = cut, best_order = order;
        }
        if (best.cost == float_infinity) sort(items, longest, best_order);
        arrange(items, best_order);
    }
    split(items.first(best.at), low_parts, begin, first);
    split(items.subspan(best.at), high_parts, begin + best.at, first + low_parts);
}

/// Order along the axis.
inline bool TriangleParts::before(const Item& x, const Item& y, int axis) const
{
    const auto a = static_cast<std::size_t>(axis);
    return x.place[a] != y.place[a] ? x.place[a] < y.place[a] : before_in_a_tie(x, y, axis);
}

/// Orders triangles with the same centre by their corners, so that the parts do not depend on the order in the file.
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

/// Moves items for which `first` is true before the others, without unpredictable branches.
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

/// Partially sorts, so that the first `half` items come before() the others. If there are many items, most are
/// separated by counting the items in each slice.
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

/// Writes the order of the items along the axis. Compares each item with all others, because a sort would mispredict
/// its branches.
void TriangleParts::sort(std::span<const Item> items, int axis, Order& order) const
{
    const std::size_t size = items.size();
    alignas(32) float along[most_sorted] = {};
    std::int32_t less[most_sorted];
    for (std::size_t i = 0; i < size; ++i) along[i] = items[i].place[static_cast<std::size_t>(axis)];
    for (std::size_t i = size; i % 8; ++i) along[i] = float_infinity;
    box_fit_kernel().count_less(along, size, less);
    std::array<std::uint8_t, most_sorted> alike{};
    bool tie = false;
    for (std::size_t i = 0; i < size; ++i) {
        const auto place = static_cast<std::size_t>(less[i]);
        tie |= alike[place] > 0;
        order[place + alike[place]++] = static_cast<std::uint8_t>(i);
    }
    for (std::size_t i = 0; tie && i < size; i += alike[i])
        std::sort(&order[i], &order[i] + alike[i],
                  [&](std::uint8_t x, std::uint8_t y) { return before_in_a_tie(items[x], items[y], axis); });
}

void TriangleParts::arrange(std::span<Item> items, const Order& order)
{
    for (std::size_t i = 0; i < items.size(); ++i) above_[i] = items[order[i]];
    std::copy_n(above_.begin(), items.size(), items.begin());
}

/// The best cut along the axis, by trying each cut that leaves `least` to `most` items on the first side.
TriangleParts::Cut TriangleParts::best_of_few(std::span<const Item> items, std::size_t least, std::size_t most,
                                              int axis, const Order& order) const
{
    const auto box = [&](std::size_t i) -> const Bounds& { return bounds_[items[order[i]].number]; };
    Growing below, above;
    for (std::size_t i = 0; i < least; ++i) below.add(box(i));
    for (std::size_t i = most; i < items.size(); ++i) above.add(box(i));
    std::array<float, most_sorted / 5 + 2> areas_above; // areas around the items from `least` + i on
    for (std::size_t i = most - least + 1; i-- > 0;) {
        areas_above[i] = above.area();
        if (i > 0) above.add(box(least + i - 1));
    }
    Cut best{axis, least, float_infinity};
    for (std::size_t at = least; at <= most; ++at) {
        const float cost = float(at) * below.area() + float(items.size() - at) * areas_above[at - least];
        if (cost < best.cost) best = {axis, at, cost};
        if (at < most) below.add(box(at));
    }
    return best;
}

/// The best cut of many items along several axes, between slices.
TriangleParts::Cut TriangleParts::best_of_slices(std::span<const Item> items, std::size_t least, std::size_t most,
                                                 const Growing& places, const std::array<bool, 3>& axes) const
{
    constexpr std::uint32_t few = Slices::few;
    std::array<std::array<Bounds, few>, 3> bounds; // by axis and slice, as is the next array
    std::array<std::array<std::uint32_t, few>, 3> counts;
    const Growing nothing;
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (axes[axis]) bounds[axis].fill({nothing.low, nothing.high}), counts[axis].fill(0);
    Eigen::Array4f scale = float(few) / places.extent(); // as in Slices::of()
    scale[3] = 0;
    for (const Item& item : items) {
        const I32x4 place = std::bit_cast<I32x4>(item) & I32x4{-1, -1, -1, 0}; // clears the number
        const Eigen::Array4f along = ((four(place) - places.low) * scale).min(float(few - 1));
        F32x4 steps;
        std::memcpy(&steps, along.data(), sizeof steps);
        const I32x4 slice = __builtin_convertvector(steps, I32x4);
        const Bounds& added = bounds_[item.number];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!axes[axis]) continue;
            const std::size_t k = static_cast<std::uint32_t>(slice[axis]) % few; // 0 / 0 (extent below 2^-120 m) is no
                                                                                 // slice
            Bounds& all = bounds[axis][k];
            all = {all.low.min(added.low), all.high.max(added.high)};
            ++counts[axis][k];
        }
    }
    Cut best{0, 0, float_infinity};
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (axes[axis]) try_slices(bounds[axis], counts[axis], static_cast<int>(axis), items.size(), least, most, best);
    return best;
}

/// Replaces the best cut so far by a cut between slices of one axis that is better.
void TriangleParts::try_slices(std::span<const Bounds> bounds, std::span<const std::uint32_t> counts, int axis,
                               std::size_t size, std::size_t least, std::size_t most, Cut& best)
{
    std::size_t first = 0, at = counts[0], number = 0; // slices below the first cut that leaves `least` items, and
                                                       // their items
    while (at < least) at += counts[++first];
    for (std::size_t to = at; to <= most && first + number + 1 < counts.size(); ++number)
        to += counts[first + number + 1];
    if (number == 0) return;
    std::array<float, Slices::few> areas_above;
    Growing above, below;
    for (std::size_t i = counts.size(); i-- > first + 1;) {
        above.add(bounds[i]);
        if (i <= first + number) areas_above[i] = above.area();
    }
    for (std::size_t i = 0; i < first; ++i) below.add(bounds[i]);
    for (std::size_t i = first; i < first + number; at += counts[++i]) {
        below.add(bounds[i]);
        const float cost = float(at) * below.area() + float(size - at) * areas_above[i + 1];
        if (cost < best.cost) best = {axis, at, cost, static_cast<std::uint32_t>(i + 1)};
    }
}

Aabb TriangleParts::bounds(std::size_t from, std::size_t to) const
{
    Growing all;
    for (std::size_t i = from; i < to; ++i) all.add(bounds_[items_[i].number]);
    return {all.low.head<3>().matrix().cast<double>(), all.high.head<3>().matrix().cast<double>()};
}

} // namespace oncollide
