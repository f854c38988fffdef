#include <oncollide/pipeline/refine/contact_finding.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/solids/convex_distance.hpp>
#include <oncollide/pipeline/refine/part_solid.hpp>

namespace oncollide {

void check_distance(double tolerance, double farthest)
{
    for (const auto& [what, value] : {std::pair("tolerance", tolerance), std::pair("limit", farthest)})
        if (!(value >= 0))
            throw Error(ErrorKind::usage, fmt::format("distance: a {} of {}; must be 0 or more", what, value));
}

const Eigen::Vector3d& ContactFinding::Normals::of(std::uint32_t place, const TrianglePoints& t)
{
    Kept& kept = kept_[place % kept_.size()];
    if (kept.place != place) kept = {place, unit_normal(t[0], t[1], t[2])};
    return kept.normal;
}

template <class Body>
void ContactFinding::find(Body& body_a, const Eigen::Isometry3d& pose_a, Body& body_b, const Eigen::Isometry3d& pose_b,
                          std::vector<Contact>& contacts)
{
    normals_a_.forget(), normals_b_.forget();
    const std::size_t begin = contacts.size();
    bool other_numbers = false;
    walks_.with(body_a, body_b, [&](auto& walk, auto& a, auto& b) {
        const RelativePose b_to_a(pose_a, pose_b);
        walk.all_meeting(a, b, b_to_a, pairs_);
        const auto& triangles = walk.walk().leaves();
        for (const TrianglePair& pair : pairs_) {
            const TrianglePoints of_a = triangles.points_a(pair.a), of_b = triangles.points_b(pair.b);
            const auto [ends, contact] = common_segment(of_a, of_b);
            contacts.push_back({source_of(a, pair.a),
                                source_of(b, pair.b),
                                contact == TriangleContact::crossing ? ContactKind::crossing : ContactKind::touching,
                                {pose_a * ends[0], pose_a * ends[1]},
                                pose_a.linear() * normals_a_.of(pair.a, of_a),
                                pose_a.linear() * normals_b_.of(pair.b, of_b)});
            other_numbers |= contacts.back().a != BodyPart(pair.a) || contacts.back().b != BodyPart(pair.b);
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
