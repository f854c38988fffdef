#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "trees/bounding_volume.hpp"
#include "trees/surface_index.hpp"

namespace oncollide::tools {

/// Finds parts of a mesh that are in no volume. Volumes are enlarged by 1e-12 of the extent, for rounding.
class SurfaceCover {
public:
    /// @param index  the index of `mesh`
    SurfaceCover(const Mesh& mesh, const SurfaceIndex& index, std::span<const CoveringVolume> volumes);

    /// Halves each triangle until every piece is in one volume, which is convex. Counts the triangles with an uncovered
    /// piece, and returns the area of these pieces.
    double uncovered_area(std::size_t& open_triangles) const;
    /// Tests about `count` points spread by area, and the vertices and the centre of every triangle.
    /// @param looked  number of points tested
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
    double fine_;                       ///< pieces smaller than this count as wholly covered or not at all
    std::vector<std::uint32_t> near_;   ///< volumes that may intersect a triangle, triangle by triangle
    std::vector<std::size_t> near_end_; ///< by triangle
};

} // namespace oncollide::tools
