#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include <oncollide/narrowphase/inside/point_location.hpp>

namespace oncollide {

/// Finds points inside both of two closed meshes whose triangles touch but do not cross: walls that overlap with faces
/// in line, a mesh and its copy at the same pose, an edge that passes through another.
///
/// Where surfaces meet along a segment, its middle is surrounded by regions inside and outside either mesh. Each region
/// borders on one of the faces there, so points next to both sides of each face are located, exactly. The same applies
/// where surfaces meet in a point, such as a sphere in a box: near the point a face is completely on one side of the
/// other mesh. A fan of faces around the point that meet the other mesh nowhere else is also on one side, so one
/// located point classifies the whole fan as outside.
///
/// One thread's working memory; other threads may traverse the same trees meanwhile.
class SharedInside {
public:
    /// Returns a point inside both, for b's corners as rounded in a's frame, and in that frame. None: where the meshes
    /// touch, their insides do not overlap in regions wider than 2^-19 of the contact's length and 2^-33 of the largest
    /// coordinate. Cost: if a face's plane separates the meshes, a test of each vertex. Otherwise four located points
    /// for each triangle and each segment along which other triangles meet it, two for each triangle and each point in
    /// which other triangles meet it, and one for each fan of triangles around a corner that is also a corner of the
    /// other mesh.
    /// @param not_parted  the caller knows that no face's plane separates the meshes
    std::optional<Eigen::Vector3d> find(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, bool not_parted = false);
    /// True if a point that find() tries beside the contact of this pair is inside both. Between a mesh and its copy
    /// one or two pairs suffice. Cost: up to 16 located points.
    bool is_beside(ObbTree& a, ObbTree& b, const RelativePose& b_to_a, TrianglePair pair);

    std::uint64_t points_placed() const { return placed_; } ///< by the last find()

private:
    /// A triangle of A (0) or B (1), by number, the ends of its contact with others, and the magnitude of the
    /// coordinates.
    using Tried = std::tuple<int, std::uint32_t, std::array<double, 6>, double>;

    /// A mesh, and its pose in A's frame.
    struct Side {
        ObbTree* tree;
        RelativePose to_a;
    };
    static Side first(ObbTree& a); ///< the side that defines the frame
    static TrianglePoints corners(const Side& side, std::uint32_t triangle);
    /// Sets points_ to points beside the contact of the pair, except around contacts that were seen before.
    void set_points_beside(const Side& side_a, const Side& side_b, TrianglePair pair);
    bool inside(const Side& side, const Eigen::Vector3d& point);
    std::optional<Eigen::Vector3d> beside_corners(const Side& side, const std::vector<std::uint8_t>& flags,
                                                  const Side& other);

    Traversal walk_;
    PointLocator locator_;
    std::vector<TrianglePair> contacts_;
    Traversal::CommonCorners corners_;
    std::vector<Eigen::Vector3d> points_;
    std::set<Tried> seen_;
    std::uint64_t placed_ = 0;
};

} // namespace oncollide
