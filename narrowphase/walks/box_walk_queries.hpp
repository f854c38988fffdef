// The steps of a traversal, and the queries that end early.
#pragma once
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include <oncollide/narrowphase/walks/box_walk.hpp>

namespace oncollide {

/// Calls visit(pair) for the primitives in two leaves while it returns true. Returns whether it always did.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
bool BoxWalk<A, B, Leaves>::each_pair(Entry e, auto visit) const
{
    const auto of_b = b_.primitives(e.slot_b(), e.lane_b());
    for (const auto a : a_.primitives(e.slot_a(), e.lane_a()))
        for (const auto b : of_b)
            if (!visit(Pair{a, b})) return false;
    return true;
}

/// Opens the larger box, and compares its parts with the other box.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
template <typename BoxWalk<A, B, Leaves>::Gaps gaps>
unsigned BoxWalk<A, B, Leaves>::open(Entry e, float gap_limit)
{
    const bool down_a = opens_a(e);
    return compare<gaps>(e, down_a, down_a ? a_.descend(e.slot_a(), e.lane_a()) : b_.descend(e.slot_b(), e.lane_b()),
                         gap_limit);
}

/// Pushes the boxes of the node in the slot, of A or of B, that are within `gap_limit` of the other box, the nearest or
/// likeliest last. With Gaps::in_time, pushes the boxes that may meet the other one in time, the first to meet last.
/// Returns how many.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
template <typename BoxWalk<A, B, Leaves>::Gaps how>
unsigned BoxWalk<A, B, Leaves>::compare(Entry e, bool down_a, std::uint32_t slot, float gap_limit)
{
    [[maybe_unused]] BoxLine line;
    if constexpr (how == Gaps::far) line = line_to(e, down_a); // may open nodes
    const OpenBoxes &boxes = down_a ? a_[slot].boxes : b_[slot].boxes,
                    &other = down_a ? b_[e.slot_b()].boxes : a_[e.slot_a()].boxes;
    ++box_rows;
    float gaps[8];
    const unsigned k = down_a ? e.lane_b() : e.lane_a();
    if (down_a) // as a rule the other box is soon the larger one
        b_.prefetch(e.slot_b(), k);
    else
        a_.prefetch(e.slot_a(), k);
    unsigned near;
    if constexpr (how == Gaps::in_time) {
        BoxMotion motion;
        set_motion(motion, e, down_a);
        near = kernel_.meet_in_time(boxes, other, k, motion, gap_limit, gaps);
    } else if constexpr (how == Gaps::far)
        near = kernel_.compare_far(boxes, other, k, line, gap_limit, gaps, nearest_);
    else if constexpr (how == Gaps::likely)
        near = kernel_.compare_likely(boxes, other, k, gap_limit, gaps, nearest_);
    else
        near = kernel_.compare(boxes, other, k, gap_limit, gaps, nearest_);
    if (!near) return 0;
    const unsigned found = near;
    if (stack_.size() < top_ + 8) stack_.resize(2 * (top_ + 8));
    Entry* const first = &stack_[top_];
    const Entry part = down_a ? Entry(slot, 0, e.slot_b(), k) : Entry(e.slot_a(), k, slot, 0); // box 0 of the node
    Entry *out = first, child, nearest;
    for (bool any = false; near; near &= near - 1, any = true) {
        const auto lane = static_cast<unsigned>(__builtin_ctz(near));
        child.boxes = part.boxes + (std::uint64_t{lane} << (down_a ? 0 : 32));
        child.gap = gaps[lane];
        if (!any) {
            nearest = child;
        } else if (child.gap < nearest.gap) {
            *out++ = nearest;
            nearest = child;
        } else {
            *out++ = child;
        }
    }
    *out++ = nearest;
    const auto count = static_cast<unsigned>(out - first);
    down_a ? a_.prefetch_below(slot, found) : b_.prefetch_below(slot, found);
    top_ += count;
    return count;
}

/// Depth first: calls take_leaves(entry) for pairs of leaves within `gap_limit`, while it returns true and ends(entry),
/// which is called for all pairs of boxes, returns false.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
template <typename BoxWalk<A, B, Leaves>::Gaps gaps>
void BoxWalk<A, B, Leaves>::walk(float gap_limit, auto take_leaves, auto ends)
{
    while (top_) {
        const Entry e = stack_[--top_];
        if (ends(e)) return;
        if (!both_leaves(e))
            open<gaps>(e, gap_limit);
        else if (!take_leaves(e))
            return;
    }
}

/// Calls test_waiting() once `batch` pairs wait, and doubles the batch: a first meeting is likely among the first
/// pairs.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
bool BoxWalk<A, B, Leaves>::test_if_enough(std::size_t& batch, auto found)
{
    if (waiting_.size() < batch) return true;
    batch = std::min(2 * batch, most_batch);
    return test_waiting(found);
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
double BoxWalk<A, B, Leaves>::meetings(A& a, B& b, const RelativePose& b_to_a, std::optional<Pair> hint, auto found,
                                       auto leave, std::optional<Place>* place)
{
    const WalkFrame frame(a, b, b_to_a, 0);
    far_ = true;
    if (frame.apart > 0) return frame.apart;
    bool met = false, go_on = true;
    const auto take = [&](Pair pair) {
        met = true;
        set_place(a, b, place, pair);
        return found(pair);
    };
    if (!go_on_after_hint(a, b, b_to_a, hint, take)) return ++hints_held, 0;
    if (!go_on_after_place(a, b, b_to_a, frame, place, take, leave)) return ++hints_held, 0;
    std::size_t batch = first_batch;
    start_near(a, b, b_to_a, frame, 0);
    walk(frame.gap_within(0), [&](Entry e) {
        wait(e, leave);
        return go_on = test_if_enough(batch, take);
    });
    if (go_on) test_waiting(take);
    return met ? 0 : least_gap(frame);
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
NearBounds<typename Leaves::Pair> BoxWalk<A, B, Leaves>::near(A& a, B& b, const RelativePose& b_to_a, double clearance,
                                                              double tolerance, std::optional<Pair> hint,
                                                              std::optional<Place>* place)
{
    const WalkFrame frame(a, b, b_to_a, clearance);
    far_ = true;
    if (frame.apart > clearance) return {false, frame.apart, {}};
    // Poses may be 2^-20 from rigid, so a distance in A's frame may differ from the distance in the world frame.
    const double rounding = frame.leaf_rounding + 0x1p-18 * clearance;
    NearBounds<Pair> result{false, clearance + std::max(tolerance, 2 * rounding), {}};
    const double enough = result.bound - rounding;
    const Entry* from = nullptr; // the entry of the pairs that are tested at once
    const auto take = [&](Pair pair) {
        result.near = true, result.witness = pair;
        set_place(a, b, place, pair, from);
        return false;
    };
    if (!go_on_after_hint(a, b, b_to_a, hint, take)) return ++hints_held, result;
    if (!go_on_after_place(a, b, b_to_a, frame, place, take, [](const Pair&) { return false; }))
        return ++hints_held, result;
    std::size_t batch = first_batch;
    double lower = infinity; // lower bound over primitives that do not wait
    const auto take_pair = [&](Pair pair, bool small) {
        if (small || clearance > 0) {
            if (leaves_.most(pair) <= enough) return take(pair);
            if (clearance > 0) {
                const Nearest found = nearest(pair, frame);
                const double least = found.lower - 0x1p-18 * clearance;
                if (least <= clearance) {
                    // If only bounds of a pair are known, its distance may be larger than rounding explains.
                    if constexpr (requires { leaves_.bounds(pair); })
                        result.bound = std::max(result.bound, found.upper);
                    return take(pair);
                }
                if (leaves_.meet(pair)) return take(pair);
                lower = std::min(lower, least);
                return true;
            }
        }
        waiting_.push_back(pair), from_.push_back(*from);
        return true;
    };
    // Without a bound, boxes decide: pairs of leaves, or of boxes that are small for the clearance.
    const bool by_boxes = std::isinf(tolerance);
    const double small_box = 0x1p-6 * clearance * clearance;
    const auto boxes_decide = [&](Entry e) {
        const auto is_small = [&](float size2, bool leaf) { return leaf || double(size2) <= small_box; };
        return result.near = by_boxes && is_small(a_[e.slot_a()].size(e.lane_a()), a_[e.slot_a()].leaf(e.lane_a())) &&
                             is_small(b_[e.slot_b()].size(e.lane_b()), b_[e.slot_b()].leaf(e.lane_b()));
    };
    const auto take_leaves = [&](Entry e) {
        const float size2 = a_[e.slot_a()].size(e.lane_a()) + b_[e.slot_b()].size(e.lane_b());
        const bool small = double(size2) <= 16 * enough * enough; // otherwise their corners are rarely that near
        from = &e;
        return each_pair(e, [&](Pair pair) { return take_pair(pair, small); }) && test_if_enough(batch, take);
    };
    start_near(a, b, b_to_a, frame, clearance);
    walk(frame.gap_within(clearance), take_leaves, boxes_decide);
    from = nullptr;
    if (result.near || !test_waiting(take)) return result;
    return {false, std::max(std::min(lower * (1 - 0x1p-18), least_gap(frame)), clearance), {}};
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
Comparison<typename Leaves::Pair> BoxWalk<A, B, Leaves>::compare(A& a, B& b, const RelativePose& b_to_a, double cutoff,
                                                                 double slack, std::optional<Pair> hint)
{
    const double most = cutoff + slack;
    const WalkFrame frame(a, b, b_to_a, most);
    far_ = true;
    if (frame.apart > most) return {1, frame.apart, {}};
    double lower = infinity, upper = infinity;
    std::optional<Pair> witness;
    const auto at_most = [&](double bound) {
        upper = std::min(upper, bound);
        return upper + slack <= cutoff;
    };
    const auto take_pair = [&](Pair pair) {
        witness = pair;
        if (at_most(leaves_.most(pair) + frame.leaf_rounding)) return false;
        const Nearest found = nearest(pair, frame);
        if (at_most(found.upper)) return false;
        if (leaves_.meet(pair)) return upper = 0, false;
        lower = std::min(lower, found.lower);
        return true;
    };
    if (hint && holds(a, hint->a) && holds(b, hint->b)) {
        leaves_.start(a, b, b_to_a);
        if (!take_pair(*hint)) return ++hints_held, Comparison<Pair>{-1, upper, witness};
        lower = upper = infinity; // the result depends on the traversal alone
    }
    start_near(a, b, b_to_a, frame, most);
    bool go_on = true;
    walk(frame.gap_within(most), [&](Entry e) { return go_on = each_pair(e, take_pair); });
    if (!go_on) return {-1, upper, witness};
    lower = std::min(lower, least_box_gap(frame));
    if (lower > most) return {1, lower, {}};
    return {0, std::max(upper, most), {}};
}

} // namespace oncollide
