#include <algorithm>
#include <cstring>

#include <oncollide/broadphase/box_tree.hpp>
#include <oncollide/broadphase/broad_phase.hpp>
#include <oncollide/broadphase/pair_sort.hpp>
#include <oncollide/scenes/parallel.hpp>

namespace oncollide {

namespace {

/// Pairs of places that one thread found, as columns.
class FoundPairs {
public:
    PairSink& sink() { return sink_; }
    void clear() { sink_.count = 0; }
    std::size_t size() const { return static_cast<std::size_t>(sink_.count); }
    std::uint32_t i(std::size_t k) const { return i_[k]; }
    std::uint32_t j(std::size_t k) const { return j_[k]; }
    std::size_t bytes() const { return (i_.capacity() + j_.capacity()) * sizeof(std::uint32_t); }

private:
    static void grow(PairSink& sink)
    {
        auto& mine = *static_cast<FoundPairs*>(sink.owner);
        const std::size_t room = std::max<std::size_t>(1024, 2 * mine.i_.size());
        mine.i_.resize(room), mine.j_.resize(room);
        sink.i = mine.i_.data(), sink.j = mine.j_.data(), sink.room = room;
    }

    std::vector<std::uint32_t> i_, j_;
    PairSink sink_{nullptr, nullptr, 0, 0, grow, this};
};

class KdTree final : public BroadPhase {
public:
    std::string_view name() const override { return "kd"; }

    void find_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                    double margin, int threads, std::vector<BodyPair>& pairs) override
    {
        if (bodies.size() < worth_threads) threads = 1;
        take_in(boxes, bodies, filter, margin, threads);
        search(threads);
        allows_all_ = allows_all(filter);
        translate(boxes, margin, filter, threads, pairs);
        sort_pairs(pairs, scratch_, filter.is_static.size(), threads);
    }

    bool follows_movers() const override { return true; }

    void update_pairs(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies,
                      std::span<const std::uint32_t> moved, std::span<const std::uint32_t> asked,
                      const BodyFilter& filter, double margin, int threads, std::vector<BodyPair>& pairs) override
    {
        // A query costs a few times its share of a search of the whole tree.
        if (tree_.view().levels == 0 || 4 * moved.size() > bodies_.size())
            return find_pairs(boxes, bodies, filter, margin, threads, pairs);
        if (moved.size() < worth_threads / 8) threads = 1;
        tree_.refit_bodies(boxes, margin, moved);
        if (tree_.worn()) take_in(boxes, bodies_, filter, margin, threads);
        has_moved_.resize(filter.is_static.size());
        for (std::uint32_t body : moved) has_moved_[body] = 1;
        query(asked, threads);
        found_.clear();
        for (const auto& worker : workers_) translate_queries(worker->found, asked, boxes, margin, filter);
        sort_pairs(found_, scratch_, filter.is_static.size(), threads);
        // What was known of bodies that moved is out of date; both lists are sorted.
        std::erase_if(pairs, [&](BodyPair p) { return has_moved_[p.a] | has_moved_[p.b]; });
        scratch_.resize(pairs.size() + found_.size());
        std::ranges::merge(pairs, found_, scratch_.begin());
        pairs.swap(scratch_);
        for (std::uint32_t body : moved) has_moved_[body] = 0;
    }

    std::size_t bytes() const override
    {
        std::size_t sum = tree_.bytes() + bodies_.capacity() * sizeof(bodies_[0]) + is_static_.capacity() +
                          has_moved_.capacity() + (scratch_.capacity() + found_.capacity()) * sizeof(BodyPair);
        for (const auto& worker : workers_) sum += worker->found.bytes() + worker->blocks.bytes();
        return sum;
    }

private:
    struct Worker {
        FoundPairs found, blocks;
    };

    static constexpr std::size_t worth_threads = 32768; ///< bodies: fewer are done before threads have woken

    void take_in(std::span<const Aabb> boxes, std::span<const std::uint32_t> bodies, const BodyFilter& filter,
                 double margin, int threads)
    {
        const bool same = tree_.view().levels > 0 && std::ranges::equal(bodies, bodies_);
        if (same) tree_.refit(boxes, margin, threads);
        if (!same || tree_.worn()) {
            if (!same) bodies_.assign(bodies.begin(), bodies.end());
            tree_.build(boxes, bodies, margin, threads);
            is_static_.clear();
        }
        if (!std::ranges::equal(filter.is_static, is_static_)) {
            is_static_.assign(filter.is_static.begin(), filter.is_static.end());
            tree_.set_moving(is_static_);
        }
    }

    void make_workers(int threads)
    {
        while (workers_.size() < static_cast<std::size_t>(std::max(threads, 1)))
            workers_.push_back(std::make_unique<Worker>());
        for (const auto& worker : workers_) worker->found.clear();
    }

    /// Places around each of these bodies, as pairs (number of the body in the list, place). First the blocks that they
    /// lie in, then these: so that many blocks can be on their way from memory at a time.
    void query(std::span<const std::uint32_t> bodies, int threads)
    {
        make_workers(threads);
        queries_.resize(6 * bodies.size());
        parallel_chunks(bodies.size(), 256, threads, [&](std::size_t begin, std::size_t end, int thread) {
            Worker& worker = *workers_[static_cast<std::size_t>(thread)];
            worker.blocks.clear();
            for (std::size_t i = begin; i < end; ++i) {
                tree_.box_at(tree_.place_of(bodies[i]), &queries_[6 * i]);
                box_tree_kernel().blocks_around(tree_.view(), &queries_[6 * i], static_cast<std::uint32_t>(i),
                                                worker.blocks.sink());
            }
            const PairSink& blocks = worker.blocks.sink();
            box_tree_kernel().in_blocks(tree_.view(), blocks.i, blocks.j, blocks.count, queries_.data(),
                                        worker.found.sink());
        });
    }

