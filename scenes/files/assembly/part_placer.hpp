#pragma once
#include <functional>
#include <span>

#include <oncollide/scenes/files/assembly/expansion_limit.hpp>
#include <oncollide/scenes/files/assembly/raw_assembly.hpp>
#include <oncollide/scenes/files/mesh/welder.hpp>

namespace oncollide {

// Shared by the readers of assemblies. Private to scenes.

/// Collects the triangles of a mesh.
struct WeldedMesh {
    Welder weld;
    std::vector<Triangle> triangles;

    /// @param mirrored the vertices are mirrored: flips the triangle to keep its front
    void add(Triangle triangle, bool mirrored)
    {
        if (mirrored) std::swap(triangle[1], triangle[2]);
        triangles.push_back(triangle);
    }
    RawMesh take() { return {weld.take(), std::move(triangles)}; }
};

/// Appends the mesh of that number, transformed by the pose, to another mesh.
using AddMesh = std::function<void(std::uint32_t mesh, const Eigen::Affine3d& pose, WeldedMesh& to)>;

/// Makes parts from nodes that have meshes.
class PartPlacer {
public:
    /// Returns false and does nothing if the pose leads out of the allowed coordinates.
    bool place(std::uint32_t node, std::uint32_t mesh, const Eigen::Affine3d& pose);
    /// The meshes that the parts placed so far need, by number in the file: one entry for each scale, shear or mirror.
    std::size_t meshes() const { return placed_.size(); }
    std::uint32_t mesh(std::size_t i) const { return placed_[i].mesh; }
    /// All placed parts.
    /// @param above for each node, the parent node or no_node
    /// @param name_of  the name of a node; empty: it has no name
    RawAssembly take(std::span<const std::uint32_t> above,
                     const std::function<std::string_view(std::uint32_t)>& name_of, const AddMesh& add, int threads);

private:
    /// A mesh of the file, rotated, scaled or mirrored: shared by parts that differ only in a rigid pose.
    struct Placed {
        std::uint32_t mesh;
        Eigen::Matrix3d linear, inverse;
    };
    std::pair<std::uint32_t, Eigen::Matrix3d> shared(std::uint32_t mesh, const Eigen::Matrix3d& linear);

    std::vector<std::vector<std::uint32_t>> by_mesh_; ///< indices into placed_; meshes at the end that were not placed
                                                      ///< have no entry
    std::vector<Placed> placed_;
    std::vector<RawPart> parts_;
};

} // namespace oncollide
