// The surface of a body of any kind as oriented triangles with neighbours, for manifolds.
#pragma once
#include <array>
#include <optional>
#include <vector>

#include <oncollide/base/function_ref.hpp>
#include <oncollide/narrowphase/exact/relative_pose.hpp>
#include <oncollide/narrowphase/finding.hpp>
#include <oncollide/narrowphase/inside/flat_faces.hpp>
#include <oncollide/narrowphase/model.hpp>
#include <oncollide/narrowphase/pairs/pair_worker.hpp>

namespace oncollide {

/// Triangles and vertices have the numbers of the mesh, of its joined faces, or of the terrain; features have the
/// numbers of the first mesh. A map consists of the cells around the other body; a half-space of one large triangle
/// below it; a round shape of its bounding mesh.
class PlacedSurface {
public:
    static constexpr std::uint32_t none = MeshLinks::none;
    /// Reversed triangles begin with corner 1: their edges are these stored edges.
    static constexpr int reversed_edges[] = {0, 2, 1};

    /// @param into   moves the body into the frame of the pair
    /// @param other  a box around the other body, in this body's frame; for a map and a half-space
    /// @param joins  triangles of a mesh in one plane are joined to larger ones (inside/flat_faces.hpp)
    PlacedSurface(Model& model, const RelativePose& into, const Aabb& other, bool joins);
    PlacedSurface(const PlacedSurface&) = delete;
    PlacedSurface& operator=(const PlacedSurface&) = delete;

    /// Calls visit with the hierarchy: an ObbTree or a TerrainTree.
    auto with_tree(auto visit) const { return terrain_ ? visit(*terrain_) : visit(*tree_); }
    bool empty() const { return !terrain_ && !tree_; }
    bool joined() const { return flat_ != nullptr; }
    /// The corners of a triangle, counter-clockwise seen from outside.
    std::array<std::uint32_t, 3> corners(std::uint32_t triangle) const;
    Eigen::Vector3d point(std::uint32_t vertex) const;
    TrianglePoints points(std::uint32_t triangle) const
    {
        if (terrain_) {
            const auto [u, v, w] = corners(triangle);
            return {point(u), point(v), point(w)};
        }
        const Triangle& t = mesh_->triangles[triangle];
        const auto& v = mesh_->vertices;
        const bool reversed = links_->reversed;
        return {into_(v[t[reversed]]), into_(v[t[!reversed]]), into_(v[t[2]])};
    }
    /// The triangle across the edge from corner k to the next.
    std::uint32_t across(std::uint32_t triangle, int k) const;
    /// True if the edge from corner k to the next, or an edge at the corner, sticks out; true also if that is not
    /// known.
    bool edge_sticks_out(std::uint32_t triangle, int k) const
    {
        if (!links_ || links_->ridges.empty()) return true;
        return links_->ridges[triangle] >> (links_->reversed ? reversed_edges[k] : k) & 1;
    }
    bool corner_sticks_out(std::uint32_t vertex) const
    {
        return !links_ || links_->tips.empty() || links_->tips[vertex];
    }
    /// True if a point (frame of the pair) is inside; none if it is on the surface.
    std::optional<bool> holds(const Eigen::Vector3d& point, PointLocator& locator) const;

    /// A direction in the body's frame; a point of the body in the frame of the pair.
    Eigen::Vector3d rotated_back(const Eigen::Vector3d& direction) const
    {
        return into_.rotation.transpose() * direction;
    }
    Eigen::Vector3d placed(const Eigen::Vector3d& point) const { return into_(point); }
    Eigen::Vector3d placed_back(const Eigen::Vector3d& point) const { return rotated_back(point - into_.translation); }
    /// The magnitude of the body's coordinates in the frame of the pair, metres.
    double reach() const;
    /// The support point along a direction (frame of the pair); for a terrain, and for a map without an open side
    /// here, a corner of its AABB.
    Eigen::Vector3d farthest(const Eigen::Vector3d& direction) const;
    /// How far a common point of both bodies may be from this surface, which lies before it along a direction: a shape
    /// or a cell may have it inside. 0 for a mesh and a terrain.
    double behind(const Eigen::Vector3d& point, const Eigen::Vector3d& out) const;
    /// Calls visit(point) for points of each part of the body, one per part or more, until it returns true. Returns
    /// whether it did.
    bool any_part_point(FunctionRef<bool(const Eigen::Vector3d&)> visit) const;

    FeatureBits vertex(std::uint32_t vertex) const;
    FeatureBits edge(std::uint32_t from, std::uint32_t to) const;
    FeatureBits face(std::uint32_t triangle) const;

    Model& model() const { return model_; }
    bool solid() const { return solid_; } ///< it has an inside
    bool round() const { return model_.kind() == Kind::round; }
    double extent() const { return model_.bounds().diagonal(); } ///< of the box around the body, metres
    double error() const { return error_; } ///< how far its points may be from the body's surface, metres

private:
    void add_cells(const Aabb& other);
    void add_plane(const Aabb& other);

    Model& model_;
    const RelativePose into_;
    const Mesh* mesh_ = nullptr;
    const MeshLinks* links_ = nullptr;
    const FlatFaces* flat_ = nullptr; ///< null: all triangles as they are
    ObbTree* tree_ = nullptr;
    TerrainTree* terrain_ = nullptr;
    bool solid_ = true;
    double error_ = 0;
    Mesh own_mesh_; ///< mesh of the cells or the plane
    MeshLinks own_links_;
    std::optional<ObbTree> own_tree_;
    std::vector<MapCell> corners_; ///< corners of the cells: for each vertex, with the side of its cells
    std::vector<std::pair<MapCell, std::uint32_t>> faces_; ///< for each triangle: its cell, and which of its box
};

/// A bound of the rounding of coordinates of both, metres.
double rounding_of(const PlacedSurface& a, const PlacedSurface& b);

} // namespace oncollide
