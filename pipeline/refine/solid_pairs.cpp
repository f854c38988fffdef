#include <oncollide/pipeline/refine/solid_pairs.hpp>

#include <algorithm>
#include <concepts>

#include <oncollide/narrowphase/solids/shape_pair.hpp>
#include <oncollide/pipeline/refine/containment_test.hpp>

namespace oncollide {

namespace {

constexpr double rigid = 0x1p-18; ///< poses may be 2^-20 from rigid: so far may distances in A's frame be off

/// How much longer or shorter the pose makes lengths at most, relative; 0 of quarter turns.
double stretch(const Eigen::Isometry3d& pose)
{
    const Eigen::Matrix3d error = pose.linear().transpose() * pose.linear() - Eigen::Matrix3d::Identity();
    if (error.isZero(0) && (pose.linear().array().square() == pose.linear().array().abs()).all()) return 0;
    return 3 * error.cwiseAbs().maxCoeff() + 0x1p-50;
}

bool are_shapes(const PairTask& task)
{
    return task.a->shape() && task.b->shape();
}

/// Two shapes, in A's frame, and by how much its lengths may differ from the world's, relative.
struct PlacedShapes {
    RelativePose b_to_a;
    double slack;
    ShapePair pair;

    explicit PlacedShapes(const PairTask& task)
        : b_to_a(*task.pose_a, *task.pose_b), slack(stretch(*task.pose_a) + stretch(*task.pose_b)),
          pair(*task.a, *task.b, b_to_a, slack)
    {
    }
    double below(double bound) const { return bound * (1 - slack); }
    double above(double bound) const { return bound * (1 + slack); }

    /// Separate beyond the clearance, or near.
    RefineResult by_distance(double clearance, EnoughDistance enough) const
    {
        enough.above = above(above(clearance));
        const ConvexDistance d = pair.distance(enough);
        if (const double lower = below(d.lower); lower > clearance)
            return {Verdict::separate, ContactKind::unknown, lower};
        return {Verdict::within, ContactKind::near, above(d.upper)};
    }
    RefineResult exact(double clearance) const
    {
        const ConvexMeeting m = pair.meeting();
        if (m.sign < 0) return {Verdict::colliding, ContactKind::unknown, 0};
        if (m.sign == 0) return {Verdict::within, ContactKind::unknown, above(m.bound)};
        if (clearance > 0) return by_distance(clearance, {});
        return {Verdict::separate, ContactKind::unknown, below(m.bound)};
    }
};

double radius_of(const Model& model)
{
    return model.shape() ? model.convex().radius : 0;
}

double error_of(const Model& model)
{
    return model.shape() ? model.core().error : 0;
}

/// By which a terrain's heights may be off.
double height_error_of(const Model& model)
{
    return model.terrain() ? model.terrain()->error() : 0;
}

/// What stands around the pair's cores.
struct Margins {
    double radius, error; ///< of both together
    double off;           ///< so far may the cores be from where they should be: heights of terrains
    double slack;         ///< by which a distance may differ from the world's where it is about the radius

