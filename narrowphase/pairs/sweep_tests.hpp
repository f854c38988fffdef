// When two moving bodies first meet, for each two operands (pair_worker.hpp). Included by the table alone.
#pragma once
#include <concepts>
#include <optional>

#include <oncollide/narrowphase/pairs/direct_tests.hpp>
#include <oncollide/narrowphase/pairs/sweep.hpp>
#include <oncollide/narrowphase/pairs/triangle_pairs.hpp>
#include <oncollide/narrowphase/pairs/walk_tests.hpp>
#include <oncollide/narrowphase/walks/careful_entry.hpp>

namespace oncollide::sweep_tests {

inline PairTask middle_of(const SweepTask& task, const MotionWindow& window)
{
    return {0, task.a, task.b, &window.body(true).state.pose, &window.body(false).state.pose};
}

/// The entry with its direction in the world frame, from the task's a to b.
inline PartsEntry in_world(PartsEntry entry, const OrderedPair& pair)
{
    const Eigen::Vector3d direction = pair.pose_a.linear() * entry.direction;
    entry.direction = (pair.swapped ? -1 : 1) * direction.stableNormalized();
    return entry;
}

constexpr auto no_witness = [](const PairTask&, const PairMemory&) -> std::optional<Contact> { return {}; };

/// Two bodies whose hierarchies have a walk.
template <class A, class B, bool swapped>
SweepResult walked(PairWorker& worker, const SweepTask& task)
{
    const auto entry = [&](const MotionWindow& window, PairMemory& memory) {
        const PairTask middle = middle_of(task, window);
        const walk_tests::WalkPair<A, B> p(worker, middle, swapped);
        p.prepare(true);
        SweptMotion motion = window.motion(swapped);
        motion.slack += (task.clearance + p.off) * 2 * walk_tests::rigid + p.off;
        const auto found = p.walk.first_entry(p.tree_a, p.tree_b, p.placed.b_to_a, motion);
        walk_tests::remember(&memory, found.pair);
        return in_world(found, p);
    };
    return sweep(worker, task, entry, no_witness);
}

/// Two bodies with triangles.
template <class A, class B>
SweepResult surfaces(PairWorker& worker, const SweepTask& task)
{
    const auto contact = [](const PairTask& at, const PairMemory& memory) -> std::optional<Contact> {
        if (!memory.met) return {};
        Contact found = contact_of(A::tree(*at.a), *at.pose_a, B::tree(*at.b), *at.pose_b, memory.triangles);
        // A triangle of a shape's surface is not a part that users know.
        if constexpr (std::same_as<A, operand::Polytope>) found.a = {};
        if constexpr (std::same_as<B, operand::Polytope>) found.b = {};
        return found;
    };
    const auto entry = [&](const MotionWindow& window, PairMemory& memory) {
        const PairTask middle = middle_of(task, window);
        const walk_tests::WalkPair<A, B> p(worker, middle, false);
        SweptMotion motion = window.motion(false);
        motion.slack += (task.clearance + p.off) * 2 * walk_tests::rigid + p.off;
        const auto found = p.walk.first_entry(p.tree_a, p.tree_b, p.placed.b_to_a, motion);
        walk_tests::remember(&memory, found.pair);
        return in_world(found, p);
    };
    return sweep(worker, task, entry, contact);
}

inline PartsEntry entry_in(const direct_tests::TwoShapes& test, const SweepTask& task, const MotionWindow& window)
{
    const Convex &a = test.a.convex(), &b = test.b.convex();
    const PlacedPair& placed = test.placed;
    const MovingBody &of_a = window.body(true), &of_b = window.body(false);
    const SweptMotion motion = window.motion(false);
    const auto in_a = [&](const Eigen::Vector3d& point) {
        return Eigen::Vector3d(test.pose_a.linear().transpose() * (point - test.pose_a.translation()));
    };
    const double size = a.extent + a.radius + b.extent + b.radius;
    SweptParts parts{motion.b.at(in_a(of_b.centre)) - motion.a.at(in_a(of_a.centre)), motion.slack};
    parts.slack += motion.a.turn.norm() * of_a.radius + motion.b.turn.norm() * of_b.radius +
                   task.clearance * 2 * placed.slack + (motion.touch.careful ? 0x1p-48 : 0x1p-40) * parts.speed.norm() -
                   motion.touch.depth;
    const double rounding = 0x1p-46 * (size + placed.b_to_a.translation.norm()) + placed.slack * size;
    const auto apart = [&](const Eigen::Vector3d& direction) {
        const Eigen::Vector3d in_b = placed.b_to_a.rotation.transpose() * direction;
        return direction.dot(placed.b_to_a.translation) - b.most_along(-in_b) - a.most_along(direction) - rounding;
    };
    const auto lifted = [&](double time, const Eigen::Vector3d& lift) {
        RelativePose there = placed.b_to_a;
        there.translation += time * parts.speed + lift;
        const ConvexDistance d = ConvexPair(a, b, there, placed.slack).distance({});
        return Eigen::Vector3d(d.on_b - d.on_a);
    };
    const auto between = [&](double time) { return lifted(time, Eigen::Vector3d::Zero()); };
    Eigen::Vector3d line = Eigen::Vector3d::Zero();
    if (motion.touch.careful) {
        const std::pair<double, double> scales = std::minmax<double>(a.extent + a.radius, b.extent + b.radius);
        return careful_entry(parts, -1, after_window, line, scales, apart, lifted);
    }
    return first_entry(parts, -1, after_window, line, apart, between);
}

/// A half-space and another body. The entry follows from the body's height at the beginning of the window. The height
/// changes by the motion along the normal of the body's centre relative to the half-space, and by the relative
/// rotation.
template <class Body>
PartsEntry entry_in(const direct_tests::OnHalfSpace<Body>& test, const SweepTask& task, const MotionWindow& window)
{
    const Eigen::Isometry3d pose_a = task.motion_a->pose(window.begin()), pose_b = task.motion_b->pose(window.begin());
    const direct_tests::OnHalfSpace<Body> first({0, task.a, task.b, &pose_a, &pose_b}, test.swapped);
    const SweptMotion motion = window.motion(test.swapped);
    double height = first.placed.below(first.distance({}).lower) - task.clearance * (1 + 4 * walk_tests::rigid);
    if (motion.touch.depth > 0) height += motion.touch.depth - first.pair().depth().upper * (1 + first.placed.slack);
    const MovingBody& body = window.body(test.swapped);
    const Eigen::Vector3d centre = test.pose_a.linear().transpose() * (body.centre - test.pose_a.translation());
    const Eigen::Vector3d of_plane = motion.a.at(centre), of_body = motion.b.at(centre), speed = of_body - of_plane;
    const double turn_a = motion.a.turn.norm(), turn_b = motion.b.turn.norm();
    // Two half-spaces, of which one rotates, meet far away.
    const bool at_once = std::same_as<Body, operand::Plane> && turn_a + turn_b > 0;
    if (!(height > 0) || at_once) return {-1, -1, {0, 0, 1}};
    const double turn = (motion.b.turn - motion.a.turn).norm() + 0x1p-50 * (turn_a + turn_b);
    // Upper bound of the changes of the speeds, of the normal and of the centre's place in the window, in all.
    const double bent = (turn_a + turn_b) * (2 * speed.norm() + of_plane.norm() + of_body.norm()) + motion.slack -
                        task.clearance + turn * turn_b * body.radius;
    const double fall = -speed.z() * (1 + 0x1p-30) + turn * body.radius + bent * (1 + 0x1p-10);
    if (!std::isfinite(fall)) return {-1, -1, {0, 0, 1}};
    if (!(height <= 2 * fall)) return {};
    return {
        -1 + height / fall * (1 - 0x1p-40), speed.z() < 0 ? std::min(-1 - height / speed.z(), 1.0) : 1.0, {0, 0, 1}};
}

/// Bodies that need no walk. `Test` is one of direct_tests.hpp.
template <class Test, bool swapped>
SweepResult direct(PairWorker& worker, const SweepTask& task)
{
    const auto entry = [&](const MotionWindow& window, PairMemory&) {
        const Test test(middle_of(task, window), swapped);
        return in_world(entry_in(test, task, window), test);
    };
    return sweep(worker, task, entry, no_witness);
}

} // namespace oncollide::sweep_tests
