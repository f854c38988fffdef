#include <oncollide/broadphase/box_tree.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <oncollide/broadphase/cpu_features.hpp>
#include <oncollide/scenes/error.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

constexpr std::uint32_t width = 16;
constexpr float far_away = std::numeric_limits<float>::infinity();

// One float step outward is at most 2^-23 of the magnitude, and a double rounds to float within half of that.
float below(double x)
{
    const float f = static_cast<float>(x);
    return f - std::abs(f) * 0x1p-23f - std::numeric_limits<float>::min();
}
float above(double x)
{
    return -below(-x);
}

std::uint32_t nodes_over(std::uint32_t count)
{
    return (count + width - 1) / width;
}

/// Boxes more than 4 times as large as the median have a run of places of their own, those 16 times as large another,
/// and so on.
int size_class(const Aabb& box, double median)
{
    const double ratio = (box.max - box.min).maxCoeff() / median;
    return ratio > 4 ? std::min(std::ilogb(ratio) / 2, 7) : 0;
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

} // namespace

const BoxTreeKernel& box_tree_kernel()
{
    static const BoxTreeKernel chosen = [] {
        switch (instruction_set()) {
        case InstructionSet::avx512:
            return avx512::box_tree_kernel();
        case InstructionSet::avx2:
            return avx2::box_tree_kernel();
        default:
            return baseline::box_tree_kernel();
        }
    }();
    return chosen;
}

void BoxTree::build(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads)
{
    Aabb all;
    for (std::uint32_t body : bodies) all.add(boxes[body]);
    origin_ = all.centre();
    if (!origin_.allFinite()) origin_.setZero();
    order_bodies(boxes, bodies, threads);
    make_levels();
    refit(boxes, margin, threads);
    built_extent_ = leaf_extent_;
}

/// Runs of bodies of one size class, the largest first, each in kd order and padded to whole nodes.
void BoxTree::order_bodies(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, int threads)
{
    order_.clear(), items_.clear();
    if (bodies.empty()) return;
    const double median = median_size(boxes, bodies);
    std::array<std::size_t, 8> counts{};
    for (std::uint32_t body : bodies) ++counts[static_cast<std::size_t>(size_class(boxes[body], median))];

    struct Run {
        std::size_t begin, end;
    };
    std::vector<Run> runs;
    std::array<std::size_t, 8> next{}; // by class
    std::size_t places = 0;
    for (int c = 7; c >= 0; --c) {
        const std::size_t count = counts[static_cast<std::size_t>(c)];
        next[static_cast<std::size_t>(c)] = places;
        if (count) runs.push_back({places, places + count});
        // Whole nodes two levels up where that costs little, so that the next run's nodes are its own.
        const std::size_t unit = count >= 8 * width * width ? width * width : width;
        places += c > 0 ? (count + unit - 1) / unit * unit : count;
    }
    items_.assign(places, {{0, 0, 0}, nobody});
    for (std::uint32_t body : bodies) {
        const Eigen::Vector3d centre = 0.5 * (boxes[body].min + boxes[body].max) - origin_;
        items_[next[static_cast<std::size_t>(size_class(boxes[body], median))]++] = {
            {static_cast<float>(centre.x()), static_cast<float>(centre.y()), static_cast<float>(centre.z())}, body};
    }
    // Halves are split off until there are enough runs to share among the threads.
    const std::size_t least = places / static_cast<std::size_t>(8 * std::max(threads, 1)) + width * width;
    for (std::size_t i = 0; threads > 1 && i < runs.size();) {
        const Run run = runs[i];
        if (run.end - run.begin <= least) {
            ++i;
            continue;
        }
        const std::size_t middle = split_once(run.begin, run.end);
        runs[i] = {run.begin, middle};
        runs.push_back({middle, run.end});
    }
    parallel_chunks(runs.size(), 1, threads, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t i = first; i < last; ++i) split(runs[i].begin, runs[i].end);
    });
    order_.resize(places);
    places_.resize(boxes.size());
    for (std::size_t i = 0; i < places; ++i) {
        order_[i] = items_[i].body;
        if (order_[i] != nobody) places_[order_[i]] = static_cast<std::uint32_t>(i);
    }
    items_ = {};
}

