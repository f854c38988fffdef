#pragma once
#include <array>
#include <span>
#include <vector>

#include <oncollide/robots/cover.hpp>
#include <oncollide/robots/robot.hpp>

namespace oncollide {

/// The triangles of a link's collision geometry, in the link's frame. Curved shapes are the meshes around them, which
/// are up to 0.5 % of the radius larger.
class LinkSurface {
public:
    using Corners = std::array<Eigen::Vector3d, 3>;

    explicit LinkSurface(const RobotLink& link);

    std::span<const Corners> triangles() const { return triangles_; }
    double area() const { return area_; }
    /// False: a mesh has open edges. Its inside is then where its winding number is above a half.
    bool closed() const { return closed_; }
    double size() const { return size_; } ///< diagonal of the AABB

    /// An upper bound on the signed distance of the point from the geometry; negative inside.
    double signed_distance(const Eigen::Vector3d& point) const;
    /// The nearest point of the triangles.
    Eigen::Vector3d nearest(const Eigen::Vector3d& point) const;
    /// The distance along a ray, from a point of the surface, at which it next meets a triangle; at most size().
    double thickness(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;

private:
    struct Part {
        std::size_t first, end;
        bool closed;
        const Shape* shape = nullptr;                           ///< used for distances in place of the mesh
        Eigen::Isometry3d into = Eigen::Isometry3d::Identity(); ///< moves from the link's frame to the shape's
    };
    double distance_squared(const Eigen::Vector3d& point, std::size_t first, std::size_t end,
                            Eigen::Vector3d* nearest) const;
    bool inside(const Eigen::Vector3d& point, const Part& part) const;

    std::vector<Corners> triangles_;
    std::vector<CoverSphere> around_; ///< by triangle
    std::vector<Part> parts_;
    std::vector<std::shared_ptr<const Geometry>> shapes_; ///< keeps the parts' shapes
    double area_ = 0, size_ = 0;
    bool closed_ = true;
};

double area_of(const LinkSurface::Corners& triangle);
/// Halves a triangle across its longest edge.
std::array<LinkSurface::Corners, 2> halves_of(const LinkSurface::Corners& triangle);
double longest_edge(const LinkSurface::Corners& triangle);

} // namespace oncollide
