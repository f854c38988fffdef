#include <oncollide/pipeline/refine/contact_finding.hpp>

#include <fmt/format.h>

#include <oncollide/base/error.hpp>
#include <oncollide/narrowphase/exact/exact_predicates.hpp>

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

void ContactFinding::find(ObbTree& a, const Eigen::Isometry3d& pose_a, ObbTree& b, const Eigen::Isometry3d& pose_b,
                          std::vector<Contact>& contacts)
{
    const RelativePose b_to_a(pose_a, pose_b);
    walk_.all_meeting(a, b, b_to_a, pairs_);
    normals_a_.forget(), normals_b_.forget();
    const auto &v = a.mesh().vertices, &w = b.mesh().vertices;
    for (const TrianglePair& pair : pairs_) {
        const Triangle &s = a.mesh().triangles[pair.a], &t = b.mesh().triangles[pair.b];
        const TrianglePoints of_a{v[s[0]], v[s[1]], v[s[2]]}, of_b{b_to_a(w[t[0]]), b_to_a(w[t[1]]), b_to_a(w[t[2]])};
        const auto [ends, contact] = common_segment(of_a, of_b);
        contacts.push_back({pair.a,
                            pair.b,
                            contact == TriangleContact::crossing ? ContactKind::crossing : ContactKind::touching,
                            {pose_a * ends[0], pose_a * ends[1]},
                            pose_a.linear() * normals_a_.of(pair.a, of_a),
                            pose_a.linear() * normals_b_.of(pair.b, of_b)});
    }
}

Distance ContactFinding::distance(ObbTree& a, const Eigen::Isometry3d& pose_a, ObbTree& b,
                                  const Eigen::Isometry3d& pose_b, double tolerance, double farthest)
{
    const auto found = walk_.distance(a, b, RelativePose(pose_a, pose_b), tolerance, farthest);
    const TrianglePair pair = found.nearest.value_or(TrianglePair{0, 0});
    return {found.lower, found.upper, pair.a, pair.b};
}

} // namespace oncollide
