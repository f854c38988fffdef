#include <algorithm>

#include <fmt/format.h>

#include <oncollide/broadphase/aabb_checks.hpp>
#include <oncollide/broadphase/tree/dynamic_tree.hpp>

namespace oncollide {

std::string DynamicTree::fault_of_bodies() const
{
    if (std::string fault = bodies_.validate(); !fault.empty()) return "bodies: " + fault;
    if (tree_.bodies() != bodies_.size())
        return fmt::format("the tree holds {} of {} bodies", tree_.bodies(), bodies_.size());
    for (std::uint32_t body = 0; body < bodies_.rows(); ++body) {
        const bool present = contains(body);
        if (bodies_.is(body, BodyStates::held) != present)
            return fmt::format("body {}: the tree is not up to date", body);
        if (bodies_.is(body, BodyStates::escaped)) return fmt::format("body {}: its pairs were not searched for", body);
        const Aabb* loose = loose_.find(body);
        if (loose && !present) return fmt::format("body {}: is absent, but has a loose AABB", body);
        if (!loose) continue;
        float held[6], least[6];
        tree_.box_at(tree_.place_of(body), held), tree_.round(*loose, options_.margin, least);
        if (!std::equal(held, held + 6, least)) return fmt::format("body {}: its loose AABB is not in the tree", body);
    }
    return {};
}

/// The pairs are sorted, occur once each, and are pairs of bodies that may collide.
std::string DynamicTree::fault_of_pairs(const BodyColumns& columns) const
{
    for (const std::vector<BodyPair>* list : {&pairs_, &near_})
        for (std::size_t k = 0; k < list->size(); ++k) {
            const std::uint32_t a = (*list)[k].a, b = (*list)[k].b;
            const auto fault = [&](const char* what) { return fmt::format("pair ({}, {}): {}", a, b, what); };
            if (a >= b || (k > 0 && !((*list)[k - 1] < BodyPair{a, b}))) return fault("is not in order");
            if (!contains(a) || !contains(b)) return fault("one of its bodies is absent");
            if (!bodies_.is(a, BodyStates::dynamic) && !bodies_.is(b, BodyStates::dynamic))
                return fault("both of its bodies are static");
            if (!columns.allows(a, b)) return fault("is forbidden");
            if (list == &pairs_ && !overlap(columns.boxes[a], columns.boxes[b], options_.margin))
                return fault("its boxes do not overlap");
        }
    if (!near_are_pairs_ && !std::ranges::includes(near_, pairs_))
        return "a pair is not among the pairs of loose AABBs";
    return near_are_pairs_ && !near_.empty() ? "the pairs of loose AABBs are out of date" : "";
}

std::string DynamicTree::validate(const BodyColumns& columns) const
{
    const bool marked = marked_version_ == bodies_.dynamic_version();
    if (std::string fault =
            tree_.validate(columns, options_.margin, marked ? bodies_.data() : nullptr, BodyStates::dynamic);
        !fault.empty())
        return "tree: " + fault;
    if (std::string fault = loose_.validate(columns); !fault.empty()) return "loose AABBs: " + fault;
    if (std::string fault = fault_of_bodies(); !fault.empty()) return fault;
    return fault_of_pairs(columns);
}

} // namespace oncollide
