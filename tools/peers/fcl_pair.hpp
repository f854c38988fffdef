#pragma once
#include <cstdint>
#include <memory>

#include <oncollide/scenes/scene.hpp>

#include "peers/narrow_peer.hpp"

namespace fcl {
template <typename Scalar>
class CollisionGeometry;
}

// FCL on single geometries and on two of them. Its headers take seconds to compile: fcl_pair.cpp, fcl_world.cpp and
// peer_fcl.cpp alone include them.
namespace oncollide::tools {

/// The nodes of FCL's trees of triangles: OBB is the fastest for yes and no, and only OBBRSS knows distances.
enum class FclNodes { obb, obbrss };

/// A geometry as FCL has it: a tree over a mesh's triangles, a primitive shape, or an octree.
using FclGeometry = std::shared_ptr<fcl::CollisionGeometry<double>>;
/// @param octree  of a map, where it was made before
FclGeometry make_fcl_geometry(const GeometryData& geometry, FclNodes nodes,
                              std::shared_ptr<const octomap::OcTree> octree = nullptr);

/// A geometry somewhere.
struct FclBody {
    const FclGeometry& geometry;
    Eigen::Isometry3d pose;
};

/// The number of contacts (of meshes, pairs of triangles that intersect), counted up to `most`.
/// @param details  with depths, places and normals, which cost time
std::size_t fcl_contacts(const FclBody& a, const FclBody& b, std::size_t most = 1, bool details = false);
/// Of the surfaces, 0 when they touch; not sure to be so when one is deep inside the other. Meshes need OBBRSS.
double fcl_distance(const FclBody& a, const FclBody& b);
/// The depth of the deepest contact; 0 when they do not collide.
double fcl_penetration(const FclBody& a, const FclBody& b);
/// FCL's own test of two triangles.
bool fcl_triangles_meet(const std::array<Eigen::Vector3d, 3>& a, const std::array<Eigen::Vector3d, 3>& b);
/// What a mesh's tree takes, as it would be with nodes of that kind; 0 for what is no mesh. Bytes.
std::size_t fcl_mesh_bytes(const FclGeometry& geometry, FclNodes as);

/// Two meshes, of which the second is moved. No details of contacts: FCL is fastest so. Thread-safe.
class FclPair final : public NarrowPeer {
public:
    FclPair(const Mesh& a, const Mesh& b, FclNodes nodes);

    /// The number of intersecting triangle pairs, counted up to `most`.
    std::size_t contacts(const Eigen::Isometry3d& b, std::size_t most = 1) const;
    bool collides(const Eigen::Isometry3d& b) override { return contacts(b) > 0; }
    void all_pairs(const Eigen::Isometry3d& b, std::vector<TrianglePair>& pairs) override;
    double distance(const Eigen::Isometry3d& b) override { return apart(b); }
    double apart(const Eigen::Isometry3d& b) const; ///< distance()

private:
    FclGeometry a_, b_;
};

} // namespace oncollide::tools
