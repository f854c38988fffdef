#include <oncollide/broadphase/tree/delimitation.hpp>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include <oncollide/base/error.hpp>

namespace oncollide {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t queries_worth_threads = 4096;

double ms_since(Clock::time_point from)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

} // namespace

void Delimitation::clear()
{
    boxes_.clear(), filters_.clear(), levels_.clear();
    for (const auto& list : reached_) list->clear();
    for (const auto& list : next_) list->clear();
    bodies_left_ = 0;
    in_a_heap_ = false;
    counted_ = true;
}

void Delimitation::add(const float box[6], const Filter& filter)
{
    ONCOLLIDE_ASSERT(box[0] <= box[3] && box[1] <= box[4] && box[2] <= box[5]);
    boxes_.insert(boxes_.end(), box, box + 6);
    filters_.push_back(filter);
}

template <class Work>
void Delimitation::each_worker(int threads, Work work) const
{
    parallel_chunks(workers_, 1, threads, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t w = first; w < last; ++w) work(w);
    });
}

/// Expands the nodes of `from`, on the level above, to the nodes of `level` that the queries overlap. `room` is the
/// number of pairs that all workers together may still find; they stop once it is negative.
void Delimitation::descend(const AabbLevelView& level, bool filters, const NodePairs& from, NodePairs& to,
                           std::atomic<std::int64_t>& room) const
{
    constexpr std::size_t slice = 4096; // finds at most 16 times as many pairs before they are counted
    to.clear();
    for (std::size_t k = 0; k < from.size() && room >= 0; k += slice) {
        const std::size_t before = to.size();
        aabb_tree_kernel().in_blocks(level, from.i() + k, from.j() + k, std::min(slice, from.size() - k), boxes_.data(),
                                     to.sink());
        if (filters && (level.layers || level.groups)) drop_forbidden(level, to.sink(), before);
        room -= static_cast<std::int64_t>(to.size() - before);
    }
}

void Delimitation::drop_forbidden(const AabbLevelView& level, PairSink& found, std::uint64_t first) const
{
    std::uint64_t kept = first;
    for (std::uint64_t k = first; k < found.count; ++k) {
        const std::uint32_t query = found.i[k], node = found.j[k];
        ONCOLLIDE_ASSERT(query < queries() && node < level.count);
        found.i[kept] = query, found.j[kept] = node;
        const Filter& mine = filters_[query];
        const bool layers = !level.layers || ((mine.layers & level.masks[node]) && (level.layers[node] & mine.mask));
        const bool groups = !level.groups || mine.group != level.groups[node] || mine.group == mixed_groups;
        kept += layers && groups;
    }
    found.count = kept;
}

void Delimitation::run(const AabbTree& tree, bool filters, int threads)
{
    ONCOLLIDE_ASSERT(threads >= 1 && boxes_.size() == 6 * queries());
    workers_ = queries() < queries_worth_threads ? 1 : static_cast<std::size_t>(threads);
    while (reached_.size() < workers_)
        reached_.push_back(std::make_unique<NodePairs>()), next_.push_back(std::make_unique<NodePairs>());
    const int top = tree.view().levels - 1;
    levels_.assign(static_cast<std::size_t>(std::max(top, 0)) + 1, {});
    in_a_heap_ = false;
    if (tree.empty()) return;
    counted_ = false;
    if (queries() == 0) return;

    each_worker(threads, [&](std::size_t w) { reached_[w]->assign_root(first_query(w), first_query(w + 1)); });
    for (int level = top; level > 0 && !in_a_heap_; --level) {
        const auto from = Clock::now();
        std::atomic<std::int64_t> room = 4 * std::int64_t{tree.size()} + 65536;
        each_worker(threads,
                    [&](std::size_t w) { descend(tree.view().level[level], filters, *reached_[w], *next_[w], room); });
        reached_.swap(next_);
        in_a_heap_ = room < 0; // independent of the number of workers
        levels_[static_cast<std::size_t>(top - level) + 1].ms = ms_since(from);
    }
    counted_ = in_a_heap_;
    if (in_a_heap_) levels_.clear();
}

void Delimitation::compare(const AabbTree& tree, int threads, Found found) const
{
    ONCOLLIDE_ASSERT(threads >= 1 && workers_ <= reached_.size());
    if (tree.empty() || queries() == 0) return;
    each_worker(threads, [&](std::size_t w) {
        const auto take = [&](const std::uint32_t* queries, const std::uint32_t* places, std::size_t count) {
            found(w, queries, places, count);
        };
        find_in_chunks(take, [&](PairSink& sink) {
            if (in_a_heap_) {
                for (std::size_t k = first_query(w); k < first_query(w + 1); ++k)
                    aabb_tree_kernel().below_root(tree.view(), static_cast<std::uint32_t>(k), box(k), sink);
            } else {
                aabb_tree_kernel().in_blocks(tree.view().level[0], reached_[w]->i(), reached_[w]->j(),
                                             reached_[w]->size(), boxes_.data(), sink);
            }
        });
    });
}

void Delimitation::count(const AabbTree& tree)
{
    if (counted_) return;
    const auto from = Clock::now();
    mark(tree);
    count_rejected(tree);
    levels_[0].ms += ms_since(from);
    counted_ = true;
}