/// Puts the lower half of the run along its longest axis first. Halves are whole nodes of the largest level that fits.
std::size_t BoxTree::split_once(std::size_t begin, std::size_t end)
{
    float low[3] = {far_away, far_away, far_away}, high[3] = {-far_away, -far_away, -far_away};
    for (std::size_t i = begin; i < end; ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const float c = items_[i].centre[axis];
            low[axis] = c < low[axis] ? c : low[axis], high[axis] = c > high[axis] ? c : high[axis];
        }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    const std::size_t count = end - begin;
    std::size_t unit = width;
    while (unit * width < count) unit *= width;
    const std::size_t middle = begin + (count + 2 * unit - 1) / (2 * unit) * unit;
    const auto at = [&](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    // The body number breaks ties, so that the order does not depend on where a run was cut for threads.
    std::nth_element(at(begin), at(middle), at(end), [axis](const Item& x, const Item& y) {
        return x.centre[axis] < y.centre[axis] || (x.centre[axis] == y.centre[axis] && x.body < y.body);
    });
    return middle;
}

void BoxTree::split(std::size_t begin, std::size_t end)
{
    if (end - begin <= width) return;
    const std::size_t middle = split_once(begin, end);
    split(begin, middle);
    split(middle, end);
}

void BoxTree::make_levels()
{
    std::uint32_t count = size();
    std::size_t level = 0;
    for (bool top = false; !top; ++level) {
        top = count <= width;
        if (levels_.size() <= level) levels_.emplace_back();
        Level& l = levels_[level];
        l.count = count;
        const std::uint32_t nodes = std::max(nodes_over(count), 1u);
        l.blocks.resize(std::size_t{nodes} * box_block);
        for (std::size_t i = 0; i < l.blocks.size(); ++i)
            l.blocks[i] = i % box_block < box_block / 2 ? far_away : -far_away;
        l.moving.assign(nodes, 0xffff);
        count = nodes;
    }
    levels_.resize(level);
    view_.levels = static_cast<int>(level);
    for (std::size_t i = 0; i < level; ++i) {
        const Level& l = levels_[i];
        view_.level[i] = {l.blocks.data(), l.count, l.moving.data()};
    }
}

inline float& BoxTree::coordinate(Level& level, std::uint32_t place, std::size_t c)
{
    return level.blocks[std::size_t{place / width} * box_block + c * width + place % width];
}

/// Rounds boxes outward into level 0.
class BoxTree::Taker {
public:
    Taker(BoxTree& tree, std::span<const Aabb> boxes, double margin)
        : boxes_(boxes), half_margin_(0.5 * margin), origin_{tree.origin_[0], tree.origin_[1], tree.origin_[2]},
          blocks_(tree.levels_[0].blocks.data())
    {
    }
    void operator()(std::uint32_t place, std::uint32_t body) const
    {
        const Aabb& box = boxes_[body];
        float* p = blocks_ + std::size_t{place / width} * box_block + place % width;
        for (int axis = 0; axis < 3; ++axis, p += width) {
            p[0] = below(box.min[axis] - half_margin_ - origin_[axis]);
            p[3 * width] = above(box.max[axis] + half_margin_ - origin_[axis]);
        }
    }

private:
    std::span<const Aabb> boxes_;
    double half_margin_, origin_[3];
    float* blocks_;
};

/// The bounds of a node, from the level below it.
void BoxTree::bound(int level, std::uint32_t node)
{
    float box[6];
    box_tree_kernel().bound(view_.level[level - 1], node, box);
    for (std::size_t c = 0; c < 6; ++c) coordinate(levels_[static_cast<std::size_t>(level)], node, c) = box[c];
}

void BoxTree::refit(std::span<const Aabb> boxes, double margin, int threads)
{
    constexpr std::size_t grain = 1024; // nodes a chunk
    if (levels_.empty()) return;
    const Taker take(*this, boxes, margin);
    parallel_chunks(nodes_over(size()), grain, threads, [&](std::size_t first, std::size_t last, int) {
        const auto end = std::min(static_cast<std::uint32_t>(last * width), size());
        for (auto place = static_cast<std::uint32_t>(first * width); place < end; ++place) {
            constexpr std::uint32_t ahead = 16; // bodies lie in memory in another order
            if (place + ahead < end && order_[place + ahead] != nobody) {
                const auto* next = reinterpret_cast<const char*>(&boxes[order_[place + ahead]]);
                __builtin_prefetch(next), __builtin_prefetch(next + sizeof(Aabb) - 1);
            }
            if (order_[place] != nobody) take(place, order_[place]);
        }
        if (view_.levels > 1)
            for (auto node = static_cast<std::uint32_t>(first); node < last; ++node) bound(1, node);
    });
    for (int level = 2; level < view_.levels; ++level)
        for (std::uint32_t node = 0; node < view_.level[level].count; ++node) bound(level, node);
    leaf_extent_ = extent_of_leaves();
    farthest_ = 0;
    for (float x : levels_.back().blocks)
        if (std::isfinite(x)) farthest_ = std::max(farthest_, std::abs(x)); // infinite: padding
}

void BoxTree::refit_bodies(std::span<const Aabb> boxes, double margin, std::span<const std::uint32_t> bodies)
{
    const Taker take(*this, boxes, margin);
    constexpr std::size_t ahead = 8;
    for (std::size_t k = 0; k < bodies.size(); ++k) {
        if (k + ahead < bodies.size()) {
            const float* next = corner(places_[bodies[k + ahead]]);
            for (std::size_t c = 0; c < 6; ++c) __builtin_prefetch(next + c * width);
        }
        std::uint32_t place = places_[bodies[k]];
        take(place, bodies[k]);
        float box[6];
        box_at(place, box);
        for (float x : box) farthest_ = std::max(farthest_, std::abs(x));
        for (std::size_t level = 1; level < levels_.size(); ++level) {
            place /= width;
            bool wider = false;
            for (std::size_t c = 0; c < 3; ++c) {
                float &lo = coordinate(levels_[level], place, c), &hi = coordinate(levels_[level], place, 3 + c);
                const float by = std::max(lo - box[c], 0.0f) + std::max(box[3 + c] - hi, 0.0f);
                if (!(by > 0)) continue;
                lo = std::min(lo, box[c]), hi = std::max(hi, box[3 + c]);
                wider = true;
                if (level == 1) leaf_extent_ += by;
            }
            if (!wider) break;
        }
    }
}

double BoxTree::extent_of_leaves() const
{
    if (view_.levels < 2) return 0;
    double sum = 0;
    const Level& leaves = levels_[1];
    for (std::size_t i = 0; i < leaves.blocks.size(); i += box_block)
        for (std::size_t k = i; k < i + box_block / 2; ++k) {
            const float extent = leaves.blocks[k + box_block / 2] - leaves.blocks[k];
            if (extent > 0) sum += extent; // not of padding
        }
    return sum;
}

void BoxTree::set_moving(std::span<const std::uint8_t> is_static)
{
    for (std::size_t level = 0; level < levels_.size(); ++level) {
        Level& l = levels_[level];
        for (std::uint32_t node = 0; node < l.moving.size(); ++node) {
            unsigned mask = 0;
            for (std::uint32_t i = node * width; i < std::min((node + 1) * width, l.count); ++i) {
                const bool moves =
                    level == 0 ? order_[i] != nobody && !is_static[order_[i]] : levels_[level - 1].moving[i] != 0;
                mask |= unsigned(moves) << i % width;
            }
            l.moving[node] = static_cast<std::uint16_t>(mask);
        }
    }
}

std::size_t BoxTree::bytes() const
{
    std::size_t sum = (order_.capacity() + places_.capacity()) * sizeof(order_[0]) + items_.capacity() * sizeof(Item);
    for (const Level& l : levels_) {
        sum += l.blocks.capacity() * sizeof(float) + l.moving.capacity() * sizeof(l.moving[0]);
    }
    return sum;
}

} // namespace oncollide
