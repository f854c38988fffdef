#include <oncollide/broadphase/tree/aabb_tree.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include <oncollide/base/error.hpp>
#include <oncollide/base/numbers/outward.hpp>
#include <oncollide/base/simd/cpu_features.hpp>
#include <oncollide/base/threads/parallel.hpp>
#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/segment_part.hpp>

namespace oncollide {

namespace {

constexpr float far_away = std::numeric_limits<float>::infinity();

std::uint32_t nodes_over(std::uint32_t count)
{
    return (count + node_width - 1) / node_width;
}

} // namespace

const AabbTreeKernel& aabb_tree_kernel()
{
    static const AabbTreeKernel kernel = ONCOLLIDE_CHOOSE(aabb_tree_kernel);
    return kernel;
}

/// Writes boxes to level 0, rounded outward.
class AabbTree::Taker {
public:
    Taker(AabbTree& tree, double margin)
        : half_margin_(0.5 * margin), origin_{tree.origin_[0], tree.origin_[1], tree.origin_[2]},
          blocks_(tree.levels_[0].blocks.data())
    {
    }
    /// Returns false for a box that is not usable.
    bool operator()(std::uint32_t place, const Aabb& box) const
    {
        if (!usable(box)) return false;
        float* p = blocks_ + std::size_t{place / node_width} * aabb_block + place % node_width;
        for (int axis = 0; axis < 3; ++axis, p += node_width) {
            p[0] = below(box.min[axis] - half_margin_ - origin_[axis]);
            p[3 * node_width] = above(box.max[axis] + half_margin_ - origin_[axis]);
        }
        return true;
    }

private:
    double half_margin_, origin_[3];
    float* blocks_;
};

void AabbTree::build(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads)
{
    ONCOLLIDE_ASSERT(margin >= 0 && threads >= 1);
    refuse_unusable(boxes, bodies);
    Aabb all;
    for (std::uint32_t body : bodies) all.add(boxes[body]);
    origin_ = bodies.empty() ? Eigen::Vector3d::Zero().eval() : all.centre();
    order_.clear();
    append_in_order(kind_, boxes, bodies, origin_, threads, order_);
    order_.shrink_to_fit();
    bodies_ = static_cast<std::uint32_t>(bodies.size());
    places_.resize(boxes.size());
    for (Level& level : levels_) level.blocks.clear(), level.moving.clear(), level.nodes.clear(), level.count = 0;
    forget_filters();
    extend_levels();
    refit(boxes, margin, threads);
    built_extent_ = leaf_extent_;
}

bool AabbTree::append(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads)
{
    ONCOLLIDE_ASSERT(margin >= 0 && threads >= 1);
    ONCOLLIDE_ASSERT(!bodies.empty());
    if (order_.empty()) return build(boxes, bodies, margin, threads), true;
    const std::uint32_t first = nodes_over(size()) * node_width;
    order_.resize(first, no_body);
    append_in_order(kind_, boxes, bodies, origin_, threads, order_);
    bodies_ += static_cast<std::uint32_t>(bodies.size());
    std::uint32_t nodes = size();
    int levels = 1;
    for (; nodes > node_width; ++levels) nodes = nodes_over(nodes);
    if (levels > view_.levels) { // bounds and layers of the nodes on the new level are not known
        std::vector<std::uint32_t> all(order_.begin(), order_.end());
        std::erase(all, no_body);
        return build(boxes, all, margin, threads), true;
    }
    places_.resize(std::max(places_.size(), boxes.size()));
    extend_levels();
    const Taker take(*this, margin);
    for (std::uint32_t place = first; place < size(); ++place)
        if (order_[place] != no_body) take(place, boxes[order_[place]]);
    bound_from(first);
    const double before = leaf_extent_;
    measure();
    built_extent_ += leaf_extent_ - before;
    return false;
}

bool AabbTree::reinsert(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, double margin, int threads)
{
    const double built = built_extent_;
    erase(bodies);
    if (append(boxes, bodies, margin, threads)) return true;
    built_extent_ = built;
    return false;
}

void AabbTree::erase(std::span<const std::uint32_t> bodies)
{
    ONCOLLIDE_ASSERT(bodies.size() <= bodies_);
    bodies_ -= static_cast<std::uint32_t>(bodies.size());
    for (std::uint32_t body : bodies) {
        ONCOLLIDE_ASSERT(body < places_.size() && place_of(body) < size() && body_at(place_of(body)) == body);
        std::uint32_t place = places_[body];
        for (std::size_t c = 0; c < 6; ++c) coordinate(levels_[0], place, c) = c < 3 ? far_away : -far_away;
        order_[place] = no_body;
        for (std::size_t level = 1; level < levels_.size(); ++level) --levels_[level].nodes[place /= node_width].bodies;
    }
}

/// Extends the levels to the size of `order_`; new nodes are empty and marked as moving.
void AabbTree::extend_levels()
{
    const std::uint32_t old = levels_.empty() ? 0 : levels_[0].count;
    for (std::uint32_t place = old; place < size(); ++place)
        if (order_[place] != no_body) places_[order_[place]] = place;
    std::uint32_t count = size();
    std::size_t level = 0;
    for (bool top = false; !top; ++level) {
        top = count <= node_width;
        if (levels_.size() <= level) levels_.emplace_back();
        Level& l = levels_[level];
        l.count = count;
        const std::uint32_t nodes = std::max(nodes_over(count), 1u);
        reserve_ahead(l.blocks, std::size_t{nodes} * aabb_block);
        while (l.blocks.size() < std::size_t{nodes} * aabb_block) {
            l.blocks.insert(l.blocks.end(), aabb_block / 2, far_away);
            l.blocks.insert(l.blocks.end(), aabb_block / 2, -far_away);
        }
        l.moving.resize(nodes, 0xffff);
        if (level > 0) {
            const Level& below = levels_[level - 1];
            l.nodes.resize(count);
            for (std::uint32_t node = level == 1 ? old / node_width : 0; node < count; ++node) {
                l.nodes[node].bodies = 0;
                for (std::uint32_t i = node * node_width; i < std::min((node + 1) * node_width, below.count); ++i)
                    l.nodes[node].bodies += level == 1 ? order_[i] != no_body : below.nodes[i].bodies;
            }
        }
        count = nodes;
    }
    levels_.resize(level);
    view_.levels = static_cast<int>(level);
    if (filters_.any()) extend_filters();
    for (std::size_t i = 0; i < level; ++i) {
        const Level& l = levels_[i];
        const auto known = [&](bool which, const std::vector<std::uint32_t>& column) {
            return which && i > 0 ? column.data() : nullptr;
        };
        view_.level[i] = {l.blocks.data(),
                          l.count,
                          l.moving.data(),
                          known(filters_.layers, l.layers),
                          known(filters_.layers, l.masks),
                          known(filters_.groups, l.groups)};
    }
}

inline float& AabbTree::coordinate(Level& level, std::uint32_t place, std::size_t c)
{
    return level.blocks[std::size_t{place / node_width} * aabb_block + c * node_width + place % node_width];
}

/// Recomputes the bounds of a node from the level below it.
void AabbTree::bound(int level, std::uint32_t node)
{
    ONCOLLIDE_ASSERT(level >= 1 && level < view_.levels && node < view_.level[level].count);
    float box[6];
    aabb_tree_kernel().bound(view_.level[level - 1], node, box);
    for (std::size_t c = 0; c < 6; ++c) coordinate(levels_[static_cast<std::size_t>(level)], node, c) = box[c];
}

void AabbTree::refit(std::span<const Aabb> boxes, double margin, int threads)
{
    ONCOLLIDE_ASSERT(margin >= 0 && threads >= 1);
    ONCOLLIDE_ASSERT(boxes.size() >= places_.size() || bodies_ == 0);
    constexpr std::size_t grain = 1024; // nodes per chunk
    if (levels_.empty()) return;
    const Taker take(*this, margin);
    std::atomic<bool> refused = false;
    parallel_chunks(nodes_over(size()), grain, threads, [&](std::size_t first, std::size_t last, int) {
        const auto end = std::min(static_cast<std::uint32_t>(last * node_width), size());
        for (auto place = static_cast<std::uint32_t>(first * node_width); place < end; ++place) {
            constexpr std::uint32_t ahead = 16; // bodies have another order in memory
            if (place + ahead < end && order_[place + ahead] != no_body) {
                const auto* next = reinterpret_cast<const char*>(&boxes[order_[place + ahead]]);
                __builtin_prefetch(next), __builtin_prefetch(next + sizeof(Aabb) - 1);
            }
            if (order_[place] != no_body && !take(place, boxes[order_[place]])) refused = true;
        }
        if (view_.levels > 1)
            for (auto node = static_cast<std::uint32_t>(first); node < last; ++node) bound(1, node);
    });
    if (refused) {
        std::vector<std::uint32_t> bodies(order_.begin(), order_.end());
        std::erase(bodies, no_body);
        std::sort(bodies.begin(), bodies.end());
        refuse_unusable(boxes, bodies);
    }
    for (int level = 2; level < view_.levels; ++level)
        for (std::uint32_t node = 0; node < view_.level[level].count; ++node) bound(level, node);
    measure();
}

/// Recomputes the bounds of all nodes above slots >= `place`.
void AabbTree::bound_from(std::uint32_t place)
{
    for (int level = 1; level < view_.levels; ++level) {
        place /= node_width;
        for (std::uint32_t node = place; node < view_.level[level].count; ++node) bound(level, node);
    }
}

/// Recomputes the extent of the leaves, the largest coordinate and the volumes.
void AabbTree::measure()
{
    leaf_extent_ = extent_of_leaves();
    farthest_ = 0;
    for (float x : levels_.back().blocks)
        if (std::isfinite(x)) farthest_ = std::max(farthest_, std::abs(x)); // infinite: padding
    for (int level = 1; level < view_.levels; ++level) {
        Level& l = levels_[static_cast<std::size_t>(level)];
        l.volume = 0;
        for (std::uint32_t node = 0; node < l.count; ++node) l.volume += l.nodes[node].volume = volume_of(level, node);
    }
}

float AabbTree::volume_of(int level, std::uint32_t node) const
{
    const float* p = at(level).blocks.data() + std::size_t{node / node_width} * aabb_block + node % node_width;
    double product = 1;
    for (int axis = 0; axis < 3; ++axis, p += node_width) product *= std::max(0.0, double(p[3 * node_width]) - p[0]);
    return static_cast<float>(product);
}

Aabb AabbTree::bounds(int level, std::uint32_t node) const
{
    ONCOLLIDE_ASSERT(level >= 1 && level < view_.levels && node < view_.level[level].count);
    const float* p = at(level).blocks.data() + std::size_t{node / node_width} * aabb_block + node % node_width;
    const auto corner = [&](const float* at_low) {
        return Eigen::Vector3d(at_low[0], at_low[node_width], at_low[2 * node_width]);
    };
    return {corner(p) + origin_, corner(p + 3 * node_width) + origin_};
}

void AabbTree::round(const Aabb& box, double margin, float out[6]) const
{
    ONCOLLIDE_ASSERT(margin >= 0 && !box.empty());
    for (int axis = 0; axis < 3; ++axis) {
        out[axis] = below(box.min[axis] - 0.5 * margin - origin_[axis]);
        out[3 + axis] = above(box.max[axis] + 0.5 * margin - origin_[axis]);
    }
}

bool AabbTree::outside_leaf(std::uint32_t body, const Aabb& box, double margin) const
{
    if (view_.levels < 2) return false;
    float b[6];
    round(box, margin, b);
    const std::uint32_t leaf = place_of(body) / node_width;
    const float* p = at(1).blocks.data() + std::size_t{leaf / node_width} * aabb_block + leaf % node_width;
    for (std::size_t c = 0; c < 3; ++c, p += node_width)
        if (b[3 + c] < p[0] || p[3 * node_width] < b[c]) return true;
    return false;
}

bool AabbTree::find_line(const Segment& segment, double margin, SegmentLine& line) const
{
    const Eigen::Vector3d farthest = Eigen::Vector3d::Constant(farthest_ + margin);
    std::optional<SegmentPart> part = part_in(segment, {origin_ - farthest, origin_ + farthest});
    if (!part) return false;
    part->error += margin; // widens the boxes
    line = line_of(*part, origin_, (part->middle - origin_).norm() + part->half.norm());
    return true;
}

void AabbTree::refit_bodies(std::span<const std::uint32_t> bodies, FunctionRef<Aabb(std::uint32_t body)> box_of,
                            double margin)
{
    const Taker take(*this, margin);
    constexpr std::size_t ahead = 4; // bodies are scattered in memory
    for (std::size_t k = 0; k < bodies.size(); ++k) {
        if (k + 4 * ahead < bodies.size()) prefetch_place_of(bodies[k + 4 * ahead]);
        if (k + ahead < bodies.size()) {
            std::uint32_t next = places_[bodies[k + ahead]];
            for (int level = 0; level < std::min(view_.levels, 2); ++level, next /= node_width)
                for (std::size_t c = 0; c < 6; ++c)
                    __builtin_prefetch(&coordinate(levels_[static_cast<std::size_t>(level)], next, c));
        }
        ONCOLLIDE_ASSERT(bodies[k] < places_.size() && body_at(place_of(bodies[k])) == bodies[k]);
        std::uint32_t place = places_[bodies[k]];
        [[maybe_unused]] const bool taken = take(place, box_of(bodies[k]));
        ONCOLLIDE_ASSERT(taken);
        float box[6];
        box_at(place, box);
        for (float x : box) farthest_ = std::max(farthest_, std::abs(x));
        for (std::size_t level = 1; level < levels_.size(); ++level) {
            place /= node_width;
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

double AabbTree::extent_of_leaves() const
{
    if (view_.levels < 2) return 0;
    double sum = 0;
    const Level& leaves = levels_[1];
    for (std::size_t i = 0; i < leaves.blocks.size(); i += aabb_block)
        for (std::size_t k = i; k < i + aabb_block / 2; ++k) {
            const float extent = leaves.blocks[k + aabb_block / 2] - leaves.blocks[k];
            if (extent > 0) sum += extent; // skip padding
        }
    return sum;
}

std::size_t AabbTree::bytes() const
{
    std::size_t sum = (order_.capacity() + places_.capacity()) * sizeof(order_[0]);
    for (const Level& l : levels_)
        sum += l.blocks.capacity() * sizeof(float) + l.moving.capacity() * sizeof(l.moving[0]) +
               l.nodes.capacity() * sizeof(Node) +
               (l.layers.capacity() + l.masks.capacity() + l.groups.capacity()) * sizeof(std::uint32_t);
    return sum;
}

} // namespace oncollide
