#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/scenes/scene.hpp>

namespace fcl {
template <typename Scalar>
class CollisionGeometry;
}

// FCL on single geometries and pairs. Its headers take seconds to compile, so only fcl_pair.cpp, fcl_world.cpp and
// the peers of the laboratory include them.
namespace oncollide::tools {

/// The FCL that was loaded, with its version: the system's, or another one by its folder; or "without FCL".
std::string fcl_text();

/// The nodes of FCL's trees of triangles: OBB is the fastest for collision queries; only OBBRSS supports distances.
enum class FclNodes { obb, obbrss };

/// A geometry in FCL: a tree over a mesh's triangles, a primitive shape, or an octree.
using FclGeometry = std::shared_ptr<fcl::CollisionGeometry<double>>;
/// @param octree  the octree of a map, if it exists already
FclGeometry make_fcl_geometry(const GeometryData& geometry, FclNodes nodes,
                              std::shared_ptr<const octomap::OcTree> octree = nullptr);

/// A geometry at a pose.
struct FclBody {
    const FclGeometry& geometry;
    Eigen::Isometry3d pose;
};

/// The number of contacts (for meshes: pairs of intersecting triangles), counted up to `most`.
/// @param details  compute depths, positions and normals, which costs time
std::size_t fcl_contacts(const FclBody& a, const FclBody& b, std::size_t most = 1, bool details = false);
/// Distance of the surfaces, 0 if they touch; unreliable if one is deep inside the other. Meshes need OBBRSS.
double fcl_distance(const FclBody& a, const FclBody& b);
/// FCL's continuous queries: its defaults (sampled poses of a translation), or conservative advancement on linear
/// motions. Meshes need OBBRSS.
enum class FclSweep { sampled, advancement };
/// The time of contact of two bodies that move from their poses to the others; infinite: FCL finds none.
double fcl_time_of_contact(const FclBody& a, const Eigen::Isometry3d& to_a, const FclBody& b,
                           const Eigen::Isometry3d& to_b, FclSweep how, double tolerance);
/// Bytes of a mesh's tree if it had nodes of that kind; 0 if the geometry is not a mesh.
std::size_t fcl_mesh_bytes(const FclGeometry& geometry, FclNodes as);

/// Two meshes, of which the second moves. Without contact details, FCL's fastest mode. Thread-safe.
class FclPair {
public:
    FclPair(const Mesh& a, const Mesh& b, FclNodes nodes);

    /// The number of intersecting triangle pairs, counted up to `most`.
    std::size_t contacts(const Eigen::Isometry3d& b, std::size_t most = 1) const;
    bool collides(const Eigen::Isometry3d& b) const { return contacts(b) > 0; }
    /// Calls look(a, b) for the triangles of all intersecting pairs.
    void for_pairs(const Eigen::Isometry3d& b, FunctionRef<void(std::uint32_t a, std::uint32_t b)> look) const;
    double distance(const Eigen::Isometry3d& b) const;

private:
    FclGeometry a_, b_;
};

} // namespace oncollide::tools
