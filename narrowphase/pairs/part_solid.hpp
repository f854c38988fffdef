#pragma once
#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

#include <oncollide/narrowphase/exact/exact_predicates.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/obb/map_tree.hpp>
#include <oncollide/narrowphase/obb/obb_tree.hpp>
#include <oncollide/narrowphase/obb/shape_tree.hpp>
#include <oncollide/narrowphase/obb/terrain_tree.hpp>
#include <oncollide/narrowphase/shapes/convex_distance.hpp>
#include <oncollide/narrowphase/shapes/outward_normal.hpp>
#include <oncollide/scenes/model/map/map_access.hpp>

namespace oncollide {

/// A part of a body in the user's numbering; the tree of a cooked mesh has a numbering of its own.
inline auto source_of(const auto& tree, const auto& part)
{
    if constexpr (requires { tree.source(part); })
        return tree.source(part);
    else
        return part;
}

/// A part of a body as a convex solid, in the body's frame.
class PartSolid {
public:
    PartSolid(const ObbTree& tree, std::uint32_t triangle)
        : corners_(tree.corners(triangle)), solid_(convex_of(corners_)), flat_(true)
    {
    }
    PartSolid(const TerrainTree& tree, std::uint32_t triangle)
        : corners_(tree.points(triangle)), solid_(convex_of(corners_)), flat_(true)
    {
    }
    PartSolid(const MapTree& tree, const MapCell& cell) : solid_(convex_of(MapAccess::box(tree.map(), cell))) {}
    PartSolid(const ShapeTree& tree, std::uint32_t) : solid_(tree.shape()) {}
    PartSolid(const PartSolid&) = delete; // the solid may refer to the corners
    PartSolid& operator=(const PartSolid&) = delete;

    const Convex& solid() const { return solid_; }
    /// The normal as defined by Contact.
    Eigen::Vector3d normal(const Eigen::Vector3d& point) const
    {
        return flat_ ? unit_normal(corners_[0], corners_[1], corners_[2]) : outward_normal(solid_, point);
    }

private:
    std::array<Eigen::Vector3d, 3> corners_;
    Convex solid_;
    bool flat_ = false;
};

/// Solids that meet return their points of deepest overlap.
constexpr DistanceGoal nearest_of_all{.below = -std::numeric_limits<double>::infinity()};

/// A round body without a normal at the contact (its centre is there) gets the opposite of the other's normal.
inline void complete(Contact& c)
{
    const bool of_a = !c.normal_a.isZero(0), of_b = !c.normal_b.isZero(0);
    if (!of_a && of_b) c.normal_a = -c.normal_b;
    if (of_a && !of_b) c.normal_b = -c.normal_a;
}

/// Sorts contacts[begin] and following by (a, b).
inline void sort_by_parts(std::vector<Contact>& contacts, std::size_t begin)
{
    std::sort(contacts.begin() + std::ptrdiff_t(begin), contacts.end(),
              [](const Contact& x, const Contact& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
}

} // namespace oncollide
