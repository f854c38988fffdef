#include <oncollide/broadphase/tree/aabb_order.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <oncollide/base/error.hpp>
#include <oncollide/base/threads/parallel.hpp>

namespace oncollide {

namespace {

struct Item {
    float centre[3];
    std::uint32_t body;
};

/// Class 0 holds boxes up to 4 times the median size; class 1 up to 16 times, and so on by factors of 4. Each class
/// gets its own run of slots.
constexpr std::size_t size_classes = 8;
std::size_t size_class(const Aabb& box, double median)
{
    const double ratio = (box.max - box.min).maxCoeff() / median;
    return ratio > 4 ? std::min<std::size_t>(static_cast<std::size_t>(std::ilogb(ratio)) / 2, size_classes - 1) : 0;
}

double median_size(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies)
{
    std::vector<double> sample;
    const std::size_t step = std::max<std::size_t>(1, bodies.size() / 1024);
    for (std::size_t i = 0; i < bodies.size(); i += step)
        sample.push_back((boxes[bodies[i]].max - boxes[bodies[i]].min).maxCoeff());
    const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
    std::nth_element(sample.begin(), middle, sample.end());
    return std::max(*middle, std::numeric_limits<double>::min());
}

struct Extent {
    float low[3], high[3];

    explicit Extent(std::span<const Item> items)
    {
        for (int axis = 0; axis < 3; ++axis)
            low[axis] = std::numeric_limits<float>::infinity(), high[axis] = -low[axis];
        for (const Item& item : items)
            for (int axis = 0; axis < 3; ++axis) {
                const float c = item.centre[axis];
                low[axis] = c < low[axis] ? c : low[axis], high[axis] = c > high[axis] ? c : high[axis];
            }
    }
    float along(int axis) const { return high[axis] - low[axis]; }
    int longest_axis() const
    {
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (along(k) > along(axis)) axis = k;
        return axis;
    }
};

/// Moves the lower half along the longest axis to the front. Halves are whole nodes of the largest level that fits.
std::size_t split_once(std::span<Item> items)
{
    const int axis = Extent(items).longest_axis();
    std::size_t unit = node_width;
    while (unit * node_width < items.size()) unit *= node_width;
    const std::size_t middle = (items.size() + 2 * unit - 1) / (2 * unit) * unit;
    // The body number breaks ties, so that the order does not depend on where a run was cut for threads.
    std::nth_element(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(middle), items.end(),
                     [axis](const Item& x, const Item& y) {
                         return x.centre[axis] < y.centre[axis] ||
                                (x.centre[axis] == y.centre[axis] && x.body < y.body);
                     });
    ONCOLLIDE_ASSERT(middle > 0 && middle < items.size());
    return middle;
}

void split(std::span<Item> items)
{
    if (items.size() <= node_width) return;
    const std::size_t middle = split_once(items);
    split(items.first(middle));
    split(items.subspan(middle));
}

void order_kd(std::vector<std::span<Item>> runs, int threads)
{
    std::size_t count = 0;
    for (std::span<Item> run : runs) count += run.size();
    // Split until there are enough runs to share among the threads.
    const std::size_t least = count / static_cast<std::size_t>(8 * std::max(threads, 1)) + node_width * node_width;
    for (std::size_t i = 0; threads > 1 && i < runs.size(); ++i)
        while (runs[i].size() > least) {
            const std::size_t middle = split_once(runs[i]);
            runs.push_back(runs[i].subspan(middle));
            runs[i] = runs[i].first(middle);
        }
    parallel_chunks(runs.size(), 1, threads, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t i = first; i < last; ++i) split(runs[i]);
    });
}

/// Spreads the low 16 bits to every third bit.
std::uint64_t spread(std::uint64_t x)
{
    x = (x | x << 32) & 0x001f00000000ffff;
    x = (x | x << 16) & 0x001f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
}

struct SortItem {
    std::uint64_t key;
    Item item;
};

