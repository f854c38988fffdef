#include <oncollide/broadphase/tree_search.hpp>

#include <algorithm>

#include <oncollide/base/parallel.hpp>

namespace oncollide {

void FoundPairs::grow(PairSink& sink)
{
    auto& mine = *static_cast<FoundPairs*>(sink.owner);
    const std::size_t room = std::max<std::size_t>(1024, 2 * mine.i_.size());
    mine.i_.resize(room), mine.j_.resize(room);
    sink.i = mine.i_.data(), sink.j = mine.j_.data(), sink.room = room;
}

void FoundPairs::assign_all(std::size_t first, std::size_t last, std::uint32_t j)
{
    clear();
    while (sink_.room < last - first) grow(sink_);
    for (std::size_t k = first; k < last; ++k, ++sink_.count)
        i_[sink_.count] = static_cast<std::uint32_t>(k), j_[sink_.count] = j;
}

LayerSummary::LayerSummary(const BodyFilter& filter)
{
    for (std::size_t i = 0; i < filter.layers.size(); ++i) add(filter.layers[i], filter.masks[i]);
}

void TreeSearch::find_pairs(BoxTree& tree, std::span<const Aabb> boxes, const BodyFilter& filter, double margin,
                            bool exact, int threads, std::vector<BodyPair>& pairs)
{
    layers_asked_ = !LayerSummary(filter).allow_all();
    if (layers_asked_)
        tree.set_layers(filter);
    else
        tree.forget_layers();
    if (tree.size() < worth_threads) threads = 1;
    search(tree, threads);

    // What the threads found, one thread's after the other.
    starts_.assign(found_.size() + 1, 0), counts_.assign(found_.size(), 0);
    for (std::size_t w = 0; w < found_.size(); ++w) starts_[w + 1] = starts_[w] + found_[w]->size();
    pairs.resize(starts_.back());
    parallel_chunks(found_.size(), 1, threads, [&](std::size_t first, std::size_t last, int) {
        for (std::size_t w = first; w < last; ++w)
            counts_[w] = translate(tree, *found_[w], boxes, filter, margin, exact, pairs.data() + starts_[w]);
    });
    std::size_t end = 0;
    for (std::size_t w = 0; w < found_.size(); ++w) {
        if (end != starts_[w]) std::copy_n(pairs.data() + starts_[w], counts_[w], pairs.data() + end);
        end += counts_[w];
    }
    pairs.resize(end);
}

void TreeSearch::search(const BoxTree& tree, int threads)
{
    while (found_.size() < static_cast<std::size_t>(std::max(threads, 1)))
        found_.push_back(std::make_unique<FoundPairs>());
    for (const auto& found : found_) found->clear();
    const BoxTreeView& view = tree.view();
    if (view.levels == 0) return;
    if (threads <= 1 || view.levels < 3) return box_tree_kernel().all(view, 0, found_[0]->sink());

    // Nodes two levels up, and the pairs of them that overlap, are the threads' tasks.
    constexpr int level = 2;
    tasks_.clear();
    box_tree_kernel().all(view, level, tasks_.sink());
    const std::size_t nodes = view.level[level].count, all = nodes + tasks_.size();
    parallel_chunks(all, 16, threads, [&](std::size_t begin, std::size_t end, int thread) {
        PairSink& sink = found_[static_cast<std::size_t>(thread)]->sink();
        for (std::size_t i = begin; i < end; ++i)
            if (i < nodes)
                box_tree_kernel().within(view, level, static_cast<std::uint32_t>(i), sink);
            else
                box_tree_kernel().between(view, level, tasks_.i(i - nodes), tasks_.j(i - nodes), sink);
    });
}

std::size_t TreeSearch::translate(const BoxTree& tree, const FoundPairs& found, std::span<const Aabb> boxes,
                                  const BodyFilter& filter, double margin, bool exact, BodyPair* out) const
{
    const BodyPair* const begin = out;
    for (std::size_t k = 0; k < found.size(); ++k) {
        const std::uint32_t i = found.i(k), j = found.j(k), a = tree.body_at(i), b = tree.body_at(j);
        *out = {std::min(a, b), std::max(a, b)};
        out += (!layers_asked_ || filter.allows(a, b)) &&
               (!exact || tree.surely_overlap(i, j) || overlap(boxes[a], boxes[b], margin));
    }
    return static_cast<std::size_t>(out - begin);
}

std::size_t TreeSearch::bytes() const
{
    std::size_t sum = tasks_.bytes();
    for (const auto& found : found_) sum += found->bytes();
    return sum;
}

} // namespace oncollide
