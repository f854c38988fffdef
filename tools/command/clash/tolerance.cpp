#include "clash/tolerance.hpp"

#include <algorithm>

namespace oncollide::tools {
namespace {

/// The sum of distinct normals: the direction away from all faces, if there is one.
class Away {
public:
    void add(const Eigen::Vector3d& normal)
    {
        if (normal.isZero() || std::ranges::any_of(normals_, [&](const auto& n) { return n.dot(normal) > 1 - 1e-6; }))
            return;
        normals_.push_back(normal);
        sum_ += normal;
    }
    Eigen::Vector3d direction() const { return sum_.norm() > 1e-3 ? sum_.normalized() : Eigen::Vector3d::Zero(); }

private:
    std::vector<Eigen::Vector3d> normals_;
    Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
};

} // namespace

bool open_within_tolerance(const Clashes& found, const Clash& clash, double tolerance)
{
    if (!(tolerance > 0)) return false;
    if (clash.reach.depth_upper <= tolerance) return true;
    // A larger depth is real, so moving a part by the tolerance cannot separate the parts.
    if (clash.reach.depth > tolerance) return false;
    const World& world = *found.world;
    const auto [a, b] = found.pair(clash);
    Away from_b, from_a;
    for (const Contact& contact : world.pairs().contacts(a, b))
        from_b.add(contact.normal_b), from_a.add(-contact.normal_a);
    const auto parts_them = [&](const Eigen::Vector3d& direction) {
        if (direction.isZero()) return false;
        Eigen::Isometry3d pose = world.bodies().pose(a);
        pose.translation() += tolerance * direction;
        const std::vector<QueryHit> hits = world.space().overlaps(PlacedModel{world.bodies().model(a), pose});
        return std::ranges::none_of(hits, [&](const QueryHit& hit) {
            return hit.body == b && (hit.kind == ContactKind::crossing || hit.kind == ContactKind::enclosed);
        });
    };
    return parts_them(from_b.direction()) || parts_them(from_a.direction());
}

} // namespace oncollide::tools
