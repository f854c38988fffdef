#include <oncollide/narrowphase/boxes/traversal.hpp>

#include <algorithm>
#include <limits>

#include <oncollide/narrowphase/boxes/traversal_steps.hpp>
#include <oncollide/narrowphase/exact/triangle_distance.hpp>

namespace oncollide {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

} // namespace

Traversal::Nearness Traversal::near(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, double clearance,
                                    double tolerance, std::optional<TrianglePair> hint)
{
    const Query query(a, b, b_to_a);
    // Poses may be 2^-20 from rigid: so far may a distance in A's frame be from that in the world.
    const double rounding = query.triangle_rounding + 0x1p-18 * clearance;
    Nearness answer{false, clearance + std::max(tolerance, 2 * rounding), {}};
    const double enough = answer.bound - rounding;
    if (query.apart > clearance) return {false, query.apart, {}};
    const auto take = [&](TrianglePair pair) {
        answer.near = true, answer.meeting = pair;
        return false;
    };
    if (hint) {
        waiting_.assign(1, *hint);
        if (!test_waiting(query, take)) return answer;
    }
    double lower = infinity; // of triangles that do not wait
    const auto take_pair = [&](TrianglePair pair, bool small) {
        if (small || clearance > 0) {
            const TrianglePoints of_a = query.points_a(pair.a), of_b = query.points_b(pair.b);
            answer.near = corner_distance(of_a, of_b) <= enough;
            if (answer.near) return false;
            if (clearance > 0) {
                ++counts_.triangles;
                const double distance = triangle_distance(of_a, of_b);
                answer.near = distance - rounding <= clearance || triangles_meet(of_a, of_b);
                lower = std::min(lower, distance - rounding);
                return !answer.near;
            }
        }
        waiting_.push_back(pair);
        return true;
    };
    std::size_t batch = first_batch;
    const double reach = (clearance + query.rounding) * (1 + 0x1p-20);
    walk(query, static_cast<float>(reach), [&](const Entry& e) {
        const float size2 = a_[e.a].size(e.lane_a) + b_[e.b].size(e.lane_b);
        const bool small = double(size2) <= 16 * enough * enough; // else their corners are hardly so near
        return each_pair(e, [&](TrianglePair pair) { return take_pair(pair, small); }) &&
               test_if_enough(query, batch, take);
    });
    if (answer.near || !test_waiting(query, take)) return answer;
    return {false, std::max(std::min(lower * (1 - 0x1p-18), least_gap(query)), clearance), {}};
}

Traversal::Distance Traversal::distance(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, double tolerance,
                                        double farthest)
{
    const Query query(a, b, b_to_a);
    if (query.apart > farthest) return {query.apart, infinity, {}};
    Distance best{infinity, infinity, {}};
    const auto take_pair = [&](TrianglePair pair) {
        const TrianglePoints of_a = query.points_a(pair.a), of_b = query.points_b(pair.b);
        ++counts_.triangles;
        if (triangles_meet(of_a, of_b)) {
            best = {0, 0, pair};
            return false;
        }
        const double distance = triangle_distance(of_a, of_b), lower = distance - query.triangle_rounding;
        const double upper = distance + query.triangle_rounding;
        best.lower = std::min(best.lower, lower);
        if (upper < best.upper && lower <= farthest) best.upper = upper, best.nearest = pair;
        return true;
    };
    const auto farther = [](const Entry& x, const Entry& y) { return x.gap > y.gap; };
    start(query);
    while (top_) {
        const Entry e = stack_[0]; // of a heap: the least gap
        const double reach = std::min(std::min(best.upper - tolerance, farthest) + query.rounding, 0x1p90);
        if (e.gap > reach) {
            best.lower = std::min(best.lower, e.gap - query.rounding);
            break;
        }
        std::pop_heap(stack_.data(), stack_.data() + top_--, farther);
        if (both_leaves(e)) {
            if (!each_pair(e, take_pair)) return best;
            continue;
        }
        for (unsigned added = open<true>(e, static_cast<float>(reach)); added-- > 0;)
            std::push_heap(stack_.data(), stack_.data() + top_ - added, farther);
    }
    for (float gap : nearest_) best.lower = std::min(best.lower, double(gap) - query.rounding);
    best.lower = std::max(best.lower, 0.0);
    return best;
}

} // namespace oncollide
