// The traversal that finds all primitives that meet. It never ends early, so their order does not matter.
#pragma once
#include <algorithm>
#include <span>
#include <type_traits>

#include <oncollide/narrowphase/walks/box_walk_queries.hpp>

namespace oncollide {

/// Calls take_leaves(entry) for all pairs of leaves within `gap_limit`. Several boxes are opened together, so that the
/// processor can begin with one before it knows the result of another; there are few branches, as they cannot be
/// predicted.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
void BoxWalk<A, B, Leaves>::walk_all(float gap_limit, auto take_leaves)
{
    constexpr std::size_t at_once = 8;
    struct Row {
        std::uint64_t part;    ///< box 0 of the opened node, and the box that it was compared with
        unsigned shift;        ///< position of the opened side in an entry
        unsigned near, leaves; ///< one bit for each of the node's boxes
    } rows[at_once];
    const auto compare = [&](Row& row, auto& opened, const auto& other, std::uint32_t box, std::uint32_t other_box) {
        const std::uint32_t slot = opened.descend(box / 8, box % 8);
        const auto& node = opened[slot];
        const auto& other_node = other[other_box / 8];
        float gaps[8];
        row.part = std::uint64_t{8 * slot} << row.shift | std::uint64_t{other_box} << (32 - row.shift);
        row.leaves = other_node.leaf(other_box % 8) ? node.masks.leaves : 0;
        row.near = kernel_.compare(node.boxes, other_node.boxes, other_box % 8, gap_limit, gaps, nearest_);
    };
    std::size_t to_open = 0; // among the initial entries; later the stack holds only such entries
    for (std::size_t i = 0; i < top_; ++i) {
        const Entry e = stack_[i];
        if (both_leaves(e))
            take_leaves(e);
        else
            stack_[to_open++] = e;
    }
    top_ = to_open;
    while (top_) {
        const std::size_t count = std::min(top_, at_once);
        for (Row* row = rows; row < rows + count; ++row) {
            const Entry e = stack_[--top_];
            const bool down_a = opens_a(e);
            row->shift = down_a ? 0 : 32;
            const auto box = static_cast<std::uint32_t>(e.boxes >> row->shift);
            const auto other = static_cast<std::uint32_t>(e.boxes >> (32 - row->shift));
            if constexpr (std::is_same_v<A, B>)
                compare(*row, *(down_a ? &a_ : &b_), *(down_a ? &b_ : &a_), box, other);
            else if (down_a)
                compare(*row, a_, b_, box, other);
            else
                compare(*row, b_, a_, box, other);
        }
        box_rows += count;
        if (stack_.size() < top_ + 8 * (at_once + 1)) stack_.resize(2 * (top_ + 8 * (at_once + 1)));
        for (const Row& row : std::span(rows, count)) {
            for (unsigned k = 0; k < 8; ++k) {
                stack_[top_].boxes = row.part + (std::uint64_t{k} << row.shift);
                top_ += (row.near & ~row.leaves) >> k & 1;
            }
            Entry e;
            for (unsigned boxes = row.near & row.leaves; boxes; boxes &= boxes - 1) {
                e.boxes = row.part + (std::uint64_t(__builtin_ctz(boxes)) << row.shift);
                take_leaves(e);
            }
        }
    }
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
void BoxWalk<A, B, Leaves>::all_meetings(A& a, B& b, const RelativePose& b_to_a, auto found, auto leave)
{
    const WalkFrame frame(a, b, b_to_a, 0);
    far_ = true;
    if (frame.apart > 0) return;
    start_near(a, b, b_to_a, frame, 0);
    std::size_t count = 0;
    const auto test = [&] {
        const std::span<Pair> pairs(waiting_.data(), count);
        const auto kept = std::remove_if(pairs.begin(), pairs.end(), leave);
        leaves_.meeting(std::span<const Pair>(pairs.begin(), kept), [&](Pair pair) { return found(pair), true; });
        count = 0;
    };
    walk_all(frame.gap_within(0), [&](Entry e) {
        const auto of_a = a_.primitives(e.slot_a(), e.lane_a());
        const auto of_b = b_.primitives(e.slot_b(), e.lane_b());
        const auto room = [&](std::size_t more) {
            if (waiting_.size() < count + more) waiting_.resize(2 * (count + more));
            return &waiting_[count];
        };
        if constexpr (requires { of_a.back(), of_b.back(); })
            if (of_a.size() <= 2 && of_b.size() <= 2) { // without loops, whose ends cannot be predicted
                Pair *const to = room(4), *const then = to + of_b.size();
                to[0] = {of_a.front(), of_b.front()}, to[1] = {of_a.front(), of_b.back()};
                then[0] = {of_a.back(), of_b.front()}, then[1] = {of_a.back(), of_b.back()};
                count += of_a.size() * of_b.size();
                if (count >= most_batch) test();
                return;
            }
        for (const auto x : of_a)
            for (const auto y : of_b) *room(1) = {x, y}, ++count;
        if (count >= most_batch) test();
    });
    test();
    waiting_.clear();
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
void BoxWalk<A, B, Leaves>::all_near(A& a, B& b, const RelativePose& b_to_a, double clearance, auto visit)
{
    const WalkFrame frame(a, b, b_to_a, clearance);
    far_ = true;
    if (frame.apart > clearance) return;
    start_near(a, b, b_to_a, frame, clearance);
    walk_all(frame.gap_within(clearance),
             [&](Entry e) { each_pair(e, [&](const Pair& pair) { return visit(pair), true; }); });
}

} // namespace oncollide
