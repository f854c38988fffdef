#include <oncollide/pipeline/refine/contact_finding.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/shapes/convex_distance.hpp>
#include <oncollide/pipeline/refine/part_solid.hpp>

namespace oncollide {

void check_distance(double tolerance, double farthest)
{
    for (const auto& [what, value] : {std::pair("tolerance", tolerance), std::pair("limit", farthest)})
        if (!(value >= 0))
            throw Error(ErrorKind::usage, fmt::format("distance: a {} of {}; must be 0 or more", what, value));
}

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

template <class Body>
void ContactFinding::find(Body& body_a, const Eigen::Isometry3d& pose_a, Body& body_b, const Eigen::Isometry3d& pose_b,
                          std::vector<Contact>& contacts)
{
    const Eigen::Matrix3d rotation = pose_a.linear();
    const Eigen::Vector3d translation = pose_a.translation();
    const RigidMap place{rotation.data(), translation.data()};
    const std::size_t begin = contacts.size();
    bool other_numbers = false;
    walks_.with(body_a, body_b, [&](auto& walk, auto& a, auto& b) {
        const RelativePose b_to_a(pose_a, pose_b);
        walk.all_meeting(a, b, b_to_a, pairs_);
        contacts.resize(begin + pairs_.size());
        Contact* contact = contacts.data() + begin;
        auto& triangles = walk.walk().leaves();
        for (std::span<const TrianglePair> rest = pairs_; !rest.empty();) {
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
    });
    if (other_numbers)
        std::sort(contacts.begin() + std::ptrdiff_t(begin), contacts.end(),
                  [](const Contact& x, const Contact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
}

template <class Body>
Distance ContactFinding::distance(Body& body_a, const Eigen::Isometry3d& pose_a, Body& body_b,
                                  const Eigen::Isometry3d& pose_b, double tolerance, double farthest)
{
    return walks_.with(body_a, body_b, [&](auto& walk, auto& a, auto& b) -> Distance {
        const RelativePose b_to_a(pose_a, pose_b);
        const auto found = walk.distance(a, b, b_to_a, tolerance, farthest);
        Distance d{.lower = found.lower, .upper = found.upper};
        if (!found.nearest) return d;
        d.a = found.nearest->a, d.b = found.nearest->b;
        const auto& triangles = walk.walk().leaves();
        const TrianglePoints of_a = triangles.points_a(d.a.triangle), of_b = triangles.points_b(d.b.triangle);
        if (d.upper == 0) {
            d.point_a = d.point_b = pose_a * common_segment(of_a, of_b).ends[0];
        } else {
            const NearestPoints points = nearest_points(of_a, of_b);
            d.point_a = pose_a * points.a, d.point_b = pose_a * points.b;
        }
        d.a = source_of(a, d.a.triangle), d.b = source_of(b, d.b.triangle);
        return d;
    });
}

using Pose = Eigen::Isometry3d;
template void ContactFinding::find(ObbTree&, const Pose&, ObbTree&, const Pose&, std::vector<Contact>&);
template void ContactFinding::find(Model&, const Pose&, Model&, const Pose&, std::vector<Contact>&);
template Distance ContactFinding::distance(ObbTree&, const Pose&, ObbTree&, const Pose&, double, double);
template Distance ContactFinding::distance(Model&, const Pose&, Model&, const Pose&, double, double);

} // namespace oncollide
