#include <oncollide/pipeline/refine/non_mesh_contacts.hpp>

#include <algorithm>
#include <limits>
#include <utility>

#include <oncollide/narrowphase/walks/box_walk_queries.hpp>
#include <oncollide/pipeline/refine/part_solid.hpp>
#include <oncollide/pipeline/refine/placed_pair.hpp>

namespace oncollide {

namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr EnoughDistance nearest_of_all{.below = -std::numeric_limits<double>::infinity()};

/// A round body without a normal at the contact (its centre is there) gets the opposite of the other's normal.
void complete(Contact& c)
{
    const bool of_a = !c.normal_a.isZero(0), of_b = !c.normal_b.isZero(0);
    if (!of_a && of_b) c.normal_a = -c.normal_b;
    if (of_a && !of_b) c.normal_b = -c.normal_a;
}

/// Appends the contacts that the traversal of A and B finds, in the world frame.
/// @param swapped  A and B are the pair's b and a
template <class Walk>
void find_parts(Walk& walk, auto& a, auto& b, const Isometry3d& pose_a, const Isometry3d& pose_b, bool swapped,
                std::vector<Contact>& contacts)
{
    using Pair = typename Walk::Pair;
    constexpr bool may_be_near = requires(const Pair& pair)
    {
        walk.leaves().certainly_meet(pair);
    };
    const PlacedPair placed(pose_a, pose_b);
    if constexpr (may_be_near) walk.leaves().prepare(placed.slack, true);
    std::vector<Pair> pairs;
    walk.meetings(
        a, b, placed.b_to_a, {}, [&](const Pair& pair) { return pairs.push_back(pair), true; },
        [](const Pair&) { return false; });
    const RelativePose a_to_b(pose_b, pose_a);
    for (const Pair& pair : pairs) {
        const PartSolid of_a(a, pair.a), of_b(b, pair.b);
        const ConvexDistance points =
            ConvexPair(of_a.solid(), of_b.solid(), placed.b_to_a, placed.slack).distance(nearest_of_all);
        Contact c{source_of(a, pair.a),
                  source_of(b, pair.b),
                  ContactKind::unknown,
                  {pose_a * points.on_a, pose_a * points.on_b},
                  pose_a.linear() * of_a.normal(points.on_a),
                  pose_b.linear() * of_b.normal(a_to_b(points.on_b))};
        if constexpr (may_be_near)
            if (!walk.leaves().certainly_meet(pair)) c.kind = ContactKind::near;
        if (swapped) std::swap(c.a, c.b), std::swap(c.ends[0], c.ends[1]), std::swap(c.normal_a, c.normal_b);
        complete(contacts.emplace_back(c));
    }
}

/// Contacts of two shapes, or of a half-space and a shape.
void find_direct(const PairTask& task, std::vector<Contact>& contacts)
{
    const DirectPair pair(task);
    const Verdict verdict = pair.exact(0).verdict;
    if (verdict == Verdict::separate) return;
    const Distance points = pair.distance(nearest_of_all);
    const auto normal = [](const Model& model, const Isometry3d& pose, const Vector3d& point) -> Vector3d {
        if (model.is_half_space()) return pose.linear().col(2);
        return pose.linear() * outward_normal(model.convex(), pose.inverse(Eigen::Isometry) * point);
    };
    contacts.push_back({{},
                        {},
                        verdict == Verdict::colliding ? ContactKind::unknown : ContactKind::near,
                        {points.point_a, points.point_b},
                        normal(*task.a, *task.pose_a, points.point_a),
                        normal(*task.b, *task.pose_b, points.point_b)});
    complete(contacts.back());
}

/// Contacts of a half-space (the pair's b if `swapped`) and a body of several parts.
void find_under(const PairTask& task, bool swapped, std::vector<Contact>& contacts)
{
    const Isometry3d &plane = swapped ? *task.pose_b : *task.pose_a, &pose = swapped ? *task.pose_a : *task.pose_b;
    Model& body = swapped ? *task.a : *task.b;
    const PlacedPair placed(plane, pose);
    const RelativePose back(pose, plane);
    const auto normal_of = [&](const BodyPart& part, const Vector3d& point) {
        if (body.map()) return PartSolid(body.cells(), part.cell).normal(point);
        if (body.terrain()) return PartSolid(body.heights(), part.triangle).normal(point);
        return PartSolid(*body.obb_tree(), part.triangle).normal(point);
    };
    HalfSpacePair(body, placed.b_to_a, placed.slack).each_meeting([&](const BodyPart& part, const Vector3d& lowest) {
        const Vector3d point = plane * lowest;
        Contact c{{},
                  body.is_mesh() ? BodyPart(source_of(*body.obb_tree(), part.triangle)) : part,
                  ContactKind::unknown,
                  {point, point},
                  plane.linear().col(2),
                  pose.linear() * normal_of(part, back(lowest))};
        if (swapped) std::swap(c.a, c.b), std::swap(c.normal_a, c.normal_b);
        contacts.push_back(c);
    });
}

} // namespace

void NonMeshContacts::find(const PairTask& task, std::vector<Contact>& contacts)
{
    const std::size_t begin = contacts.size();
    // Computations are in the first body's frame: a map's, in which its cells are axis-aligned, else a shape's.
    const auto rank = [](const Model& m) { return m.is_half_space() ? 3 : m.map() ? 2 : m.shape() ? 1 : 0; };
    const bool swapped = rank(*task.b) > rank(*task.a);
    Model &a = swapped ? *task.b : *task.a, &b = swapped ? *task.a : *task.b;
    const auto find = [&](auto& walk, auto& of_a, auto& of_b) {
        const Isometry3d &pose_a = swapped ? *task.pose_b : *task.pose_a,
                         &pose_b = swapped ? *task.pose_a : *task.pose_b;
        find_parts(walk, of_a, of_b, pose_a, pose_b, swapped, contacts);
    };
    if (a.shape() && b.shape())
        find_direct(task, contacts);
    else if (a.is_half_space())
        find_under(task, swapped, contacts);
    else if (a.map() && b.map())
        find(map_map_, a.cells(), b.cells());
    else if (a.map() && b.terrain())
        find(map_terrain_, a.cells(), b.heights());
    else if (a.map() && b.shape())
        find(map_shape_, a.cells(), b.shape_tree());
    else if (a.map())
        find(map_mesh_, a.cells(), *b.obb_tree());
    else if (b.terrain())
        find(shape_terrain_, a.shape_tree(), b.heights());
    else
        find(shape_mesh_, a.shape_tree(), *b.obb_tree());
    std::sort(contacts.begin() + begin, contacts.end(),
              [](const Contact& x, const Contact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
}

} // namespace oncollide