std::span<const DelimitationLevel> Delimitation::levels(const AabbTree& tree)
{
    count(tree);
    return levels_;
}

std::vector<DelimitedRegion> Delimitation::regions(const AabbTree& tree)
{
    count(tree);
    std::vector<DelimitedRegion> regions;
    if (levels_.empty() || tree.empty()) return regions;
    const int top = tree.view().levels;
    const auto at = [](int level) { return static_cast<std::size_t>(level); };
    Aabb all;
    for (std::uint32_t node = 0; top > 1 && node < tree.view().level[top - 1].count; ++node)
        if (const Aabb box = tree.bounds(top - 1, node); !box.empty()) all.add(box);
    if (!all.empty()) regions.push_back({all, 0, left_[at(top)].empty()});
    for (int level = top - 1; level > 0; --level) {
        const std::uint32_t nodes = tree.view().level[level].count;
        for (std::uint32_t parent : left_[at(level + 1)])
            for (std::uint32_t node = parent * node_width; node < std::min(nodes, (parent + 1) * node_width); ++node)
                if (tree.bodies_below(level, node) > 0)
                    regions.push_back({tree.bounds(level, node), top - level, !is_left_[at(level)][node]});
    }
    return regions;
}

std::uint64_t Delimitation::bodies_left(const AabbTree& tree)
{
    count(tree);
    return bodies_left_;
}

/// A node is left if a query overlaps a leaf region below it.
void Delimitation::mark(const AabbTree& tree)
{
    const auto levels = static_cast<std::size_t>(tree.view().levels);
    is_left_.resize(levels + 1), left_.resize(levels + 1);
    for (std::size_t level = 1; level <= levels; ++level) {
        for (std::uint32_t node : left_[level])
            if (node < is_left_[level].size()) is_left_[level][node] = 0;
        left_[level].clear();
        is_left_[level].resize(level == levels ? 1 : tree.view().level[level].count, 0);
    }
    for (const auto& reached : reached_)
        for (std::size_t k = 0; k < reached->size(); ++k) {
            std::uint32_t node = reached->j()[k];
            if (tree.bodies_below(1, node) == 0) continue; // all bodies have left the node
            for (std::size_t level = 1; level <= levels && !std::exchange(is_left_[level][node], 1); ++level) {
                left_[level].push_back(node);
                node /= node_width;
            }
        }
}

void Delimitation::count_rejected(const AabbTree& tree)
{
    const int top = tree.view().levels; // the only node of this level is the whole scene
    const auto at = [](int level) { return static_cast<std::size_t>(level); };
    const auto level_of = [&](int level) -> DelimitationLevel& { return levels_[at(top - level)]; };
    level_of(top).regions = 1;
    if (left_[at(top)].empty()) {
        level_of(top).regions_rejected = 1, level_of(top).volume_rejected = 1;
        level_of(top).bodies_rejected = tree.bodies();
        return;
    }
    std::uint64_t bodies = tree.bodies(); // bodies in the regions left one level up
    for (int level = top - 1; level > 0; --level) {
        DelimitationLevel& counts = level_of(level);
        const std::uint32_t nodes = tree.view().level[level].count;
        for (std::uint32_t parent : left_[at(level + 1)])
            for (std::uint32_t node = parent * node_width; node < std::min(nodes, (parent + 1) * node_width); ++node)
                counts.regions += tree.bodies_below(level, node) > 0;
        ONCOLLIDE_ASSERT(left_[at(level)].size() <= counts.regions);
        counts.regions_rejected = counts.regions - left_[at(level)].size();
        counts.bodies_rejected = bodies;
        bodies = 0;
        double volume = 0;
        for (std::uint32_t node : left_[at(level)])
            bodies += tree.bodies_below(level, node), volume += tree.volume(level, node);
        ONCOLLIDE_ASSERT(bodies <= counts.bodies_rejected);
        counts.bodies_rejected -= bodies;
        counts.volume_rejected = tree.volume(level) > 0 ? std::max(0.0, 1 - volume / tree.volume(level)) : 0;
    }
    bodies_left_ = bodies;
}

void Delimitation::survivors(const AabbTree& tree, std::vector<std::uint32_t>& bodies)
{
    count(tree);
    bodies.clear();
    if (left_.size() < 2 || levels_.empty()) return;
    for (std::uint32_t leaf : left_[1])
        for (std::uint32_t place = leaf * node_width;
             place < std::min<std::size_t>(tree.size(), (leaf + 1) * node_width); ++place)
            if (tree.body_at(place) != no_body) bodies.push_back(tree.body_at(place));
    std::sort(bodies.begin(), bodies.end());
    ONCOLLIDE_ASSERT(std::ranges::adjacent_find(bodies) == bodies.end());
}

std::size_t Delimitation::bytes() const
{
    std::size_t sum = boxes_.capacity() * sizeof(float) + filters_.capacity() * sizeof(filters_[0]);
    for (const auto& list : reached_) sum += list->bytes();
    for (const auto& list : next_) sum += list->bytes();
    for (const auto& list : left_) sum += list.capacity() * sizeof(list[0]);
    for (const auto& list : is_left_) sum += list.capacity();
    return sum;
}

} // namespace oncollide
