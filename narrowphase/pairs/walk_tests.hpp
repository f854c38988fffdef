// Tests of two bodies by a walk of their hierarchies, for each two operands (pair_worker.hpp) that a PairWorker has a
// walk for. Only the table includes this header, and makes functions of the templates.
#pragma once
#include <algorithm>
#include <concepts>
#include <optional>
#include <utility>
#include <vector>

#include <oncollide/base/numbers/infinity.hpp>
#include <oncollide/narrowphase/pairs/containment.hpp>
#include <oncollide/narrowphase/pairs/pair_tests.hpp>
#include <oncollide/narrowphase/pairs/pair_worker.hpp>
#include <oncollide/narrowphase/pairs/part_solid.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/walks/box_walk_queries.hpp>

namespace oncollide::walk_tests {

constexpr double rigid = 0x1p-18; ///< poses may deviate from rigid by 2^-20, so distances in A's frame have this
                                  ///< relative error

/// True for traversals whose leaf tests may be inconclusive because of rounding.
template <class Walk>
constexpr bool may_leave_open = requires(Walk& walk)
{
    walk.leaves().open_bound();
};

/// Witnesses are kept only for pairs of primitives where at most the first is a cell.
template <class Pair>
constexpr bool has_hint = std::same_as<decltype(Pair::b), std::uint32_t>;
template <class Pair>
constexpr bool has_cell = std::same_as<decltype(Pair::a), MapCell>;

template <class Pair>
std::optional<Pair> hint_of(const PairMemory* memory)
{
    if constexpr (has_hint<Pair>) {
        if (!memory || !memory->met) return {};
        if constexpr (has_cell<Pair>) {
            const auto* cell = std::get_if<MapCell>(&memory->place);
            return cell ? std::optional(Pair{*cell, memory->triangles.b}) : std::nullopt;
        } else {
            return Pair{memory->triangles.a, memory->triangles.b};
        }
    }
    return {};
}

template <class Pair>
void remember(PairMemory* memory, const std::optional<Pair>& witness)
{
    if constexpr (has_hint<Pair>) {
        if (!memory) return;
        memory->met = witness.has_value();
        if (!witness) return;
        if constexpr (has_cell<Pair>)
            memory->place = witness->a;
        else
            memory->triangles.a = witness->a;
        memory->triangles.b = witness->b;
    }
}

/// True if a cell of the map is inside the surface, which `into` transforms into the map's frame and which touches no
/// cell.
inline bool holds_cell(PointLocator& locator, ObbTree& surface, const RelativePose& into, const MapTree& map)
{
    Aabb box;
    for (const Eigen::Vector3d& v : surface.mesh().vertices) box.add(into(v));
    return !MapAccess::each_cell(map.map(), box, [&](const MapCell& cell) {
        return locator.place(MapAccess::box(map.map(), cell).centre(), surface.mesh(), &surface, into) ==
               PointLocation::outside;
    });
}

/// A pair with its hierarchies and their walk.
template <class A, class B>
struct WalkPair : OrderedPair {
    PairWorker& worker;
    const PairTask& task;
    decltype(A::tree(std::declval<Model&>())) tree_a;
    decltype(B::tree(std::declval<Model&>())) tree_b;
    decltype(std::declval<PairWorker&>().walk(tree_a, tree_b)) walk;
    double off; ///< error bound of the heights of terrains, metres
    using Pair = typename std::remove_reference_t<decltype(walk)>::Pair;

