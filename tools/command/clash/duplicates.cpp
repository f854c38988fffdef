#include "clash/duplicates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <variant>

#include <oncollide/scenes/model/box_corners.hpp>

namespace oncollide::tools {
namespace {

using Eigen::Vector3d;

/// The vertices of a part that triangles use, at its pose, in cubes whose side is twice the radius of searches.
class VertexGrid {
public:
    VertexGrid(const Mesh& mesh, const Eigen::Isometry3d& pose, double radius) : radius_(radius), side_(2 * radius)
    {
        points_.resize(mesh.vertices.size());
        same_as_.resize(mesh.vertices.size());
        std::vector<bool> seen(points_.size());
        for (const Triangle& triangle : mesh.triangles)
            for (const std::uint32_t v : triangle) {
                if (seen[v]) continue;
                seen[v] = true, points_[v] = pose * mesh.vertices[v], same_as_[v] = v;
                for (const std::uint32_t other : cubes_[key(points_[v])])
                    if (points_[other] == points_[v]) same_as_[v] = same_as_[other];
                cubes_[key(points_[v])].push_back(v);
            }
    }

    /// One number for all vertices at the position of v.
    std::uint32_t position(std::uint32_t v) const { return same_as_[v]; }
    /// The position of the nearest vertex within the radius; `none` without one.
    std::uint32_t nearest(const Vector3d& p) const
    {
        double least = radius_ * radius_;
        std::uint32_t found = none;
        for (unsigned corner = 0; corner < 8; ++corner) {
            // The search ball is no wider than a cube, so it reaches two cubes at most along each axis.
            const Vector3d shift(corner & 1 ? radius_ : -radius_, corner & 2 ? radius_ : -radius_,
                                 corner & 4 ? radius_ : -radius_);
            const auto cube = cubes_.find(key(p + shift));
            if (cube == cubes_.end()) continue;
            for (const std::uint32_t v : cube->second)
                if (const double d = (points_[v] - p).squaredNorm(); d < least || (d == least && same_as_[v] < found))
                    least = d, found = same_as_[v];
        }
        return found;
    }
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

private:
    struct KeyHash {
        std::size_t operator()(const std::array<double, 3>& k) const
        {
            std::size_t h = 0;
            for (const double x : k) h = (h ^ std::hash<double>()(x)) * 0x9e3779b97f4a7c15;
            return h;
        }
    };
    std::array<double, 3> key(const Vector3d& p) const
    {
        return {std::floor(p.x() / side_), std::floor(p.y() / side_), std::floor(p.z() / side_)};
    }

    double radius_, side_;
    std::vector<Vector3d> points_;
    std::vector<std::uint32_t> same_as_;
    std::unordered_map<std::array<double, 3>, std::vector<std::uint32_t>, KeyHash> cubes_;
};

Triangle sorted(Triangle t)
{
    std::ranges::sort(t);
    return t;
}

Aabb box_of(const Mesh& mesh, const Eigen::Isometry3d& pose)
{
    Aabb box;
    for (const Triangle& triangle : mesh.triangles)
        for (const std::uint32_t v : triangle) box.add(pose * mesh.vertices[v]);
    return box;
}

bool same_triangles(const Mesh& a, const Eigen::Isometry3d& pose_a, const VertexGrid& grid, const Mesh& b)
{
    std::vector<std::uint32_t> in_b(a.vertices.size(), VertexGrid::none);
    std::vector<Triangle> of_a, of_b;
    for (const Triangle& triangle : a.triangles) {
        for (const std::uint32_t v : triangle) {
            if (in_b[v] == VertexGrid::none) in_b[v] = grid.nearest(pose_a * a.vertices[v]);
            if (in_b[v] == VertexGrid::none) return false;
        }
        of_a.push_back(sorted({in_b[triangle[0]], in_b[triangle[1]], in_b[triangle[2]]}));
    }
    for (const Triangle& t : b.triangles)
        of_b.push_back(sorted({grid.position(t[0]), grid.position(t[1]), grid.position(t[2])}));
    std::ranges::sort(of_a), std::ranges::sort(of_b);
    return of_a == of_b;
}

} // namespace

bool same_geometry(const PartList& list, const Part& a, const Part& b, double tolerance)
{
    const auto &mesh_a = std::get<Mesh>(list.meshes[a.mesh]->data), &mesh_b = std::get<Mesh>(list.meshes[b.mesh]->data);
    if (mesh_a.triangles.size() != mesh_b.triangles.size()) return false;
    double largest = 0, moved = 0;
    for (unsigned k = 0; k < 8; ++k) {
        const Vector3d p = a.pose * corner_of(mesh_a.bounds, k), q = b.pose * corner_of(mesh_a.bounds, k);
        largest = std::max(largest, p.cwiseAbs().maxCoeff()), moved = std::max(moved, (p - q).norm());
    }
    const double radius = std::max({tolerance, 0x1p-22 * largest, std::numeric_limits<double>::min()});
    if (a.mesh == b.mesh && moved <= radius) return true;
    const Aabb box_a = box_of(mesh_a, a.pose), box_b = box_of(mesh_b, b.pose);
    if ((box_a.min - box_b.min).cwiseAbs().maxCoeff() > radius ||
        (box_a.max - box_b.max).cwiseAbs().maxCoeff() > radius)
        return false;
    const VertexGrid grid(mesh_b, b.pose, radius);
    return same_triangles(mesh_a, a.pose, grid, mesh_b);
}

} // namespace oncollide::tools
