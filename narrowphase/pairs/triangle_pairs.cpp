#include <oncollide/narrowphase/pairs/triangle_pairs.hpp>

#include <algorithm>
#include <span>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/pairs/part_solid.hpp>

namespace oncollide {

namespace {

void set(Contact& contact, const SegmentsOfPairs& common, unsigned i)
{
    const auto vector = [&](const double(&v)[3][8]) { return Eigen::Vector3d(v[0][i], v[1][i], v[2][i]); };
    contact.kind = ContactKind::crossing;
    contact.ends = {vector(common.ends[0]), vector(common.ends[1])};
    contact.normal_a = vector(common.normal_a), contact.normal_b = vector(common.normal_b);
}

void set(Contact& contact, const TrianglePoints& a, const TrianglePoints& b, const Eigen::Isometry3d& pose)
{
    const auto [ends, how] = common_segment(a, b);
    contact.kind = how == TriangleContact::crossing ? ContactKind::crossing : ContactKind::touching;
    contact.ends = {pose * ends[0], pose * ends[1]};
    contact.normal_a = pose.linear() * unit_normal(a[0], a[1], a[2]);
    contact.normal_b = pose.linear() * unit_normal(b[0], b[1], b[2]);
}

} // namespace

template <class A, class B>
void triangle_contacts(TraversalOf<A, B>& walk, A& a, const Eigen::Isometry3d& pose_a, B& b,
                       const Eigen::Isometry3d& pose_b, std::vector<TrianglePair>& pairs,
                       std::vector<Contact>& contacts)
{
    const Eigen::Matrix3d rotation = pose_a.linear();
    const Eigen::Vector3d translation = pose_a.translation();
    const RigidMap place{rotation.data(), translation.data()};
    const std::size_t begin = contacts.size();
    bool other_numbers = false;
    const RelativePose b_to_a(pose_a, pose_b);
    walk.all_meeting(a, b, b_to_a, pairs);
    contacts.resize(begin + pairs.size());
    Contact* contact = contacts.data() + begin;
    auto& triangles = walk.walk().leaves();
    for (std::span<const TrianglePair> rest = pairs; !rest.empty();) {
        const auto eight = rest.first(std::min<std::size_t>(8, rest.size()));
        rest = rest.subspan(eight.size());
        SegmentsOfPairs common;
        const unsigned found = triangles.segments(eight, place, common);
        for (unsigned i = 0; i < eight.size(); ++i, ++contact) {
            const TrianglePair pair = eight[i];
            contact->a = source_of(a, pair.a), contact->b = source_of(b, pair.b);
            if (found >> i & 1)
                set(*contact, common, i);
            else
                set(*contact, triangles.points_a(pair.a), triangles.points_b(pair.b), pose_a);
            other_numbers |= contact->a.triangle != pair.a || contact->b.triangle != pair.b;
        }
    }
    if (other_numbers) sort_by_parts(contacts, begin);
}

template <class A, class B>
Distance triangle_distance(TraversalOf<A, B>& walk, A& a, const Eigen::Isometry3d& pose_a, B& b,
                           const Eigen::Isometry3d& pose_b, const DistanceOptions& options)
{
    const RelativePose b_to_a(pose_a, pose_b); // the leaf tests keep a reference
    const auto found = walk.distance(a, b, b_to_a, options.tolerance, options.cutoff);
    Distance d{.lower = found.lower, .upper = found.upper};
    if (!found.nearest) return d;
    const auto& triangles = walk.walk().leaves();
    const TrianglePoints of_a = triangles.points_a(found.nearest->a), of_b = triangles.points_b(found.nearest->b);
    if (d.upper == 0) {
        d.point_a = d.point_b = pose_a * common_segment(of_a, of_b).ends[0];
    } else {
        const NearestPoints points = nearest_points(of_a, of_b, usual_rounding(of_a, of_b));
        d.point_a = pose_a * points.a, d.point_b = pose_a * points.b;
    }
    d.a = source_of(a, found.nearest->a), d.b = source_of(b, found.nearest->b);
    return d;
}

template <class A, class B>
Contact contact_of(const A& a, const Eigen::Isometry3d& pose_a, const B& b, const Eigen::Isometry3d& pose_b,
                   TrianglePair pair)
{
    const RelativePose b_to_a(pose_a, pose_b);
    TriangleTestsOf<A, B> triangles;
    triangles.start(a, b, b_to_a);
    Contact contact;
    contact.a = source_of(a, pair.a), contact.b = source_of(b, pair.b);
    set(contact, triangles.points_a(pair.a), triangles.points_b(pair.b), pose_a);
    return contact;
}

using Pose = Eigen::Isometry3d;
using Pairs = std::vector<TrianglePair>;
using Contacts = std::vector<Contact>;
template void triangle_contacts(TraversalOf<ObbTree, ObbTree>&, ObbTree&, const Pose&, ObbTree&, const Pose&, Pairs&,
                                Contacts&);
template Distance triangle_distance(TraversalOf<ObbTree, ObbTree>&, ObbTree&, const Pose&, ObbTree&, const Pose&,
                                    const DistanceOptions&);
template void triangle_contacts(TraversalOf<ObbTree, TerrainTree>&, ObbTree&, const Pose&, TerrainTree&, const Pose&,
                                Pairs&, Contacts&);
template Distance triangle_distance(TraversalOf<ObbTree, TerrainTree>&, ObbTree&, const Pose&, TerrainTree&,
                                    const Pose&, const DistanceOptions&);
template void triangle_contacts(TraversalOf<TerrainTree, ObbTree>&, TerrainTree&, const Pose&, ObbTree&, const Pose&,
                                Pairs&, Contacts&);
template Distance triangle_distance(TraversalOf<TerrainTree, ObbTree>&, TerrainTree&, const Pose&, ObbTree&,
                                    const Pose&, const DistanceOptions&);
template void triangle_contacts(TraversalOf<TerrainTree, TerrainTree>&, TerrainTree&, const Pose&, TerrainTree&,
                                const Pose&, Pairs&, Contacts&);
template Distance triangle_distance(TraversalOf<TerrainTree, TerrainTree>&, TerrainTree&, const Pose&, TerrainTree&,
                                    const Pose&, const DistanceOptions&);

template Contact contact_of(const ObbTree&, const Pose&, const ObbTree&, const Pose&, TrianglePair);
template Contact contact_of(const ObbTree&, const Pose&, const TerrainTree&, const Pose&, TrianglePair);
template Contact contact_of(const TerrainTree&, const Pose&, const ObbTree&, const Pose&, TrianglePair);
template Contact contact_of(const TerrainTree&, const Pose&, const TerrainTree&, const Pose&, TrianglePair);

} // namespace oncollide