    WalkPair(PairWorker& memory, const PairTask& pair, bool swap)
        : OrderedPair(pair, swap), worker(memory), task(pair), tree_a(A::tree(a)), tree_b(B::tree(b)),
          walk(worker.walk(tree_a, tree_b)), off(A::error(a) + B::error(b))
    {
    }
    /// @param open_counts  true: pairs of primitives that rounding leaves undecided count as meeting
    void prepare(bool open_counts) const
    {
        if constexpr (may_leave_open<decltype(walk)>) walk.leaves().prepare(placed.slack, open_counts);
    }
    /// Upper bound on the distance of primitives for which rounding leaves the result open.
    double open_bound() const
    {
        if constexpr (may_leave_open<decltype(walk)>) return walk.leaves().open_bound();
        return infinity;
    }
    /// True if the inside of a box or a hull, which leaf tests ignore, contains a part of the other body. Requires that
    /// the walk found no meeting.
    bool holds() const
    {
        constexpr bool of_a = std::same_as<A, operand::Polytope>, of_b = std::same_as<B, operand::Polytope>;
        if constexpr (std::same_as<A, operand::Cells> && of_b)
            return !walk.far_from_all() && holds_cell(worker.locator, tree_b, placed.b_to_a, tree_a);
        else if constexpr (of_a || of_b)
            return polytope_holds(worker, task);
        else
            return false;
    }
    /// The cutoff of a traversal for primitives of bodies up to this distance apart, metres.
    double cutoff(double distance) const { return (distance + off) * (1 + 4 * rigid); }
};

/// The pair as its decisions and distances take it. Two bodies of one model are taken in the other order: both orders
/// would be correct, but the bits of the results depend on the order.
template <class A, class B>
WalkPair<A, B> walk_pair(PairWorker& worker, const PairTask& task, bool swap)
{
    return {worker, task, swap || task.a == task.b};
}

/// The result for bodies that do not meet: separate if they are farther apart than the clearance, else near.
template <class A, class B>
Finding by_distance(const WalkPair<A, B>& p, double clearance)
{
    p.prepare(false);
    const auto distance = p.walk.distance(p.tree_a, p.tree_b, p.placed.b_to_a, 0, p.cutoff(clearance));
    const double lower = distance.lower * (1 - rigid) - p.off;
    if (lower > clearance) return {Verdict::separate, ContactKind::unknown, lower};
    return {Verdict::within, ContactKind::near, distance.upper * (1 + rigid) + p.off};
}

/// For inexact heights: parts at most this far apart may or may not meet.
template <class A, class B>
Finding decide_off(const WalkPair<A, B>& p, double clearance)
{
    p.prepare(true);
    const double slack = p.placed.slack * p.off;
    const auto found = p.walk.compare(p.tree_a, p.tree_b, p.placed.b_to_a, p.off, slack, {});
    if (found.sign > 0) {
        if (p.holds()) return {Verdict::colliding, ContactKind::enclosed, 0};
        if (clearance > 0) return by_distance(p, clearance);
        const double bound = (found.bound - p.off - slack) * (1 - rigid);
        return {Verdict::separate, ContactKind::unknown, std::max(bound, 0x1p-1000)};
    }
    const double upper = std::max(found.bound, 0.0) + p.off + slack;
    return {Verdict::within, ContactKind::unknown, upper * (1 + rigid) + 0x1p-1000};
}

template <class A, class B>
Finding decide(const WalkPair<A, B>& p, double clearance, PairMemory* memory)
{
    using Pair = typename WalkPair<A, B>::Pair;
    if (p.off > 0) return decide_off(p, clearance);
    p.prepare(false);
    std::optional<Pair> met;
    const double gap = p.walk.meetings(
        p.tree_a, p.tree_b, p.placed.b_to_a, hint_of<Pair>(memory), [&](const Pair& pair) { return met = pair, false; },
        [](const Pair&) { return false; });
    remember(memory, met);
    if (met) return {Verdict::colliding, ContactKind::unknown, 0};
    if (p.holds()) return {Verdict::colliding, ContactKind::enclosed, 0};
    const double open = p.open_bound();
    if (clearance > 0 && open == infinity) return by_distance(p, clearance);
    if (open == infinity && gap > 0) return {Verdict::separate, ContactKind::unknown, gap * (1 - rigid)};
    return {Verdict::within, ContactKind::unknown, (open == infinity ? 0 : open) * (1 + rigid) + 0x1p-1000};
}

template <class A, class B>
Finding near(const WalkPair<A, B>& p, double clearance, double tolerance, PairMemory* memory)
{
    using Pair = typename WalkPair<A, B>::Pair;
    p.prepare(true);
    const double out = p.off * (1 + p.placed.slack);
    const auto found =
        p.walk.near(p.tree_a, p.tree_b, p.placed.b_to_a, clearance + out, tolerance, hint_of<Pair>(memory));
    remember(memory, found.witness);
    if (!found.near && !p.holds())
        return {Verdict::separate, ContactKind::unknown, std::max({found.bound - out, clearance, 0x1p-1000})};
    return {Verdict::within, ContactKind::unknown, (found.near ? found.bound : clearance) + out};
}

/// The distance in the world frame, from the result of a traversal.
template <class A, class B>
Distance distance_of(const OrderedPair& p, auto& tree_a, auto& tree_b, double off, const auto& found)
{
    const PlacedPair& placed = p.placed;
    Distance d{.lower = std::max(found.lower * (1 - placed.slack) - off, 0.0),
               .upper = found.upper * (1 + placed.slack) + off};
    if (found.nearest) {
        d.a = source_of(tree_a, found.nearest->a), d.b = source_of(tree_b, found.nearest->b);
        const PartSolid of_a(tree_a, found.nearest->a), of_b(tree_b, found.nearest->b);
        const ConvexDistance points = ConvexPair(of_a.solid(), of_b.solid(), placed.b_to_a, placed.slack).distance({});
        d.point_a = points.on_a, d.point_b = points.on_b;
    }
    d.point_a = p.pose_a * d.point_a, d.point_b = p.pose_a * d.point_b;
    // A triangle of a shape's surface is not a part that users know.
    if constexpr (std::same_as<A, operand::Polytope>) d.a = {};
    if constexpr (std::same_as<B, operand::Polytope>) d.b = {};
    return p.in_task(d);
}

template <class A, class B>
Distance distance(const WalkPair<A, B>& p, const DistanceOptions& options)
{
    p.prepare(false);
    const auto found =
        p.walk.distance(p.tree_a, p.tree_b, p.placed.b_to_a, options.tolerance, p.cutoff(options.cutoff));
    return distance_of<A, B>(p, p.tree_a, p.tree_b, p.off, found);
}

/// The distance of a shape, A, as a solid from the triangles of a mesh or a terrain.
template <class B>
Distance solid_distance(PairWorker& worker, const OrderedPair& p, const DistanceOptions& options)
{
    const ShapeTree& tree_a = p.a.shape_tree();
    auto& tree_b = B::tree(p.b);
    const double off = B::error(p.b), cutoff = (options.cutoff + off) * (1 + 4 * rigid);
    const auto found = worker.solid_distance(tree_b).distance(tree_a, tree_b, p.placed.b_to_a, p.placed.slack,
                                                              options.tolerance, cutoff);
    return distance_of<operand::Solid, B>(p, tree_a, tree_b, off, found);
}

/// Appends contacts.
template <class A, class B>
void contacts(const WalkPair<A, B>& p, std::vector<Contact>& found)
{
    using Pair = typename WalkPair<A, B>::Pair;
    constexpr bool may_be_near = may_leave_open<decltype(p.walk)>;
    p.prepare(true);
    std::vector<Pair> pairs;
    p.walk.meetings(
        p.tree_a, p.tree_b, p.placed.b_to_a, {}, [&](const Pair& pair) { return pairs.push_back(pair), true; },
        [](const Pair&) { return false; });
    const RelativePose a_to_b(p.pose_b, p.pose_a);
    const std::size_t begin = found.size();
    for (const Pair& pair : pairs) {
        const PartSolid of_a(p.tree_a, pair.a), of_b(p.tree_b, pair.b);
        const ConvexDistance points =
            ConvexPair(of_a.solid(), of_b.solid(), p.placed.b_to_a, p.placed.slack).distance(nearest_of_all);
        Contact c{source_of(p.tree_a, pair.a),
                  source_of(p.tree_b, pair.b),
                  ContactKind::unknown,
                  {p.pose_a * points.on_a, p.pose_a * points.on_b},
                  p.pose_a.linear() * of_a.normal(points.on_a),
                  p.pose_b.linear() * of_b.normal(a_to_b(points.on_b))};
        if constexpr (may_be_near)
            if (!p.walk.leaves().certainly_meet(pair)) c.kind = ContactKind::near;
        complete(found.emplace_back(p.in_task(c)));
    }
    sort_by_parts(found, begin);
}

/// The distance that was found of two surfaces; 0 if one body encloses a part of the other.
/// @param solid  as for PairTests::distance
inline Distance with_insides(const Distance& found, PairWorker& worker, const PairTask& task, bool solid)
{
    if (found.lower == 0) return found;
    const auto around = [&](const Model& model) {
        const bool bounds_inside = model.kind() == Kind::polytope || (solid && model.closed());
        return bounds_inside ? model.obb_tree() : nullptr;
    };
    if (const auto inside = one_holds_the_other(task, worker.locator, around))
        return {.lower = 0, .upper = 0, .point_a = *inside, .point_b = *inside};
    return found;
}

} // namespace oncollide::walk_tests