    void translate_queries(const FoundPairs& found, std::span<const std::uint32_t> bodies, std::span<const Aabb> boxes,
                           double margin, const BodyFilter& filter)
    {
        for (std::size_t k = 0; k < found.size(); ++k) {
            const std::uint32_t body = bodies[found.i(k)], other = tree_.body_at(found.j(k));
            if (other == body || (has_moved_[other] && other < body)) continue; // that one finds the pair
            if (filter.allows(body, other) &&
                overlap(tree_.place_of(body), found.j(k), boxes[body], boxes[other], margin))
                found_.push_back({std::min(body, other), std::max(body, other)});
        }
    }

    void search(int threads)
    {
        make_workers(threads);
        const BoxTreeView& view = tree_.view();
        if (threads <= 1 || view.levels < 3) return box_tree_kernel().all(view, 0, workers_[0]->found.sink());

        // Nodes two levels up, and the pairs of them that overlap, are the threads' tasks.
        constexpr int level = 2;
        tasks_.clear();
        box_tree_kernel().all(view, level, tasks_.sink());
        const std::size_t nodes = view.level[level].count, all = nodes + tasks_.size();
        parallel_chunks(all, 16, threads, [&](std::size_t begin, std::size_t end, int thread) {
            PairSink& sink = workers_[static_cast<std::size_t>(thread)]->found.sink();
            for (std::size_t i = begin; i < end; ++i)
                if (i < nodes)
                    box_tree_kernel().within(view, level, static_cast<std::uint32_t>(i), sink);
                else
                    box_tree_kernel().between(view, level, tasks_.i(i - nodes), tasks_.j(i - nodes), sink);
        });
    }

    /// Can layers and masks be left alone? Static pairs the search leaves out by itself.
    static bool allows_all(const BodyFilter& filter)
    {
        std::uint32_t some = 0, least = ~0u, mask = ~0u;
        for (std::uint32_t layer : filter.layers) some |= layer, least = std::min(least, layer);
        for (std::uint32_t m : filter.masks) mask &= m;
        return least > 0 && (some & ~mask) == 0;
    }

    /// What the threads found, as pairs of bodies, one thread's after the other.
    void translate(std::span<const Aabb> boxes, double margin, const BodyFilter& filter, int threads,
                   std::vector<BodyPair>& pairs)
    {
        starts_.assign(workers_.size() + 1, 0), counts_.assign(workers_.size(), 0);
        for (std::size_t w = 0; w < workers_.size(); ++w) starts_[w + 1] = starts_[w] + workers_[w]->found.size();
        pairs.resize(starts_.back());
        parallel_chunks(workers_.size(), 1, threads, [&](std::size_t first, std::size_t last, int) {
            for (std::size_t w = first; w < last; ++w)
                counts_[w] = translate(workers_[w]->found, boxes, margin, filter, pairs.data() + starts_[w]);
        });
        std::size_t end = 0;
        for (std::size_t w = 0; w < workers_.size(); ++w) {
            if (end != starts_[w]) std::copy_n(pairs.data() + starts_[w], counts_[w], pairs.data() + end);
            end += counts_[w];
        }
        pairs.resize(end);
    }

    /// The search compares in float, rounded outward; where that leaves a doubt, the boxes themselves decide.
    bool overlap(std::uint32_t i, std::uint32_t j, const Aabb& a, const Aabb& b, double margin) const
    {
        return tree_.surely_overlap(i, j) ||
               !(((a.min - b.max).array() > margin).any() || ((b.min - a.max).array() > margin).any());
    }

    std::size_t translate(const FoundPairs& found, std::span<const Aabb> boxes, double margin, const BodyFilter& filter,
                          BodyPair* out) const
    {
        const BodyPair* const begin = out;
        for (std::size_t k = 0; k < found.size(); ++k) {
            const std::uint32_t a = tree_.body_at(found.i(k)), b = tree_.body_at(found.j(k));
            *out = {std::min(a, b), std::max(a, b)};
            out += (allows_all_ || filter.allows(a, b)) && overlap(found.i(k), found.j(k), boxes[a], boxes[b], margin);
        }
        return static_cast<std::size_t>(out - begin);
    }

    BoxTree tree_;
    std::vector<std::uint32_t> bodies_;   ///< in the tree
    std::vector<std::uint8_t> is_static_; ///< as the tree knows it
    std::vector<std::uint8_t> has_moved_; ///< by body, all 0 between calls
    std::vector<BodyPair> found_;         ///< of bodies that moved
    bool allows_all_ = false;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::vector<float> queries_; ///< 6 a body that is asked for
    FoundPairs tasks_;
    std::vector<std::size_t> starts_, counts_; ///< of the workers' pairs
    std::vector<BodyPair> scratch_;
};

} // namespace

std::unique_ptr<BroadPhase> make_kd_tree()
{
    return std::make_unique<KdTree>();
}

} // namespace oncollide
