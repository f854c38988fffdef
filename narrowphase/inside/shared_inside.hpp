#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include <oncollide/narrowphase/inside/point_location.hpp>

namespace oncollide {

/// Finds points inside both of two closed meshes of which every two triangles only touch: walls that overlap with faces
/// in line, a mesh and its copy at the same pose, an edge that passes through another.
///
/// Where surfaces meet along a segment, its middle is surrounded by regions in and out of either mesh; each region
/// borders on one of the faces there, so a point just beside each side of each face is tried, exactly. So it is where
/// they meet in a point, as a ball in a box may: near it a face is all on one side of the other mesh, and so is a fan
/// of faces around the point that meet the other mesh nowhere else: one of them tells of all that they are outside.
///
/// One thread's working memory; others may walk the same trees meanwhile.
class SharedInside {
public:
    /// A point found is inside both, for b's corners as they round in a's frame; it is in that frame. None: where the
    /// meshes touch their insides do not, as far as regions wider than 2^-19 of the contact's length and 2^-33 of the
    /// largest coordinate go.
    /// Cost: where a face's plane parts the meshes, a look at each vertex. Else four points placed for each triangle
    /// and each segment along which others meet it, two for each triangle and each point in which others meet it, and
    /// one for each fan of triangles around a corner that is a corner of the other mesh, too.
    std::optional<Eigen::Vector3d> find(ObbTree& a, ObbTree& b, const RelativePose& b_to_a);

    std::uint64_t points_placed() const { return placed_; } ///< by the last find()

private:
    /// A triangle of A (0) or B (1), by number, and the ends of what others have in common with it, and how far away
    /// that is.
    using Tried = std::tuple<int, std::uint32_t, std::array<double, 6>, double>;

    /// A mesh, and how it moves into A's frame.
    struct Side {
        ObbTree* tree;
        RelativePose to_a;
    };
    static TrianglePoints corners(const Side& side, std::uint32_t triangle);
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
