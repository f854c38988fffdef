#include <oncollide/pipeline/refine/non_mesh_pairs.hpp>

#include <algorithm>
#include <concepts>
#include <limits>
#include <utility>

#include <oncollide/narrowphase/walks/box_walk_queries.hpp>
#include <oncollide/pipeline/refine/containment_test.hpp>
#include <oncollide/pipeline/refine/part_solid.hpp>
#include <oncollide/pipeline/refine/placed_pair.hpp>

namespace oncollide {

namespace {

constexpr double rigid = 0x1p-18; ///< poses may deviate from rigid by 2^-20, so distances in A's frame have this
                                  ///< relative error
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Hulls with more points are measured by the triangles of their surface: a solid hull scans all its points for each
/// direction.
constexpr std::uint32_t most_points = 1024;

/// True for traversals whose leaf tests may be inconclusive because of rounding.
template <class Walk>
constexpr bool may_leave_open = requires(Walk& walk)
{
    walk.leaves().open_bound();
};

template <class Walk>
void prepare(Walk& walk, double slack, bool open_counts)
{
    if constexpr (may_leave_open<Walk>) walk.leaves().prepare(slack, open_counts);
}

/// Upper bound on the distance of primitives for which rounding leaves the result open.
template <class Walk>
double open_bound(Walk& walk)
{
    if constexpr (may_leave_open<Walk>) return walk.leaves().open_bound();
    return infinity;
}

/// Error bound of the heights of terrains, metres.
double height_error(const PairTask& task)
{
    const auto of = [](const Model& model) { return model.terrain() ? model.terrain()->error() : 0; };
    return of(*task.a) + of(*task.b);
}

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

/// For bodies that do not meet: separate beyond the clearance, or near.
/// @param off  height_error()
template <class Walk, class A, class B>
Finding by_distance(Walk& walk, A& a, B& b, const PlacedPair& placed, double off, double clearance)
{
    prepare(walk, placed.slack, false);
    const auto distance = walk.distance(a, b, placed.b_to_a, 0, (clearance + off) * (1 + 4 * rigid));
    const double lower = distance.lower * (1 - rigid) - off;
    if (lower > clearance) return {Verdict::separate, ContactKind::unknown, lower};
    return {Verdict::within, ContactKind::near, distance.upper * (1 + rigid) + off};
}

/// For inexact heights: parts at most this far apart may or may not meet.
template <class Walk, class A, class B>
Finding decide_off(Walk& walk, A& a, B& b, const PlacedPair& placed, double off, double clearance, auto holds)
{
    prepare(walk, placed.slack, true);
    const double slack = placed.slack * off;
    const auto found = walk.compare(a, b, placed.b_to_a, off, slack, {});
    if (found.sign > 0) {
        if (holds(a, b)) return {Verdict::colliding, ContactKind::enclosed, 0};
        if (clearance > 0) return by_distance(walk, a, b, placed, off, clearance);
        const double bound = (found.bound - off - slack) * (1 - rigid);
        return {Verdict::separate, ContactKind::unknown, std::max(bound, 0x1p-1000)};
    }
    const double upper = std::max(found.bound, 0.0) + off + slack;
    return {Verdict::within, ContactKind::unknown, upper * (1 + rigid) + 0x1p-1000};
}

/// @param holds(a, b)  true if the inside of one body, which leaf tests ignore, contains a part of the other
template <class Walk, class A, class B>
Finding decide(Walk& walk, A& a, B& b, const PlacedPair& placed, double off, double clearance, PairMemory* memory,
               auto holds)
{
    if (off > 0) return decide_off(walk, a, b, placed, off, clearance, holds);
    using Pair = typename Walk::Pair;
    prepare(walk, placed.slack, false);
    std::optional<Pair> met;
    const double gap = walk.meetings(
        a, b, placed.b_to_a, hint_of<Pair>(memory), [&](const Pair& pair) { return met = pair, false; },
        [](const Pair&) { return false; });
    remember(memory, met);
    if (met) return {Verdict::colliding, ContactKind::unknown, 0};
    if (holds(a, b)) return {Verdict::colliding, ContactKind::enclosed, 0};
    const double open = open_bound(walk);
    if (clearance > 0 && open == infinity) return by_distance(walk, a, b, placed, 0, clearance);
    if (open == infinity && gap > 0) return {Verdict::separate, ContactKind::unknown, gap * (1 - rigid)};
    return {Verdict::within, ContactKind::unknown, (open == infinity ? 0 : open) * (1 + rigid) + 0x1p-1000};
}

template <class Walk, class A, class B>
Finding decide_near(Walk& walk, A& a, B& b, const PlacedPair& placed, double off, double clearance, double tolerance,
                    PairMemory* memory, auto holds)
{
    prepare(walk, placed.slack, true);
    const double out = off * (1 + placed.slack);
    const auto found = walk.near(a, b, placed.b_to_a, clearance + out, tolerance, hint_of<typename Walk::Pair>(memory));
    remember(memory, found.witness);
    if (!found.near && !holds(a, b))
        return {Verdict::separate, ContactKind::unknown, std::max({found.bound - out, clearance, 0x1p-1000})};
    return {Verdict::within, ContactKind::unknown, (found.near ? found.bound : clearance) + out};
}

/// The distance in A's frame, from the result of a traversal.
Distance placed_distance(auto& a, auto& b, const PlacedPair& placed, double off, const auto& found)
{
    Distance d{.lower = std::max(found.lower * (1 - placed.slack) - off, 0.0),
               .upper = found.upper * (1 + placed.slack) + off};
    if (!found.nearest) return d;
    d.a = source_of(a, found.nearest->a), d.b = source_of(b, found.nearest->b);
    const PartSolid of_a(a, found.nearest->a), of_b(b, found.nearest->b);
    const ConvexDistance points = ConvexPair(of_a.solid(), of_b.solid(), placed.b_to_a, placed.slack).distance({});
    d.point_a = points.on_a, d.point_b = points.on_b;
    return d;
}

/// The cutoff that a traversal needs.
double farthest_seen(double farthest, double off)
{
    return (farthest + off) * (1 + 4 * rigid);
}

/// Transforms from A's frame to the world and undoes the swap.
Distance in_world(Distance d, const PairTask& task, bool swapped)
{
    const Eigen::Isometry3d& frame = swapped ? *task.pose_b : *task.pose_a;
    d.point_a = frame * d.point_a, d.point_b = frame * d.point_b;
    if (swapped) std::swap(d.point_a, d.point_b), std::swap(d.a, d.b);
    // A triangle of a shape's surface is not a part that users know.
    if (task.a->shape()) d.a = {};
    if (task.b->shape()) d.b = {};
    return d;
}

/// True if a cell of the map is inside the surface, which `into` transforms into the map's frame and which touches no
/// cell.
bool holds_cell(PointLocator& locator, ObbTree& surface, const RelativePose& into, const MapTree& map)
{
    Aabb box;
    for (const Eigen::Vector3d& v : surface.mesh().vertices) box.add(into(v));
    return !MapAccess::each_cell(map.map(), box, [&](const MapCell& cell) {
        return locator.place(MapAccess::box(map.map(), cell).centre(), surface.mesh(), &surface, into) ==
               PointLocation::outside;
    });
}

/// The body in whose frame computations are done: a map, because its cells are axis-aligned there, else a round shape.
Model& placed_first(const PairTask& task)
{
    const auto rank = [](const Model& m) { return m.map() ? 2 : m.shape() && !m.has_triangles() ? 1 : 0; };
    return rank(*task.b) > rank(*task.a) ? *task.b : *task.a;
}

} // namespace

bool is_surface(const Model& model)
{
    return model.is_mesh() || (model.terrain() && model.terrain()->error() == 0);
}

bool is_polytope(const Model& model)
{
    return is_surface(model) || model.has_triangles();
}

bool needs_trees(const Model& a, const Model& b, bool kinds)
{
    return !a.shape() || !b.shape() || (kinds && a.has_triangles() && b.has_triangles());
}

bool NonMeshPairs::shape_holds(const PairTask& task)
{
    if (shape_apart_from_large(task)) return false;
    return one_holds_the_other(task, locator_,
                               [](const Model& model) -> ObbTree* {
                                   return model.shape() && model.has_inside() ? model.obb_tree() : nullptr;
                               })
        .has_value();
}

/// True if a shape, as a solid, is certainly apart from all triangles of a large mesh. Looking for triangles inside the
/// shape takes three times as long.
bool NonMeshPairs::shape_apart_from_large(const PairTask& task)
{
    const bool swapped = task.b->shape();
    Model &shape = swapped ? *task.b : *task.a, &other = swapped ? *task.a : *task.b;
    if (!shape.shape() || !other.is_mesh() || other.triangles() < many_triangles || !other.obb_tree() ||
        shape.convex().count > most_points)
        return false;
    const PlacedPair placed(swapped ? *task.pose_b : *task.pose_a, swapped ? *task.pose_a : *task.pose_b);
    prepare(shape_mesh_, placed.slack, true);
    using Pair = ShapeMeshWalk::Pair;
    bool apart = true;
    shape_mesh_.meetings(
        shape.shape_tree(), *other.obb_tree(), placed.b_to_a, {}, [&](const Pair&) { return apart = false; },
        [](const Pair&) { return false; });
    return apart;
}

/// Calls work(walk, a, b, placed, holds) with the traversal and trees that decide the pair.
auto NonMeshPairs::with_walk(const PairTask& task, auto work)
{
    const auto never = [](const auto&, const auto&) { return false; };
    const bool swapped = &placed_first(task) == task.b;
    Model &a = swapped ? *task.b : *task.a, &b = swapped ? *task.a : *task.b;
    const PlacedPair placed(swapped ? *task.pose_b : *task.pose_a, swapped ? *task.pose_a : *task.pose_b);
    if (a.map() && b.map()) return work(map_map_, a.cells(), b.cells(), placed, never);
    if (a.map() && b.terrain()) return work(map_terrain_, a.cells(), b.heights(), placed, never);
    if (a.map() && !b.has_triangles()) return work(map_shape_, a.cells(), b.shape_tree(), placed, never);
    if (a.map())
        return work(map_mesh_, a.cells(), *b.obb_tree(), placed, [&](MapTree& cells, ObbTree& surface) {
            return b.shape() && !map_mesh_.far_from_all() && holds_cell(locator_, surface, placed.b_to_a, cells);
        });
    if (a.shape() && !a.has_triangles())
        return b.terrain() ? work(shape_terrain_, a.shape_tree(), b.heights(), placed, never)
                           : work(shape_mesh_, a.shape_tree(), *b.obb_tree(), placed, never);
    return triangles_.with(a, b, [&](auto& walk, auto& of_a, auto& of_b) {
        return work(walk.walk(), of_a, of_b, placed, [&](const auto&, const auto&) { return shape_holds(task); });
    });
}

Finding NonMeshPairs::exact(const RefineContext& context, const PairTask& task, PairMemory* memory)
{
    const double clearance = context.settings.clearance;
    if (without_walk(*task.a, *task.b)) return DirectPair(task).exact(clearance);
    return with_walk(task, [&](auto& walk, auto& a, auto& b, const PlacedPair& placed, auto holds) {
        return decide(walk, a, b, placed, height_error(task), clearance, memory, holds);
    });
}

Finding NonMeshPairs::within_clearance(const RefineContext& context, const PairTask& task)
{
    const double clearance = context.settings.clearance;
    if (without_walk(*task.a, *task.b)) return DirectPair(task).by_distance(clearance);
    return with_walk(task, [&](auto& walk, auto& a, auto& b, const PlacedPair& placed, auto) {
        return by_distance(walk, a, b, placed, height_error(task), clearance);
    });
}

Finding NonMeshPairs::near(const RefineContext& context, const PairTask& task, PairMemory* memory, double tolerance)
{
    const double clearance = context.settings.clearance;
    if (without_walk(*task.a, *task.b)) return DirectPair(task).near(clearance, tolerance);
    return with_walk(task, [&](auto& walk, auto& a, auto& b, const PlacedPair& placed, auto holds) {
        return decide_near(walk, a, b, placed, height_error(task), clearance, tolerance, memory, holds);
    });
}

Distance NonMeshPairs::distance(const PairTask& task, double tolerance, double farthest)
{
    if (without_walk(*task.a, *task.b)) return DirectPair(task).distance({.above = farthest, .tolerance = tolerance});
    if (const auto found = solid_distance(task, tolerance, farthest)) return *found;
    return with_walk(task, [&](auto& walk, auto& a, auto& b, const PlacedPair& placed, auto) {
        prepare(walk, placed.slack, false);
        const double off = height_error(task);
        const auto found = walk.distance(a, b, placed.b_to_a, tolerance, farthest_seen(farthest, off));
        return in_world(placed_distance(a, b, placed, off, found), task, &placed_first(task) == task.b);
    });
}

/// For a shape and a mesh or a terrain; empty for other pairs, which need other traversals.
std::optional<Distance> NonMeshPairs::solid_distance(const PairTask& task, double tolerance, double farthest)
{
    const bool swapped = task.b->shape();
    Model &shape = swapped ? *task.b : *task.a, &other = swapped ? *task.a : *task.b;
    if (!shape.shape() || other.map() || shape.convex().count > most_points) return {};
    const PlacedPair placed(swapped ? *task.pose_b : *task.pose_a, swapped ? *task.pose_a : *task.pose_b);
    const double off = height_error(task), seen = farthest_seen(farthest, off);
    const auto by = [&](auto& walk, auto& tree) {
        const auto found = walk.distance(shape.shape_tree(), tree, placed.b_to_a, placed.slack, tolerance, seen);
        return in_world(placed_distance(shape.shape_tree(), tree, placed, off, found), task, swapped);
    };
    return other.terrain() ? by(terrain_distance_, other.heights()) : by(mesh_distance_, *other.obb_tree());
}

NonMeshPairs::Counts NonMeshPairs::counts()
{
    const Traversal::Counts triangles = triangles_.counts();
    Counts sum{triangles.box_rows, triangles.triangles, triangles.hints_held};
    const auto add = [&](auto&... walks) {
        ((sum.box_rows += walks.box_rows, sum.primitives += walks.leaves().tested, sum.hints_held += walks.hints_held),
         ...);
    };
    add(map_mesh_, map_map_, map_terrain_, shape_mesh_, shape_terrain_, map_shape_);
    return sum;
}

void NonMeshPairs::reset_counts()
{
    triangles_.reset_counts();
    const auto reset = [](auto&... walks) {
        ((walks.box_rows = walks.hints_held = 0, walks.leaves().tested = 0), ...);
    };
    reset(map_mesh_, map_map_, map_terrain_, shape_mesh_, shape_terrain_, map_shape_);
}

} // namespace oncollide
