#pragma once
#include <cstdint>
#include <span>
#include <string>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// Moves the vertices of a mesh, frame by frame; the triangles stay. Not thread-safe.
class Deformation {
public:
    virtual ~Deformation() = default;

    /// Writes the positions of all vertices at a time. They depend on nothing else. Throws Error{bad_data}, for a
    /// position that is not one too; the message then names the frame and the vertex.
    /// @param rest       the mesh as it was added to the scene
    /// @param time       frames, >= 0
    /// @param positions  one for each vertex
    virtual void move(const Mesh& rest, double time, std::span<Eigen::Vector3d> positions) = 0;

    std::uint64_t frames = 0; ///< number of frames after which nothing moves; 0: it never ends
    /// The entry of a scene file that makes this deformation again (JSON text; paths absolute). Empty: none does.
    std::string recipe;
};

} // namespace oncollide
