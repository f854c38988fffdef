#include <oncollide/pipeline/refine/containment_test.hpp>

#include <algorithm>

#include <oncollide/base/parallel.hpp>
#include <oncollide/narrowphase/walks/box_search.hpp>

namespace oncollide {

namespace {

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

bool may_hold(const Model& outer, const Eigen::Isometry3d& pose_outer, const Model& inner,
              const Eigen::Isometry3d& pose_inner)
{
    const RelativePose into(pose_outer, pose_inner);
    const Aabb box = box_around(*outer.surface_mesh(), into);
    return inner.any_part(box, RelativePose(pose_inner, pose_outer),
                          [&](const PartPoints& part) { return may_hold(box, part, into); });
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

/// A point of the inner body inside the mesh, in the inner body's frame.
/// @param tree  of the mesh; null: test all triangles
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
    look_in(box, inner, into_inner, outer.shape() != nullptr, [&](const PartPoints& part) {
        if (!may_hold(box, part, into_outer)) return false;
        if (locator.place(outer_is_a ? b_to_a(part[0]) : part[0], mesh, tree, outer_is_a ? stay : b_to_a) ==
            PointLocation::outside)
            return false;
        held = part[0];
        return true;
    });
    return held;
}

} // namespace

std::optional<Eigen::Vector3d> one_holds_the_other(const PairTask& task, PointLocator& locator,
                                                   FunctionRef<ObbTree*(const Model&)> around)
{
    for (const bool outer_is_a : {true, false})
        if (ObbTree* const tree = around(outer_is_a ? *task.a : *task.b))
            if (const auto point = held_point(task, outer_is_a, tree->mesh(), tree, locator))
                return outer_is_a ? *task.pose_b * *point : *task.pose_a * *point;
    return {};
}

void ContainmentTest::find(const RefineContext& context, std::span<const PairTask> tasks,
                           std::span<const std::uint8_t> apart, std::span<Finding> results)
{
    if (context.settings.mode != Mode::solid) return;
    gather(context, tasks, apart);
    if (queries_.empty()) return;
    {
        const auto lock = context.changing();
        for (Query& query : queries_) {
            Model& outer = query.outer_is_a ? *tasks[query.task].a : *tasks[query.task].b;
            query.tree = models_.admit_obb_tree(outer, context.frame) ? outer.obb_tree() : nullptr;
        }
    }
    locators_.resize(static_cast<std::size_t>(std::max(context.threads, 1)));
    parallel_chunks(queries_.size(), 4, context.threads, [&](std::size_t begin, std::size_t end, int thread) {
        for (Query& query : std::span(queries_).subspan(begin, end - begin)) {
            const PairTask& task = tasks[query.task];
            const Model& outer = query.outer_is_a ? *task.a : *task.b;
            query.holds = held_point(task, query.outer_is_a, *outer.surface_mesh(), query.tree,
                                     locators_[static_cast<std::size_t>(thread)])
                              .has_value();
        }
    });
    for (const Query& query : queries_)
        if (query.holds) results[query.task] = {Verdict::colliding, ContactKind::enclosed, 0};
}

void ContainmentTest::gather(const RefineContext& context, std::span<const PairTask> tasks,
                             std::span<const std::uint8_t> apart)
{
    sides_.assign(tasks.size(), 0);
    parallel_chunks(tasks.size(), 256, context.threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!apart[i]) continue;
            const PairTask& t = tasks[i];
            sides_[i] = std::uint8_t((t.a->closed() && may_hold(*t.a, *t.pose_a, *t.b, *t.pose_b)) |
                                     (t.b->closed() && may_hold(*t.b, *t.pose_b, *t.a, *t.pose_a)) << 1);
        }
    });
    queries_.clear();
    for (std::uint32_t i = 0; i < sides_.size(); ++i)
        for (const bool outer_is_a : {true, false})
            if (sides_[i] & (outer_is_a ? 1 : 2)) queries_.push_back({i, outer_is_a, nullptr, false});
}

} // namespace oncollide
