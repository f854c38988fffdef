// Tests that need no walk: of two shapes, and of a half-space and any body. Included by the table alone.
#pragma once
#include <concepts>
#include <limits>
#include <vector>

#include <oncollide/narrowphase/pairs/half_space.hpp>
#include <oncollide/narrowphase/pairs/pair_memory.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/pair_worker.hpp>
#include <oncollide/narrowphase/pairs/part_solid.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/shapes/convex_pair.hpp>

namespace oncollide::direct_tests {

/// Two bounded shapes.
struct TwoShapes : OrderedPair {
    const ConvexPair pair;

    TwoShapes(const PairTask& task, bool swap)
        : OrderedPair(task, swap), pair(a.convex(), b.convex(), placed.b_to_a, placed.slack)
    {
    }
    ConvexMeeting meeting() const { return pair.meeting(); }
    ConvexDistance distance(const DistanceGoal& goal) const { return pair.distance(goal); }
};

/// A half-space, a, and another body.
template <class Body>
struct OnHalfSpace : OrderedPair {
    OnHalfSpace(const PairTask& task, bool swap) : OrderedPair(task, swap) {}
    HalfSpacePair<Body> pair() const { return HalfSpacePair<Body>(b, placed.b_to_a, placed.slack); }
    ConvexMeeting meeting() const { return pair().meeting(); }
    ConvexDistance distance(const DistanceGoal& goal) const { return pair().distance(goal.cutoff); }
};

/// Bounds the depth of a body in a half-space: the depth of its lowest point, up to rounding.
template <class Body, bool swapped>
Penetration half_space_depth(PairWorker&, const PairTask& task)
{
    const OnHalfSpace<Body> test(task, swapped);
    const auto [lower, upper, lowest] = test.pair().depth();
    const double slack = test.placed.slack;
    Penetration found;
    found.depth = lower * (1 - slack), found.depth_upper = upper * (1 + slack);
    if constexpr (std::same_as<Body, operand::Solid>) {
        found.parting_lower = found.depth, found.parting_upper = found.depth_upper;
        found.parting_along = (swapped ? -1 : 1) * test.pose_a.linear().col(2);
    }
    if (lower > 0) found.deepest = test.pose_a * lowest, found.of_a = swapped;
    return found;
}

/// True if they overlap by a depth that is known; stores it.
template <class Test>
bool overlap(const Test& test, const PairTask& task, PairMemory* memory)
{
    if constexpr (std::same_as<Test, TwoShapes>) {
        const double depth = test.placed.below(test.pair.depth());
        if (memory && depth > 0) memory->meet(depth, task.travel);
        return depth > 0;
    }
    return false;
}

template <class Test>
Finding compare(const Test& test, double clearance, DistanceGoal goal, ContactKind kind)
{
    const PlacedPair& placed = test.placed;
    goal.cutoff = placed.above(placed.above(clearance));
    const ConvexDistance d = test.distance(goal);
    if (const double lower = placed.below(d.lower); lower > clearance)
        return {Verdict::separate, ContactKind::unknown, lower};
    return {Verdict::within, kind, placed.above(d.upper) + bodies_overlap.bound};
}

/// The result for bodies that do not meet: separate if they are farther apart than the clearance, else near.
template <class Test>
Finding by_distance(const Test& test, double clearance)
{
    return compare(test, clearance, {}, ContactKind::near);
}

template <class Test>
Finding decide(const Test& test, double clearance)
{
    const ConvexMeeting m = test.meeting();
    if (m.sign < 0) return {Verdict::colliding, ContactKind::unknown, 0};
    if (m.sign == 0) return {Verdict::within, ContactKind::unknown, test.placed.above(m.bound)};
    const double apart = test.placed.below(m.bound);
    if (apart > clearance || clearance == 0) return {Verdict::separate, ContactKind::unknown, apart};
    return by_distance(test, clearance);
}

template <class Test>
Distance distance(const Test& test, const DistanceOptions& options)
{
    const ConvexDistance d = test.distance({.cutoff = options.cutoff, .tolerance = options.tolerance});
    const double lower = test.placed.below(d.lower);
    return test.in_task(
        {.lower = lower,
         .upper = lower > options.cutoff ? std::numeric_limits<double>::infinity() : test.placed.above(d.upper),
         .point_a = test.pose_a * d.on_a,
         .point_b = test.pose_a * d.on_b});
}

inline Eigen::Vector3d normal_of(const Model& body, const Eigen::Isometry3d& pose, const Eigen::Vector3d& point)
{
    return pose.linear() * outward_normal(body.convex(), pose.inverse(Eigen::Isometry) * point);
}

/// The contact of two shapes, as points on both.
template <class Test>
void contacts(const Test& test, std::vector<Contact>& found, auto normal_a, auto normal_b)
{
    const Verdict verdict = decide(test, 0).verdict;
    if (verdict == Verdict::separate) return;
    const ConvexDistance points = test.distance(nearest_of_all);
    const Eigen::Vector3d point_a = test.pose_a * points.on_a, point_b = test.pose_a * points.on_b;
    const ContactKind kind = verdict == Verdict::colliding ? ContactKind::unknown : ContactKind::near;
    complete(
        found.emplace_back(test.in_task({{}, {}, kind, {point_a, point_b}, normal_a(point_a), normal_b(point_b)})));
}

inline void contacts(const TwoShapes& test, std::vector<Contact>& found)
{
    contacts(
        test, found, [&](const auto& point) { return normal_of(test.a, test.pose_a, point); },
        [&](const auto& point) { return normal_of(test.b, test.pose_b, point); });
}

template <class Body>
void contacts(const OnHalfSpace<Body>& test, std::vector<Contact>& found)
{
    const Eigen::Vector3d up = test.pose_a.linear().col(2);
    const auto normal_a = [&](const Eigen::Vector3d&) { return up; };
    if constexpr (std::same_as<Body, operand::Plane>) {
        contacts(test, found, normal_a, [&](const auto&) -> Eigen::Vector3d { return test.pose_b.linear().col(2); });
    } else if constexpr (std::same_as<Body, operand::Solid>) {
        contacts(test, found, normal_a, [&](const auto& point) { return normal_of(test.b, test.pose_b, point); });
    } else {
        auto& tree = Body::tree(test.b);
        const RelativePose back(test.pose_b, test.pose_a);
        const std::size_t begin = found.size();
        test.pair().each_meeting([&](const BodyPart& part, const Eigen::Vector3d& lowest) {
            const auto primitive = [&] {
                if constexpr (std::same_as<Body, operand::Cells>)
                    return part.cell;
                else
                    return part.triangle;
            }();
            const Eigen::Vector3d point = test.pose_a * lowest;
            found.push_back(test.in_task({{},
                                          source_of(tree, primitive),
                                          ContactKind::unknown,
                                          {point, point},
                                          up,
                                          test.pose_b.linear() * PartSolid(tree, primitive).normal(back(lowest))}));
        });
        sort_by_parts(found, begin);
    }
}

} // namespace oncollide::direct_tests