    Margins(const PairTask& task)
        : radius(radius_of(*task.a) + radius_of(*task.b)), error(error_of(*task.a) + error_of(*task.b)),
          off(height_error_of(*task.a) + height_error_of(*task.b)),
          slack(radius + off > 0 ? (stretch(*task.pose_a) + stretch(*task.pose_b)) * (radius + off) : 0)
    {
    }
};

/// What a walk's pair remembers, as far as it is of a map and a mesh.
template <class Pair>
std::optional<Pair> hint_of(const PairMemory* memory)
{
    if constexpr (std::same_as<Pair, MapMeshWalk::Pair>)
        if (memory && memory->met) return Pair{memory->cell, memory->triangles.b};
    return {};
}

template <class Pair>
void remember(PairMemory* memory, const std::optional<Pair>& witness)
{
    if constexpr (std::same_as<Pair, MapMeshWalk::Pair>) {
        if (!memory) return;
        memory->met = witness.has_value();
        if (witness) memory->cell = witness->a, memory->triangles.b = witness->b;
    }
}

/// -1: the cores, each with the ball around it, meet; 1: they are apart by the bound.
template <class Walk, class A, class B>
auto compare(Walk& walk, A& a, B& b, const RelativePose& b_to_a, const Margins& margins, PairMemory* memory)
{
    using Pair = typename Walk::Pair;
    Comparison<Pair> c{1, 0, {}};
    if (margins.radius > 0) {
        c = walk.compare(a, b, b_to_a, margins.radius, margins.slack, hint_of<Pair>(memory));
        c.bound -= margins.radius;
        if (c.sign > 0) c.bound -= margins.slack;
    } else {
        c.bound = walk.meetings(
            a, b, b_to_a, hint_of<Pair>(memory), [&](const Pair& pair) { return c.sign = -1, c.witness = pair, false; },
            [](const Pair&) { return false; });
    }
    remember(memory, c.witness);
    return c;
}

/// Separate beyond the clearance, or near.
template <class Walk, class A, class B>
RefineResult by_distance(Walk& walk, A& a, B& b, const RelativePose& b_to_a, const Margins& margins, double clearance)
{
    const double farthest = (clearance + margins.radius + margins.error + margins.off) * (1 + 4 * rigid);
    const auto distance = walk.distance(a, b, b_to_a, 0, farthest);
    const double lower = distance.lower * (1 - rigid) - margins.radius - margins.error - margins.off;
    if (lower > clearance) return {Verdict::separate, ContactKind::unknown, lower};
    const double upper = distance.upper * (1 + rigid) - margins.radius + margins.off;
    return {Verdict::within, ContactKind::near, std::max(upper, 0.0)};
}

/// Where the cores are off: what is no farther apart than that may meet or not.
template <class Walk, class A, class B>
RefineResult decide_off(Walk& walk, A& inner_a, A& outer_a, B& inner_b, B& outer_b, const RelativePose& b_to_a,
                        const Margins& margins, double clearance, auto holds)
{
    const double cutoff = margins.radius + margins.off;
    const auto outer = walk.compare(outer_a, outer_b, b_to_a, cutoff, margins.slack, {});
    if (outer.sign > 0 && holds(inner_a, inner_b)) return {Verdict::colliding, ContactKind::enclosed, 0};
    if (outer.sign > 0 && !holds(outer_a, outer_b)) {
        if (clearance > 0) return by_distance(walk, inner_a, inner_b, b_to_a, margins, clearance);
        const double bound = (outer.bound - cutoff - margins.slack) * (1 - rigid);
        return {Verdict::separate, ContactKind::unknown, std::max(bound, 0x1p-1000)};
    }
    const double upper = std::max(outer.sign > 0 ? 0 : outer.bound - margins.radius, 0.0) + margins.off;
    return {Verdict::within, ContactKind::unknown, (upper + margins.error + margins.slack) * (1 + rigid) + 0x1p-1000};
}

/// @param outer_a, outer_b  hold the shapes; the inner ones are held by them
/// @param holds(a, b)       does the inside of one of the cores hold a part of the other?
template <class Walk, class A, class B>
RefineResult decide(Walk& walk, A& inner_a, A& outer_a, B& inner_b, B& outer_b, const RelativePose& b_to_a,
                    const Margins& margins, double clearance, PairMemory* memory, auto holds)
{
    if (margins.off > 0) return decide_off(walk, inner_a, outer_a, inner_b, outer_b, b_to_a, margins, clearance, holds);
    const auto inner = compare(walk, inner_a, inner_b, b_to_a, margins, memory);
    if (inner.sign < 0) return {Verdict::colliding, ContactKind::unknown, 0};
    if (inner.sign > 0 && holds(inner_a, inner_b)) return {Verdict::colliding, ContactKind::enclosed, 0};
    const bool prisms = &outer_a != &inner_a || &outer_b != &inner_b;
    const auto outer = prisms ? compare(walk, outer_a, outer_b, b_to_a, margins, nullptr) : inner;
    const bool apart = outer.sign > 0 && outer.bound > 0 && !(prisms && holds(outer_a, outer_b));
    if (clearance > 0) {
        const RefineResult near = by_distance(walk, inner_a, inner_b, b_to_a, margins, clearance);
        if (apart || near.verdict == Verdict::within) return near;
    }
    if (apart) return {Verdict::separate, ContactKind::unknown, outer.bound * (1 - rigid)};
    // The outer ones meet, or rounding hides that they do not; nowhere are the shapes farther inside than the error.
    const double upper = (outer.sign == 0 ? std::max(outer.bound, 0.0) + margins.slack : 0) + margins.error;
    return {Verdict::within, ContactKind::unknown, upper * (1 + rigid) + 0x1p-1000};
}

/// Of shapes the outer cores, so that what is separate is.
template <class Walk, class A, class B>
RefineResult decide_near(Walk& walk, A& a, B& b, const RelativePose& b_to_a, const Margins& margins, double clearance,
                         double tolerance, PairMemory* memory, auto holds)
{
    const double out = margins.radius + margins.slack + margins.off;
    const auto found = walk.near(a, b, b_to_a, clearance + out, tolerance, hint_of<typename Walk::Pair>(memory));
    remember(memory, found.witness);
    if (!found.near && !holds(a, b)) {
        const double gap = found.bound - out; // certainly above the clearance, rounding aside
        return {Verdict::separate, ContactKind::unknown, std::max({gap, clearance, 0x1p-1000})};
    }
    const double bound = found.near ? found.bound - margins.radius + margins.off : clearance;
    return {Verdict::within, ContactKind::unknown, std::max(bound, 0.0) + margins.error + margins.slack};
}

bool has_volume(const Model& model)
{
    return model.shape() && model.core().has_volume();
}

ObbTree& inner_of(Model& model)
{
    return *model.boxes;
}

ObbTree& outer_of(Model& model)
{
    return model.outer_boxes ? *model.outer_boxes : *model.boxes;
}

ObbTree& outer_of(Model& model, ObbTree&)
{
    return outer_of(model);
}

TerrainTree& outer_of(Model&, TerrainTree& tree)
{
    return tree;
}

/// What may have an inside.
ObbTree* tree_of(ObbTree& tree)
{
    return &tree;
}

ObbTree* tree_of(TerrainTree&)
{
    return nullptr;
}

/// Is a cell of the map inside the surface, which is moved into the map's frame by `into` and touches no cell?
bool holds_cell(PointLocator& locator, ObbTree& surface, const RelativePose& into, const MapTree& map)
{
    Aabb box;
    for (const Eigen::Vector3d& v : surface.mesh().vertices) box.add(into(v));
    return !map.map().each_cell(box, [&](const MapCell& cell) {
        return locator.place(map.map().box(cell).centre(), surface.mesh(), &surface, into) == PointPlace::outside;
    });
}

} // namespace

bool is_surface(const Model& model)
{
    return model.mesh() || (model.terrain() && model.terrain()->error() == 0);
}

bool is_polytope(const Model& model)
{
    return is_surface(model) || (model.shape() && model.convex().flat_sided && model.convex().radius == 0);
}

bool needs_trees(const Model& a, const Model& b, bool kinds)
{
    return !a.shape() || !b.shape() || (kinds && is_polytope(a) && is_polytope(b));
}

bool SolidPairs::shape_holds(const PairTask& task)
{
    return one_holds_the_other(task, locator_,
                               [&](const Model& model) { return has_volume(model) ? model.boxes.get() : nullptr; });
}

/// @param a, b  of the two, as far as they have an inside
bool SolidPairs::shape_holds(const PairTask& task, ObbTree* a, ObbTree* b)
{
    return one_holds_the_other(task, locator_, [&](const Model& model) -> ObbTree* {
        return !has_volume(model) ? nullptr : &model == task.a ? a : b;
    });
}

/// Calls work(walk, inner_a, outer_a, inner_b, outer_b, b_to_a, holds) with what decides the pair.
RefineResult SolidPairs::with_cores(const PairTask& task, auto work)
{
    if (!task.a->map() && !task.b->map()) {
        const RelativePose b_to_a(*task.pose_a, *task.pose_b);
        return triangles_.with(*task.a, *task.b, [&](auto& walk, auto& a, auto& b) {
            const auto holds = [&](auto& of_a, auto& of_b) { return shape_holds(task, tree_of(of_a), tree_of(of_b)); };
            return work(walk.walk(), a, outer_of(*task.a, a), b, outer_of(*task.b, b), b_to_a, holds);
        });
    }
    // The map's frame, in which its cells are boxes along the axes.
    const bool map_is_a = task.a->map();
    Model &map = map_is_a ? *task.a : *task.b, &other = map_is_a ? *task.b : *task.a;
    const RelativePose other_to_map(map_is_a ? *task.pose_a : *task.pose_b, map_is_a ? *task.pose_b : *task.pose_a);
    MapTree& cells = map.cells();
    const auto never = [](const auto&, const auto&) { return false; }; // cells are solid, so what is in them meets them
    if (other.map()) return work(map_map_, cells, cells, other.cells(), other.cells(), other_to_map, never);
    if (other.terrain()) return work(map_terrain_, cells, cells, other.heights(), other.heights(), other_to_map, never);
    const auto holds = [&](MapTree& tree, ObbTree& surface) {
        return has_volume(other) && !map_mesh_.far_from_all() && holds_cell(locator_, surface, other_to_map, tree);
    };
    return work(map_mesh_, cells, cells, inner_of(other), outer_of(other), other_to_map, holds);
}

RefineResult SolidPairs::exact(const RefineContext& context, const PairTask& task, PairMemory* memory)
{
    if (are_shapes(task)) return PlacedShapes(task).exact(context.settings.clearance);
    return with_cores(task, [&](auto& walk, auto& inner_a, auto& outer_a, auto& inner_b, auto& outer_b,
                                const RelativePose& b_to_a, auto holds) {
        return decide(walk, inner_a, outer_a, inner_b, outer_b, b_to_a, Margins(task), context.settings.clearance,
                      memory, holds);
    });
}

RefineResult SolidPairs::within_clearance(const RefineContext& context, const PairTask& task)
{
    if (are_shapes(task)) return PlacedShapes(task).by_distance(context.settings.clearance, {});
    return with_cores(task, [&](auto& walk, auto& a, auto&, auto& b, auto&, const RelativePose& b_to_a, auto) {
        return by_distance(walk, a, b, b_to_a, Margins(task), context.settings.clearance);
    });
}

RefineResult SolidPairs::near(const RefineContext& context, const PairTask& task, PairMemory* memory, double tolerance)
{
    if (are_shapes(task)) {
        const double clearance = context.settings.clearance;
        RefineResult result = PlacedShapes(task).by_distance(clearance, {.below = clearance + tolerance});
        result.kind = ContactKind::unknown;
        return result;
    }
    return with_cores(
        task, [&](auto& walk, auto&, auto& outer_a, auto&, auto& outer_b, const RelativePose& b_to_a, auto holds) {
            return decide_near(walk, outer_a, outer_b, b_to_a, Margins(task), context.settings.clearance, tolerance,
                               memory, holds);
        });
}

SolidPairs::Counts SolidPairs::counts()
{
    const Traversal::Counts triangles = triangles_.counts();
    return {triangles.box_rows + map_mesh_.box_rows + map_map_.box_rows + map_terrain_.box_rows,
            triangles.triangles + map_mesh_.leaves().tested + map_map_.leaves().tested + map_terrain_.leaves().tested};
}

void SolidPairs::reset_counts()
{
    triangles_.reset_counts();
    map_mesh_.box_rows = map_map_.box_rows = map_terrain_.box_rows = 0;
    map_mesh_.leaves().tested = map_map_.leaves().tested = map_terrain_.leaves().tested = 0;
}

} // namespace oncollide
