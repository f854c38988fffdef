// The traversal that finds the nearest primitives.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include <oncollide/narrowphase/walks/box_walk_queries.hpp>
#include <oncollide/narrowphase/walks/point_search.hpp>

namespace oncollide {

// One function, although it is long: as a class with steps of its own it took 2 to 5 % longer on large meshes.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
DistanceBounds<typename Leaves::Pair> BoxWalk<A, B, Leaves>::distance(A& a, B& b, const RelativePose& b_to_a,
                                                                      double tolerance, double cutoff)
{
    const WalkFrame frame(a, b, b_to_a, cutoff);
    if (frame.apart > cutoff) return {frame.apart, infinity, {}};
    origin_ = frame.origin;
    start(a, b, b_to_a, frame);
    DistanceBounds<Pair> best{infinity, infinity, {}};
    // A meeting is found early. Tests the deepest overlaps first: their triangles are the first nearest pairs.
    const std::uint64_t rows_before = box_rows;
    std::size_t batch = first_batch;
    const auto take_meeting = [&](Pair pair) {
        best = {0, 0, pair};
        return false;
    };
    walk<Gaps::near>(frame.gap_within(0), [&](Entry e) {
        wait(e, [](const Pair&) { return false; });
        return test_if_enough(batch, take_meeting);
    });
    if (best.nearest || !leaves_.meeting(std::span<const Pair>(waiting_), take_meeting)) return best;
    // Projections onto the line through the nearest points show nearly the distance of all primitives near them.
    // Neighbours of the last pair show it on the line of the last pair.
    take_line(WalkLine(b_to_a(b.centre()) - a.centre(), b_to_a));
    WalkLine last_line = line_;
    Eigen::Vector3d near_a, near_b; // the nearest points so far
    double share = 1;               // search for pairs nearer than this share of the distance of the nearest pair
    double most;                    // primitives farther apart do not matter
    float gap_limit;                // boxes with a larger gap do not matter
    const auto narrow_down = [&] {
        const double nearer = std::min(share * best.upper, best.upper - tolerance);
        gap_limit = std::min(frame.gap_within(std::min(nearer, cutoff)), 0x1p90f);
        // Pairs that share the nearest points with the nearest pair are equally near except for rounding.
        most = std::min(nearer - 3 * frame.leaf_rounding, cutoff);
    };
    const auto measure = [&] {
        measure_waiting(frame, [&](const Pair& pair, const Nearest& points) {
            last_line = WalkLine(points.b - points.a, b_to_a);
            best.lower = std::min(best.lower, points.lower);
            if (points.upper >= best.upper || points.lower > cutoff) return;
            best.upper = points.upper, best.nearest = pair;
            near_a = points.a, near_b = points.b;
            take_line(last_line);
        });
        narrow_down();
    };
    const auto parted = [&](double apart) {
        if (apart <= most) return false;
        best.lower = std::min(best.lower, apart);
        return true;
    };
    const auto take_leaves = [&](Entry e) {
        const auto apart = [&](const auto& of_a, const auto& of_b, const WalkLine& line) {
            return low_b(of_b, line) - high_a(of_a, line) - frame.leaf_rounding;
        };
        const auto of_a = a_.primitives(e.slot_a(), e.lane_a());
        const auto of_b = b_.primitives(e.slot_b(), e.lane_b());
        if (parted(apart(of_a, of_b, line_)) || parted(apart(of_a, of_b, last_line))) return;
        each_pair(e, [&](Pair pair) {
            const std::array one_a{pair.a};
            const std::array one_b{pair.b};
            if (!parted(apart(one_a, one_b, line_)) && !parted(apart(one_a, one_b, last_line)))
                waiting_.push_back(pair);
            return true;
        });
        if (waiting_.size() >= (best.nearest ? measured : 1)) measure();
    };
    constexpr bool guesses = requires(Eigen::Vector3d p)
    {
        leaves_.from_a(typename A::Primitive{}, p);
    };
    const bool kept = a_.has_many() || b_.has_many(); // otherwise projections of boxes were compared already
    // Depth first: a heap of all boxes would open half as many, but maintaining it costs more than opening them.
    const auto look = [&](double share_of_nearest) {
        share = share_of_nearest, best.lower = infinity;
        start_again(), narrow_down();
        while (top_) {
            const Entry e = stack_[--top_];
            if (e.gap > gap_limit)
                best.lower = std::min(best.lower, frame.at_least(e.gap));
            else if (both_leaves(e))
                take_leaves(e);
            else if (const float gap = kept ? line_gap(e) : e.gap; gap > gap_limit)
                best.lower = std::min(best.lower, frame.at_least(gap));
            else if (const unsigned count = open<Gaps::far>(e, gap_limit); !guesses)
                sort_last(count);
        }
        measure();
    };
    const auto guess = [&] {
        if constexpr (guesses)
            approach(
                a_, b_, kernel_,
                [&](auto of_a, auto& at) {
                    return leaves_.from_a(of_a, origin_ + Eigen::Vector3d(at[0], at[1], at[2]));
                },
                [&](auto of_b, auto& at) {
                    return leaves_.from_b(of_b, origin_ + Eigen::Vector3d(at[0], at[1], at[2]));
                },
                [&](OpenBox leaf_a, OpenBox leaf_b, bool in_a, float(&at)[3]) {
                    const double before = best.upper;
                    each_pair({leaf_a.slot, leaf_a.lane, leaf_b.slot, leaf_b.lane},
                              [&](Pair pair) { return waiting_.push_back(pair), true; });
                    measure();
                    if (!best.nearest) return false;
                    for (int i = 0; i < 3; ++i) at[i] = static_cast<float>((in_a ? near_a : near_b)[i] - origin_[i]);
                    return best.upper < 0.9999 * before;
                });
    };
    // Pairs in overlapping boxes that did not meet are near. If there are none, a guess finds the line early; between
    // near geometries also a coarse search. Its share is larger for geometries that are far apart: few of their pairs
    // are nearer than that.
    if (waiting_.size() > most_seeds) waiting_.resize(most_seeds);
    measure();
    if (!best.nearest) {
        const std::uint64_t rows = box_rows - rows_before;
        if (rows <= 16 && std::isinf(cutoff)) guess();
        if (rows > 8 || !best.nearest) look(rows > 8 ? 0.5 : 0.85);
    }
    if (best.nearest) look(1); // otherwise the distance is above the cutoff
    best.lower = std::max(std::min(best.lower, least_box_gap(frame)), 0.0);
    return best;
}

} // namespace oncollide