/// Stable sort by 48 bits of the key, 12 bits at a time.
void radix_sort(std::vector<SortItem>& items, std::vector<SortItem>& scratch, int threads)
{
    constexpr std::size_t digits = 4096, most_shares = 16;
    const std::size_t shares = std::clamp<std::size_t>(static_cast<std::size_t>(threads), 1, most_shares);
    std::vector<std::array<std::uint32_t, digits>> next(shares);
    scratch.resize(items.size());
    for (int shift = 0; shift < 48; shift += 12) {
        const auto digit = [&](const SortItem& k) { return k.key >> shift & (digits - 1); };
        const auto share_of = [&](std::size_t s) {
            const std::size_t begin = items.size() * s / shares, end = items.size() * (s + 1) / shares;
            return std::span<const SortItem>(items).subspan(begin, end - begin);
        };
        parallel_chunks(shares, 1, threads, [&](std::size_t first, std::size_t last, int) {
            for (std::size_t s = first; s < last; ++s) {
                next[s].fill(0);
                for (const SortItem& k : share_of(s)) ++next[s][digit(k)];
            }
        });
        std::uint32_t sum = 0;
        for (std::size_t d = 0; d < digits; ++d)
            for (std::size_t s = 0; s < shares; ++s) sum += std::exchange(next[s][d], sum);
        parallel_chunks(shares, 1, threads, [&](std::size_t first, std::size_t last, int) {
            for (std::size_t s = first; s < last; ++s)
                for (const SortItem& k : share_of(s)) scratch[next[s][digit(k)]++] = k;
        });
        items.swap(scratch);
    }
    ONCOLLIDE_ASSERT(std::ranges::is_sorted(items, {}, &SortItem::key));
}

void order_octree(const std::vector<std::span<Item>>& runs, int threads)
{
    std::vector<SortItem> keyed, scratch;
    for (std::span<Item> run : runs) {
        const Extent extent(run);
        const float size = extent.along(extent.longest_axis());
        const double scale = size > 0 && std::isfinite(size) ? 65535.0 / size : 0;
        keyed.clear();
        for (const Item& item : run) {
            std::uint64_t key = 0;
            for (int axis = 0; axis < 3; ++axis) {
                const double cell = scale * (double(item.centre[axis]) - extent.low[axis]);
                key |= spread(static_cast<std::uint64_t>(cell)) << axis;
            }
            keyed.push_back({key, item});
        }
        if (run.size() < 4096)
            std::stable_sort(keyed.begin(), keyed.end(),
                             [](const SortItem& a, const SortItem& b) { return a.key < b.key; });
        else
            radix_sort(keyed, scratch, threads);
        for (std::size_t i = 0; i < run.size(); ++i) run[i] = keyed[i].item;
    }
}

} // namespace

void append_in_order(AabbOrder kind, std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies,
                     const Eigen::Vector3d& origin, int threads, LargeVector<std::uint32_t>& order)
{
    ONCOLLIDE_ASSERT(order.size() % node_width == 0);
    ONCOLLIDE_ASSERT(threads >= 1);
    ONCOLLIDE_ASSERT(origin.allFinite());
    ONCOLLIDE_ASSERT(
        std::ranges::all_of(bodies, [&](std::uint32_t body) { return body < boxes.size() && !boxes[body].empty(); }));
    if (bodies.empty()) return;
    const double median = median_size(boxes, bodies);
    std::array<std::size_t, size_classes> counts{}, next{}; // by class
    for (std::uint32_t body : bodies) ++counts[size_class(boxes[body], median)];
    std::size_t places = 0;
    std::vector<std::pair<std::size_t, std::size_t>> begins; // first slot and length of each run
    for (std::size_t c = size_classes; c-- > 0;) {
        next[c] = places;
        if (counts[c]) begins.push_back({places, counts[c]});
        // Pad to whole nodes two levels up if that costs little, so that no node holds boxes of two runs.
        const std::size_t unit = counts[c] >= 8 * node_width * node_width ? node_width * node_width : node_width;
        places += c > 0 ? (counts[c] + unit - 1) / unit * unit : counts[c];
    }
    LargeVector<Item> items(places, {{0, 0, 0}, no_body});
    for (std::uint32_t body : bodies) {
        const Eigen::Vector3d centre = 0.5 * (boxes[body].min + boxes[body].max) - origin;
        items[next[size_class(boxes[body], median)]++] = {
            {static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z())}, body};
    }
    std::vector<std::span<Item>> runs;
    for (const auto& [begin, count] : begins) runs.push_back(std::span(items).subspan(begin, count));
    if (kind == AabbOrder::kd)
        order_kd(std::move(runs), threads);
    else
        order_octree(runs, threads);
    ONCOLLIDE_ASSERT(std::ranges::count_if(items, [](const Item& item) { return item.body != no_body; }) ==
                     std::ssize(bodies));
    reserve_ahead(order, order.size() + places);
    for (const Item& item : items) order.push_back(item.body);
}

} // namespace oncollide
