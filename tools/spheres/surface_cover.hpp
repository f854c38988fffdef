#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "peers/bounding_volume.hpp"
#include "spheres/surface_index.hpp"

namespace oncollide::tools {

/// Which part of a mesh is in no volume? Volumes are taken as large as they are, but for rounding: 1e-12 of the extent.
class SurfaceCover {
public:
    /// @param index  of `mesh`
    SurfaceCover(const Mesh& mesh, const SurfaceIndex& index, std::span<const CoveringVolume> volumes);

    /// Each triangle is halved until every piece is in one volume, which is convex. Counts the triangles of which a
    /// piece is left, and returns the area of such pieces.
    double uncovered_area(std::size_t& open_triangles) const;
    /// Looks at about `count` points spread by area, and at the corners and the centre of every triangle.
    /// @param looked  at so many
    std::size_t points_outside(std::size_t count, std::size_t& looked) const;

private:
    struct Piece {
        Eigen::Vector3d corner[3];
    };
    std::span<const std::uint32_t> volumes_at(std::size_t triangle) const;
    Piece piece(std::size_t triangle) const;
    static std::array<Piece, 2> halves(const Piece& piece);
    bool in_one(const Piece& piece, std::span<const std::uint32_t> candidates,
                std::vector<std::uint32_t>& reached) const;
    bool covered(const Piece& piece, std::span<const std::uint32_t> candidates, int left) const;
    double uncovered(const Piece& piece, std::span<const std::uint32_t> candidates, bool& open) const;

    const Mesh& mesh_;
    std::span<const CoveringVolume> volumes_;
    double slack_;
    double fine_;                       ///< pieces below it are covered wholly or not at all
    std::vector<std::uint32_t> near_;   ///< volumes that may reach a triangle, triangle after triangle
    std::vector<std::size_t> near_end_; ///< by triangle
};

} // namespace oncollide::tools
