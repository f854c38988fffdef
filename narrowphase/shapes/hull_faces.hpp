#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The faces of a convex hull as polygons: triangles in one plane, to 2^-30 of the hull's size, are one face.
class HullFaces {
public:
    struct Face {
        Eigen::Vector3d normal; ///< outward, unit
        double off;             ///< the corners are at most this far from the plane through the first corner, metres
        double sharp; ///< 1 / sine of half the sharpest corner: the farthest point outside is this many times as far
                      ///< from the polygon as from the lines of its sides
        std::uint32_t first, count; ///< its corners
        std::uint32_t triangle;     ///< the smallest number of its triangles
    };

    /// @param surface  closed, convex, with outward orientation; all vertices are corners
    explicit HullFaces(const Mesh& surface);

    /// The corners of a face in order, counter-clockwise seen from outside: numbers of vertices.
    std::span<const std::uint32_t> corners(const Face& face) const
    {
        return std::span(corners_).subspan(face.first, face.count);
    }
    std::span<const Face> faces() const { return faces_; }
    /// The numbers of the faces at a vertex.
    std::span<const std::uint32_t> around(std::uint32_t vertex) const
    {
        return std::span(around_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
    }
    std::size_t bytes() const;

private:
    std::vector<Face> faces_;
    std::vector<std::uint32_t> corners_, around_, first_; ///< first_: by vertex, its first entry of around_
};

} // namespace oncollide
