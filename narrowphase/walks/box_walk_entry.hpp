// The traversal that finds when two hierarchies first meet during a motion.
#pragma once
#include <oncollide/narrowphase/walks/box_walk_queries.hpp>
#include <oncollide/narrowphase/walks/careful_entry.hpp>

namespace oncollide {

/// Sets the motion of the parts of one box relative to the other box.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
void BoxWalk<A, B, Leaves>::set_motion(BoxMotion& motion, Entry e, bool down_a) const
{
    const SweptSide &mine = down_a ? swept_.a : swept_.b, &others = down_a ? swept_.b : swept_.a;
    const OpenBoxes& other = down_a ? b_[e.slot_b()].boxes : a_[e.slot_a()].boxes;
    const unsigned k = down_a ? e.lane_b() : e.lane_a();
    const Eigen::Vector3d centre(other.c[0][k], other.c[1][k], other.c[2][k]), base = mine.shift - others.at(centre);
    for (int i = 0; i < 3; ++i)
        motion.base[i] = static_cast<float>(base[i]), motion.turn[i] = static_cast<float>(mine.turn[i]);
    const double turn = down_a ? turn_a_ : turn_b_, other_turn = down_a ? turn_b_ : turn_a_;
    motion.turn_length = static_cast<float>(turn * (1 + 0x1p-20));
    motion.slack = static_cast<float>((swept_.slack + other_turn * std::sqrt(double(other.size[k])) * (1 + 0x1p-10)) *
                                          (1 + 0x1p-20) +
                                      0x1p-20 * (base.norm() + other_turn * centre.norm()) + box_rounding_);
}

/// The relative motion of the contents of two boxes.
template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
SweptParts BoxWalk<A, B, Leaves>::motion_of(Entry e) const
{
    const auto side = [](const SweptSide& motion, double turn, const OpenBoxes& boxes, unsigned k,
                         Eigen::Vector3d& speed) {
        speed = motion.at({boxes.c[0][k], boxes.c[1][k], boxes.c[2][k]});
        return turn * (std::sqrt(double(boxes.size[k])) * (1 + 0x1p-10) + boxes.margin);
    };
    Eigen::Vector3d of_a, of_b;
    const double slack_a = side(swept_.a, turn_a_, a_[e.slot_a()].boxes, e.lane_a(), of_a);
    const double slack_b = side(swept_.b, turn_b_, b_[e.slot_b()].boxes, e.lane_b(), of_b);
    const double rounding = (swept_.touch.careful ? 0x1p-48 : 0x1p-40) * (of_a.norm() + of_b.norm());
    return {of_b - of_a, swept_.slack + slack_a + slack_b + rounding - swept_.touch.depth};
}

template <BoxHierarchy A, BoxHierarchy B, LeafTests<A, B> Leaves>
FirstEntry<typename Leaves::Pair> BoxWalk<A, B, Leaves>::first_entry(A& a, B& b, const RelativePose& b_to_a,
                                                                     const SweptMotion& motion)
{
    const WalkFrame frame(a, b, b_to_a, infinity);
    origin_ = frame.origin;
    const auto moved = [&](const SweptSide& side) { return SweptSide{side.at(origin_), side.turn}; };
    swept_ = {moved(motion.a), moved(motion.b), motion.slack, motion.touch}, box_rounding_ = frame.box_rounding;
    turn_a_ = motion.a.turn.norm(), turn_b_ = motion.b.turn.norm();
    FirstEntry<Pair> best;
    const SweptParts all{motion.b.at(b_to_a(b.centre())) - motion.a.at(a.centre()), 0};
    const double reach = all.speed.norm() * (1 + 0x1p-20) + motion.slack + motion.a.turn.norm() * a.radius() * 1.01 +
                         motion.b.turn.norm() * b.radius() * 1.01;
    if (frame.apart > reach) return best;
    start(a, b, b_to_a, frame);
    stack_[top_ - 1].gap = -1;
    take_line(WalkLine(b_to_a(b.centre()) - a.centre(), b_to_a));
    Eigen::Vector3d separating = line_.in_a;
    RelativePose there = b_to_a; // the leaf tests keep a reference
    // The general bound suffices for distances, too. Projections err by a few roundings of the coordinates, the
    // relative pose by as much.
    const auto coordinates = [&] {
        return a.centre().norm() + a.radius() + b.centre().norm() + b.radius() + b_to_a.translation.norm();
    };
    const double rounding = motion.touch.careful ? 0x1p-46 * coordinates() : frame.leaf_rounding;
    const auto scales_of = [&](Entry e) -> std::pair<double, double> {
        return std::minmax<double>(std::sqrt(double(a_[e.slot_a()].boxes.size[e.lane_a()])),
                                   std::sqrt(double(b_[e.slot_b()].boxes.size[e.lane_b()])));
    };
    const auto take_pair = [&](const Pair& pair, const SweptParts& parts, double from,
                               const std::pair<double, double>& scales) {
        const auto apart = [&](const Eigen::Vector3d& direction) {
            WalkLine line(direction, b_to_a);
            return low_b(std::array{pair.b}, line) - high_a(std::array{pair.a}, line) - rounding;
        };
        const auto lifted = [&](double time, const Eigen::Vector3d& lift) {
            there.translation = b_to_a.translation + time * parts.speed + lift;
            leaves_.start(a, b, there);
            const Nearest points = nearest(pair, frame);
            return Eigen::Vector3d(points.b - points.a);
        };
        const auto between = [&](double time) { return lifted(time, Eigen::Vector3d::Zero()); };
        const PartsEntry entry = motion.touch.careful
                                     ? careful_entry(parts, from, best.time, separating, scales, apart, lifted)
                                     : oncollide::first_entry(parts, from, best.time, separating, apart, between);
        if (entry.time >= best.time) return;
        best.time = entry.time, best.likely = entry.likely, best.direction = entry.direction, best.pair = pair;
        if (!entry.direction.isZero(0)) separating = entry.direction;
    };
    while (top_ && best.time > -1) {
        const Entry e = stack_[--top_];
        if (e.gap >= best.time) continue;
        if (!both_leaves(e)) {
            sort_last(open<Gaps::in_time>(e, static_cast<float>(std::min(best.time, 1.0))));
            continue;
        }
        const SweptParts parts = motion_of(e);
        const auto scales = motion.touch.careful ? scales_of(e) : std::pair(0.0, 0.0);
        each_pair(e, [&](const Pair& pair) {
            take_pair(pair, parts, std::max(-1.0, double(e.gap)), scales);
            return best.time > -1;
        });
    }
    return best;
}

} // namespace oncollide
