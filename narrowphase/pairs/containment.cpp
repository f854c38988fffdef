#include <oncollide/narrowphase/pairs/containment.hpp>

#include <algorithm>

#include <oncollide/narrowphase/pairs/pair_worker.hpp>
#include <oncollide/narrowphase/pairs/placed_pair.hpp>
#include <oncollide/narrowphase/walks/box_search.hpp>
#include <oncollide/narrowphase/walks/box_walk_queries.hpp>

namespace oncollide {

namespace {

/// Splitting a mesh of more triangles into its parts would take too long for a first result.
constexpr std::size_t many_triangles = 1 << 17;

/// A box, in the mesh's frame, around all points that can be inside the mesh after their transformation in double.
Aabb box_around(const Mesh& mesh, const RelativePose& into)
{
    Aabb box = mesh.bounds;
    const double far =
        std::max({box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff(), into.translation.stableNorm()});
    const double slack = 0x1p-16 * (box.max - box.min).maxCoeff() + 0x1p-40 * far;
    box.min.array() -= slack, box.max.array() += slack;
    return box;
}

/// False if a part with these points cannot be inside.
bool may_hold(const Aabb& box, const PartPoints& part, const RelativePose& into)
{
    return std::all_of(part.begin(), part.end(), [&](const Eigen::Vector3d& p) {
        const Eigen::Vector3d point = into(p);
        return (point.array() >= box.min.array()).all() && (point.array() <= box.max.array()).all();
    });
}

/// Calls visit(part) for all parts of a body, or their triangles, that may be in a box, until it returns true.
/// @param convex  the solid in the box is convex: few triangles in the box are then outside the solid
void look_in(const Aabb& box, Model& inner, const RelativePose& into_inner, bool convex, auto visit)
{
    if (!convex || !inner.is_mesh() || inner.triangles() < many_triangles || !inner.obb_tree()) {
        inner.any_part(box, into_inner, visit);
        return;
    }
    any_triangle(*inner.obb_tree(), box_moved(box, into_inner), [&](std::uint32_t triangle) {
        const auto [p, q, r] = inner.obb_tree()->corners(triangle);
        return visit(PartPoints{p, q, r, p, q, r});
    });
}

/// True if a box or a hull, as a solid, is certainly apart from all triangles of a large mesh. Looking for triangles
/// inside it takes three times as long.
bool apart_from_large(PairWorker& worker, const PairTask& task)
{
    const bool swapped = task.b->kind() == Kind::polytope;
    Model &solid = swapped ? *task.b : *task.a, &other = swapped ? *task.a : *task.b;
    if (other.kind() != Kind::mesh || other.triangles() < many_triangles || !other.obb_tree() ||
        solid.convex().count > operand::most_points)
        return false;
    const OrderedPair pair(task, swapped);
    const ShapeTree& tree = solid.shape_tree();
    ShapeMeshWalk& walk = worker.walk(tree, *other.obb_tree());
    walk.leaves().prepare(pair.placed.slack, true);
    using Pair = ShapeMeshWalk::Pair;
    bool apart = true;
    walk.meetings(
        tree, *other.obb_tree(), pair.placed.b_to_a, {}, [&](const Pair&) { return apart = false; },
        [](const Pair&) { return false; });
    return apart;
}

} // namespace

bool may_hold(const Model& outer, const Eigen::Isometry3d& pose_outer, const Model& inner,
              const Eigen::Isometry3d& pose_inner)
{
    const RelativePose into(pose_outer, pose_inner);
    const Aabb box = box_around(*outer.surface_mesh(), into);
    return inner.any_part(box, RelativePose(pose_inner, pose_outer),
                          [&](const PartPoints& part) { return may_hold(box, part, into); });
}

std::optional<Eigen::Vector3d> held_point(const PairTask& task, bool outer_is_a, const Mesh& mesh, ObbTree* tree,
                                          PointLocator& locator)
{
    // As in the exact level, B's coordinates are transformed into A's frame.
    const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
    const RelativePose b_to_a(*task.pose_a, *task.pose_b), stay(here, here);
    const Model& outer = outer_is_a ? *task.a : *task.b;
    Model& inner = outer_is_a ? *task.b : *task.a;
    const RelativePose into_outer = outer_is_a ? b_to_a : RelativePose(*task.pose_b, *task.pose_a);
    const Aabb box = box_around(mesh, into_outer);
    const RelativePose into_inner =
        outer_is_a ? RelativePose(*task.pose_b, *task.pose_a) : RelativePose(*task.pose_a, *task.pose_b);
    std::optional<Eigen::Vector3d> held;
    look_in(box, inner, into_inner, outer.kind() == Kind::polytope, [&](const PartPoints& part) {
        if (!may_hold(box, part, into_outer)) return false;
        if (locator.place(outer_is_a ? b_to_a(part[0]) : part[0], mesh, tree, outer_is_a ? stay : b_to_a) ==
            PointLocation::outside)
            return false;
        held = part[0];
        return true;
    });
    return held;
}

std::optional<Eigen::Vector3d> one_holds_the_other(const PairTask& task, PointLocator& locator,
                                                   FunctionRef<ObbTree*(const Model&)> around)
{
    for (const bool outer_is_a : {true, false})
        if (ObbTree* const tree = around(outer_is_a ? *task.a : *task.b))
            if (const auto point = held_point(task, outer_is_a, tree->mesh(), tree, locator))
                return outer_is_a ? *task.pose_b * *point : *task.pose_a * *point;
    return {};
}

bool polytope_holds(PairWorker& worker, const PairTask& task)
{
    if (apart_from_large(worker, task)) return false;
    return one_holds_the_other(
               task, worker.locator,
               [](const Model& model) { return model.kind() == Kind::polytope ? model.obb_tree() : nullptr; })
        .has_value();
}

} // namespace oncollide
