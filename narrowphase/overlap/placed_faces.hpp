#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <oncollide/scenes/model/mesh.hpp>

namespace oncollide {

/// The triangles of a closed mesh at a pose, the largest first, without triangles whose corners are on one line: these
/// are no part of the surface.
class PlacedFaces {
public:
    struct Face {
        std::array<Eigen::Vector3d, 3> corners;
        Eigen::Vector3d normal; ///< unit
        Eigen::Vector3d middle; ///< on the face
        double radius;          ///< of a ball around `middle` that holds the face
    };

    /// @param origin  the point of the world that becomes (0, 0, 0). Near the geometry, coordinates round less
    PlacedFaces(const Mesh& mesh, const Eigen::Isometry3d& pose, const Eigen::Vector3d& origin);

    std::span<const Face> faces() const { return faces_; }
    const Aabb& bounds() const { return bounds_; }

    /// How often the surface winds around the point: 0 outside. None if all of some rays touch an edge.
    /// Cost: O(faces).
    std::optional<int> winding(const Eigen::Vector3d& point) const;
    /// winding(to) - winding(from), by the crossings of the segment with some faces. None if the segment touches the
    /// edge of one of them, or begins or ends on it. Exact.
    /// @param some  the numbers of all faces that can meet the segment
    std::optional<int> winding_change(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                      std::span<const std::uint32_t> some) const;

private:
    std::vector<Face> faces_;
    std::vector<std::uint32_t> all_; ///< 0, 1, 2, ...
    Aabb bounds_;
};

/// The vector from a point to the nearest point of a triangle, to rounding: some 2^-50 of the largest coordinate.
Eigen::Vector3d way_to(const std::array<Eigen::Vector3d, 3>& triangle, const Eigen::Vector3d& point);

/// The distance of a point from a triangle, as way_to().
inline double distance_of(const Eigen::Vector3d& point, const std::array<Eigen::Vector3d, 3>& triangle)
{
    return way_to(triangle, point).norm();
}

} // namespace oncollide
