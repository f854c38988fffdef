// Queries of the tree between changes: the regions of the delimitation, boxes and segments.
#include <algorithm>

#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/segment_part.hpp>
#include <oncollide/broadphase/tree/dynamic_tree.hpp>

namespace oncollide {

std::span<const DelimitationLevel> DynamicTree::levels()
{
    if (whole_) return {};
    return delimitation_.levels(tree_);
}
std::vector<DelimitedRegion> DynamicTree::regions()
{
    if (whole_) return {};
    return delimitation_.regions(tree_);
}
std::uint64_t DynamicTree::bodies_left()
{
    return whole_ || delimitation_.in_a_heap() ? size() : delimitation_.bodies_left(tree_);
}
void DynamicTree::survivors(std::vector<std::uint32_t>& bodies)
{
    if (whole_ || delimitation_.in_a_heap()) return bodies_.list(bodies);
    delimitation_.survivors(tree_, bodies);
    // Filters may have rejected the leaves of the queried bodies themselves.
    bodies.insert(bodies.end(), queries_.begin(), queries_.end());
    for (const BodyPair pair : near_are_pairs_ ? pairs_ : near_)
        if (to_compare(pair)) bodies.push_back(pair.a), bodies.push_back(pair.b);
    std::ranges::sort(bodies);
    bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
}

/// Appends the bodies at the places that search(sink) finds for query `k` and that meets(body) holds for, sorted.
template <class Search, class Meets>
void DynamicTree::add_hits(std::uint32_t k, Search search, Meets meets, std::vector<AabbHit>& hits) const
{
    const std::size_t first = hits.size();
    const auto take = [&](const std::uint32_t*, const std::uint32_t* places, std::size_t count) {
        for (std::size_t i = 0; i < count; ++i)
            if (const std::uint32_t body = tree_.body_at(places[i]); meets(body)) hits.push_back({k, body});
    };
    find_in_chunks(take, search);
    std::sort(hits.begin() + static_cast<std::ptrdiff_t>(first), hits.end());
}

void DynamicTree::query(const BodyColumns& columns, std::span<const Aabb> boxes, std::vector<AabbHit>& hits) const
{
    check_query(columns), refuse_unusable_queries(boxes);
    hits.clear();
    for (std::uint32_t k = 0; k < boxes.size(); ++k) {
        float box[6];
        tree_.round(boxes[k], options_.margin, box);
        add_hits(
            k, [&](PairSink& sink) { aabb_tree_kernel().below_root(tree_.view(), k, box, sink); },
            [&](std::uint32_t body) { return overlap(boxes[k], columns.boxes[body], options_.margin); }, hits);
    }
}

void DynamicTree::query_segments(const BodyColumns& columns, std::span<const Segment> segments,
                                 std::vector<AabbHit>& hits) const
{
    check_query(columns), refuse_unusable_queries(segments);
    hits.clear();
    const bool few = tree_.bodies() <= 2 && tree_.size() <= 16; // testing all is faster than using the tree
    for (std::uint32_t k = 0; k < segments.size(); ++k) {
        const auto meets = [&](std::uint32_t body) {
            return part_in(segments[k], grown(columns.boxes[body], options_.margin)).has_value();
        };
        SegmentLine line;
        if (!few && !tree_.find_line(segments[k], options_.margin, line)) continue;
        const auto search = [&](PairSink& sink) {
            if (!few) return aabb_tree_kernel().on_segment(tree_.view(), k, line, sink);
            for (std::uint32_t place = 0; place < tree_.size(); ++place)
                if (tree_.body_at(place) != no_body) sink.i[sink.count] = k, sink.j[sink.count++] = place;
        };
        add_hits(k, search, meets, hits);
    }
}

} // namespace oncollide
