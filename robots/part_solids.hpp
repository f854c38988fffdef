#pragma once
#include <cstdint>

#include <oncollide/narrowphase/hulls/inner_spheres.hpp>
#include <oncollide/narrowphase/hulls/outer_hull.hpp>
#include <oncollide/robots/group_cover.hpp>

namespace oncollide {

struct Geometry;

/// Solids around and inside a mesh. The solids decide most pairs without the part's triangles.
struct PartSolids {
    OuterHull hull;
    InnerSpheres inner;

    explicit PartSolids(const Mesh& mesh) : hull(mesh), inner(mesh) {}
};

/// A body of the environment: the box around it, and one inside if it is solid.
struct PlacedBody {
    std::uint32_t slot;
    PlacedBox box;
    Eigen::Vector3d inside; ///< half extents, about the same centre; negative: none

    PlacedBody(std::uint32_t number, const Geometry& geometry, const Aabb& own_box, const Eigen::Isometry3d& pose);
};

/// The direction that separated a pair last. It is tested first.
struct Parting {
    Eigen::Vector3f across = Eigen::Vector3f::Zero();
    std::uint8_t in_vain = 0, rest = 0; ///< tests in a row without result; tests to leave out

    bool held() const { return in_vain == 0 && !across.isZero(0); }
};

/// True if two parts are certainly farther apart than the clearance.
bool surely_apart(const PartSolids& a, const Eigen::Isometry3d& pose_a, const PartSolids& b,
                  const Eigen::Isometry3d& pose_b, double clearance, Parting& parting);
/// The same for a part and a box, along the box's own axes.
bool surely_apart(const PartSolids& a, const Eigen::Isometry3d& pose, const PlacedBox& box, double clearance);
/// As above, for every pose between `begin` and `end`: one axis separates the part and the box at both ends, and no
/// point strays more than `bent` from the straight line between its places there.
bool surely_apart(const PartSolids& a, const Eigen::Isometry3d& begin, const Eigen::Isometry3d& end,
                  const PlacedBox& box, double clearance, double bent);
/// True if the surface of a part certainly meets a solid body: a vertex is in it; or a ball inside the part meets it,
/// and the body is too large to be inside the part as a whole.
bool surely_meet(const PartSolids& a, const Eigen::Isometry3d& pose, const PlacedBody& body);

} // namespace oncollide
