#pragma once
#include <atomic>
#include <functional>
#include <span>

#include <oncollide/scenes/files/assembly/raw_assembly.hpp>
#include <oncollide/scenes/files/mesh/welder.hpp>

namespace oncollide {

// What the readers of assemblies share. Private to scenes.

/// A few bytes may place a mesh a million times, so what they become is bounded: by the bytes of all files, as one that
/// places everything once needs at least a byte for each triangle and each vertex, or by a number that the smallest
/// file may grow to.
class ExpansionLimit {
public:
    explicit ExpansionLimit(const MeshSource& source) : source_(source) {}
    /// Throws Error{bad_data} when too many pieces were spent, by all threads together.
    /// @param beside bytes of other files that were read
    void spend(std::uint64_t pieces, std::uint64_t beside = 0);

private:
    const MeshSource& source_;
    std::atomic<std::uint64_t> spent_ = 0;
};

/// Triangles on their way to a mesh.
struct WeldedMesh {
    Welder weld;
    std::vector<Triangle> triangles;

    /// @param mirrored the vertices were; keeps the front at the front
    void add(Triangle triangle, bool mirrored)
    {
        if (mirrored) std::swap(triangle[1], triangle[2]);
        triangles.push_back(triangle);
    }
    RawMesh take() { return {weld.take(), std::move(triangles)}; }
};

/// Adds the mesh of that number, moved by the pose, to another one.
using AddMesh = std::function<void(std::uint32_t mesh, const Eigen::Affine3d& pose, WeldedMesh& to)>;

/// Makes parts of nodes that show meshes.
class PartPlacer {
public:
    explicit PartPlacer(std::size_t meshes) : by_mesh_(meshes) {}

    /// False, and nothing is done, where the pose leads too far away.
    bool place(std::uint32_t node, std::uint32_t mesh, const Eigen::Affine3d& pose);
    /// All that was placed.
    /// @param above by node, the node above it or no_node
    RawAssembly take(std::span<const std::uint32_t> above, const std::function<std::string(std::uint32_t)>& name_of,
                     const AddMesh& add, int threads);

private:
    /// A mesh of the file, turned, stretched or mirrored: what parts that differ only in a rigid pose share.
    struct Placed {
        std::uint32_t mesh;
        Eigen::Matrix3d linear;
    };
    std::pair<std::uint32_t, Eigen::Matrix3d> shared(std::uint32_t mesh, const Eigen::Matrix3d& linear);

    std::vector<std::vector<std::uint32_t>> by_mesh_; ///< numbers of placed_
    std::vector<Placed> placed_;
    std::vector<RawPart> parts_;
};

} // namespace oncollide
