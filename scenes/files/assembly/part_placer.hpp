#pragma once
#include <atomic>
#include <functional>
#include <span>

#include <oncollide/scenes/files/assembly/raw_assembly.hpp>
#include <oncollide/scenes/files/mesh/welder.hpp>

namespace oncollide {

// Shared by the readers of assemblies. Private to scenes.

/// A few bytes may place a mesh a million times, so the result's size is limited: by the bytes of all files, since a
/// file without repetition needs at least a byte per triangle and per vertex, or by a number that is allowed for any
/// file.
class ExpansionLimit {
public:
    explicit ExpansionLimit(const MeshSource& source) : source_(source) {}
    /// Throws Error{bad_data} if all threads together spent too many pieces.
    /// @param beside bytes of other files that were read
    void spend(std::uint64_t pieces, std::uint64_t beside = 0);
    /// Throws as spend(), but spends nothing: refuses work before it begins.
    void expect(std::uint64_t pieces) const { check(spent_ + pieces, 0); }

private:
    void check(std::uint64_t spent, std::uint64_t beside) const;

    const MeshSource& source_;
    std::atomic<std::uint64_t> spent_ = 0;
};

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
    explicit PartPlacer(std::size_t meshes) : by_mesh_(meshes) {}

    /// Returns false and does nothing if the pose leads out of the allowed coordinates.
    bool place(std::uint32_t node, std::uint32_t mesh, const Eigen::Affine3d& pose);
    /// The meshes that the parts placed so far need, by number in the file: one entry for each scale, shear or mirror.
    std::size_t meshes() const { return placed_.size(); }
    std::uint32_t mesh(std::size_t i) const { return placed_[i].mesh; }
    /// All placed parts.
    /// @param above by node, the parent node or no_node
    RawAssembly take(std::span<const std::uint32_t> above, const std::function<std::string(std::uint32_t)>& name_of,
                     const AddMesh& add, int threads);

private:
    /// A mesh of the file, rotated, scaled or mirrored: shared by parts that differ only in a rigid pose.
    struct Placed {
        std::uint32_t mesh;
        Eigen::Matrix3d linear, inverse;
    };
    std::pair<std::uint32_t, Eigen::Matrix3d> shared(std::uint32_t mesh, const Eigen::Matrix3d& linear);

    std::vector<std::vector<std::uint32_t>> by_mesh_; ///< indices into placed_
    std::vector<Placed> placed_;
    std::vector<RawPart> parts_;
};

} // namespace oncollide
